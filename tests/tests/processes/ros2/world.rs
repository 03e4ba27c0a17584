//! A sender, a receiver with a slave, `coaxle ros2`, and Python on the side of ROS.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Command, Stdio};

use coaxle_test_process::{Process, output, until};
use coaxle_tests::ports::free_endpoint;
use coaxle_tests::python;
use serde_json::Value;
use tempfile::TempDir;

const SENDER: &str = "name = 'conveyor'\ncycle-time-us = 5000\n[[axis]]\nid = 1\nname = 'belt'\nunit = 'mm'\n\
                      [axis.program]\nstart-velocity = 500\nlimits = { velocity = 600, acceleration = 100, jerk = 1000 }\n\
                      steps = []\n";
const RECEIVER: &str = "name = 'saw'\ncycle-time-us = 5000\npublish-far-axes = true\n\
                        [[far]]\nnode = 'conveyor'\naxes = [{ id = 1, name = 'belt', unit = 'mm' }]\n\
                        [[slave]]\nname = 'carriage'\ncouple = 'off'\n\
                        limits = { velocity = 500, acceleration = 5000, jerk = 1e5, max-position = 800 }\n";

/// The running processes, until this is dropped.
pub(crate) struct World {
    bridge: Process,
    _others: Vec<Process>,
    folder: TempDir,
    told: ChildStdin,
    saw: String,
}

impl World {
    /// Starts the processes; none, with a note on the output, where there is no Python for it.
    pub(crate) fn start(options: &[&str]) -> Option<Self> {
        let python = python::with("rosbags, zenoh")?;
        let folder = tempfile::tempdir().expect("a scratch folder");
        let [conveyor, saw, ros] = [(); 3].map(|()| free_endpoint());
        let mut others = vec![
            node(&folder, "sender", SENDER, &["--listen", &conveyor]),
            node(
                &folder,
                "receiver",
                RECEIVER,
                &["--listen", &saw, "--connect", &conveyor],
            ),
        ];
        let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("python/ros2.py");
        let mut ros_side = Command::new(python);
        ros_side.arg("-B").arg(script).args([&ros, "7", "/line1"]);
        let ros_side = logged(&folder, "python", &mut ros_side);
        let told = ros_side.take_stdin().expect("it listens");
        others.push(ros_side);
        let mut bridge = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
        bridge.arg("ros2").args(options);
        bridge.args([
            "--connect",
            &conveyor,
            "--connect",
            &saw,
            "--ros-connect",
            &ros,
        ]);
        let bridge = logged(&folder, "bridge", &mut bridge);
        Some(Self {
            bridge,
            _others: others,
            folder,
            told,
            saw,
        })
    }

    /// Messages that Python has received so far.
    pub(crate) fn received(&self) -> Vec<Value> {
        let text = read(self.folder.path(), "python.out");
        // The last line may still be in the course of being written.
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole
            .lines()
            .filter_map(|line| serde_json::from_str(line).ok())
            .collect()
    }

    /// Log of the tool so far.
    pub(crate) fn log(&self) -> String {
        self.bridge.log()
    }

    /// Gives a slave power, which no trajectory does.
    pub(crate) fn power(&self, node: &str, slave: &str) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
        command.args([
            "command",
            node,
            slave,
            "power",
            "on",
            "--connect",
            &self.saw,
        ]);
        let output = output(&mut command);
        assert!(output.status.success(), "{output:?}");
    }

    /// Has Python publish a trajectory.
    pub(crate) fn publish_trajectory(&mut self, told: &Value) {
        writeln!(self.told, "{told}").expect("it listens");
    }

    /// Waits until the messages that Python has received meet a condition.
    pub(crate) fn until(&self, what: &str, mut is_so: impl FnMut(&[Value]) -> bool) {
        until(what, || is_so(&self.received()));
    }

    /// Sends Ctrl-C. Returns the exit code.
    pub(crate) fn interrupt(&mut self) -> Option<i32> {
        self.bridge.signal("INT");
        self.bridge.wait().code()
    }
}

fn node(folder: &TempDir, role: &str, config: &str, network: &[&str]) -> Process {
    let file = folder.path().join(format!("{role}.toml"));
    std::fs::write(&file, config).expect("a config");
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
    command.arg(role).arg(file).args(network);
    logged(folder, role, &mut command)
}

fn logged(folder: &TempDir, name: &str, command: &mut Command) -> Process {
    let file = |ending| folder.path().join(format!("{name}.{ending}"));
    let out = File::create(file("out")).expect("a file");
    command.stdin(Stdio::piped()).stdout(out);
    Process::start(name, command, &file("log"))
}

fn read(folder: &Path, file: &str) -> String {
    let bytes = std::fs::read(folder.join(file)).unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}
