//! A sender, a receiver, and LinuxCNC's realtime threads of an ordinary user with the components built for them.

use std::fs::File;
use std::os::unix::fs::chown;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};

use coaxle_test_process::{Process, output, until};
use coaxle_tests::ports::free_endpoint;
use tempfile::TempDir;

/// LinuxCNC refuses to run as root: this is who runs it.
const NOBODY: u32 = 65534;
const MODULES: &str = "/usr/lib/linuxcnc/modules";
const HEADERS: &str = "/usr/include/linuxcnc";
const COMPONENTS: [&str; 2] = ["coaxle_axis", "coaxle_lock"];
pub(crate) const TOOL: &str = env!("CARGO_BIN_EXE_coaxle-under-test");
const AXES: [&str; 2] = ["conveyor", "carriage"];

const SENDER: &str = "name = 'conveyor'\ncycle-time-us = 1000\n[lab]\nclock = { drift-ppm = 200 }\n[[axis]]\nid = 1\nname = 'belt'\n\
                      [axis.program]\nstart-velocity = 500\nlimits = { velocity = 600, acceleration = 100, jerk = 1000 }\n\
                      steps = []\n";

/// Samples before and after the servo thread is locked: more than a beat of five seconds at 200 ppm, then enough for an average.
const SCRIPT: &str = "source try.hal
setp conveyor.max-age 10
setp carriage.max-age 10
setp carriage.bypass 1
setp coaxle-lock.enable 0
loadusr -w sh until.sh conveyor.velocity 500
loadusr -w sh until.sh carriage.velocity 250
loadusr -w sleep 2
setp sampler.0.enable 1
loadusr -w halsampler -t -n 7000 free
setp sampler.0.enable 0
setp coaxle-lock.enable 1
loadusr -w sh until.sh coaxle-lock.state 2
setp sampler.0.enable 1
loadusr -w halsampler -t -n 4000 locked
";
/// Waits until a pin has a value, to a thousandth of it.
const UNTIL: &str = "until halcmd getp $1 | awk -v to=$2 '{ exit !($1 > 0.999 * to && $1 < 1.001 * to) }'; do sleep 0.2; done\n";

/// A folder in which LinuxCNC's threads run as an ordinary user. There is one HAL on a machine: one test at a time has it.
pub(crate) struct HalFolder {
    folder: TempDir,
    _turn: MutexGuard<'static, ()>,
}

static HAL: Mutex<()> = Mutex::new(());

/// The running nodes, until this is dropped.
pub(crate) struct World {
    _nodes: [Process; 2],
    folder: HalFolder,
}

/// A cycle of the servo thread.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Number of the cycle in this sampling.
    pub(crate) number: u32,
    /// Ideal start of the cycle, s.
    pub(crate) time: f64,
    /// Age of the newest set values then, s.
    age: f64,
    /// Position of the far axis, mm.
    pub(crate) position: f64,
    /// Its velocity, mm/s.
    pub(crate) velocity: f64,
    /// Position of the slave that shows what it has received, mm.
    pub(crate) carriage_position: f64,
    is_ok: bool,
    /// Time by which the next cycle begins later, ns.
    pub(crate) correction: i32,
}

impl Sample {
    /// True if neither the receiver nor the thread was late.
    pub(crate) fn is_on_time(&self) -> bool {
        self.is_ok && self.age.abs() < 2.5e-3
    }
}

impl HalFolder {
    /// Makes it; none, with a note on the output, where LinuxCNC cannot be tested.
    pub(crate) fn new() -> Option<Self> {
        if let Some(reason) = obstacle() {
            println!("not tested: {reason}");
            return None;
        }
        let folder = tempfile::tempdir().expect("a scratch folder");
        chown(folder.path(), Some(NOBODY), Some(NOBODY)).expect("root may do so");
        // A test that has failed has ended its threads, too.
        let _turn = HAL.lock().unwrap_or_else(PoisonError::into_inner);
        Self::unload();
        Some(Self { folder, _turn })
    }

    /// Ends threads that a test has left because it was ended itself: there may be one LinuxCNC at a time.
    fn unload() {
        let script = format!(
            "for _ in 1 2 3 4 5 6 7 8 9; do pkill -U {NOBODY} -x rtapi_app || break; sleep 0.3; done"
        );
        // A machine without `pkill` has nothing left, or says so: "Realtime already running".
        let _ = output(Command::new("sh").args(["-c", &script]));
    }

    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        std::fs::write(self.file(name), text).expect("a file");
    }

    /// Starts a node of a config; it ends when this is dropped.
    pub(crate) fn node(&self, role: &str, config: &str, options: &[&str]) -> Process {
        let mut command = self.command(role, config, options);
        Process::start(role, &mut command, &self.file(&format!("{role}.log")))
    }

    /// The command that starts it.
    pub(crate) fn command(&self, role: &str, config: &str, options: &[&str]) -> Command {
        let file = format!("{role}.toml");
        self.write(&file, config);
        let mut command = Command::new(TOOL);
        command.arg(role).arg(self.file(&file)).args(options);
        command
    }

    /// Starts LinuxCNC's threads with a script.
    pub(crate) fn threads(&self, script: &str) -> Process {
        let mut run = self.as_nobody("halrun");
        run.args(["-f", script]);
        run.stdout(File::create(self.file("halrun.out")).expect("a file"));
        Process::start("halrun", &mut run, &self.file("halrun.log"))
    }

    /// A command of the same user that loads no modules.
    pub(crate) fn beside_as_nobody(&self, command: &str) -> Command {
        let mut run = Command::new("setpriv");
        let user = NOBODY.to_string();
        run.args([
            "--reuid",
            &user,
            "--regid",
            &user,
            "--clear-groups",
            command,
        ]);
        run.env("HOME", self.path()).current_dir(self.path());
        run
    }

    /// A command of an ordinary user with a home, whose modules of LinuxCNC are those of the machine and the components.
    pub(crate) fn as_nobody(&self, command: &str) -> Command {
        let folder = self.path().display();
        let script = format!(
            "set -e\nmkdir -p modules\ncp -rn {MODULES}/. modules/\ncp -f coaxle_*.so modules/ 2>/dev/null || true\n\
             mount --bind modules {MODULES}\nexport HOME={folder}\n\
             exec setpriv --reuid {NOBODY} --regid {NOBODY} --clear-groups \"$@\""
        );
        // The modules are mounted for this command alone: the machine's own stay what they are.
        let mut run = Command::new("unshare");
        run.args(["--mount", "sh", "-c", &script, "sh", command]);
        run.current_dir(self.path());
        run
    }
}

impl Drop for HalFolder {
    fn drop(&mut self) {
        Self::unload();
    }
}

impl World {
    /// Starts the nodes; none, with a note on the output, where LinuxCNC cannot be tested.
    pub(crate) fn start() -> Option<Self> {
        let folder = HalFolder::new()?;
        let [conveyor, cnc] = [(); 2].map(|()| free_endpoint());
        let config = receiver_config(folder.path());
        let nodes = [
            folder.node("sender", SENDER, &["--lab", "--listen", &conveyor]),
            folder.node(
                "receiver",
                &config,
                &["--listen", &cnc, "--connect", &conveyor],
            ),
        ];
        for axis in AXES {
            let memory = folder.path().join(format!("memory-{axis}"));
            until("the receiver has made its memories", || memory.exists());
            chown(memory, Some(NOBODY), Some(NOBODY)).expect("root may do so");
        }
        Some(Self {
            _nodes: nodes,
            folder,
        })
    }

    /// Compiles the components, once with all warnings as errors and once as LinuxCNC does it.
    pub(crate) fn compile_components(&self) {
        let library = std::env::current_exe().expect("the test's own path");
        let library = library.with_file_name("libcoaxle_c.so");
        std::fs::copy(library, self.folder.file("libcoaxle.so.1"))
            .expect("it is built with the test");
        for component in COMPONENTS {
            let source = shipped(&format!("linuxcnc/{component}.c"));
            std::fs::copy(&source, self.folder.file(&format!("{component}.c"))).expect("a copy");
            succeeds(
                Command::new("cc")
                    .args(["-std=c11", "-Wall", "-Wextra", "-Werror"])
                    .args([
                        "-O2",
                        "-fsyntax-only",
                        "-DRTAPI",
                        "-DUSPACE",
                        "-DSIM",
                        "-D__MODULE__",
                        "-D_GNU_SOURCE",
                        "-isystem",
                    ])
                    .arg(HEADERS)
                    .arg("-I")
                    .arg(shipped("include"))
                    .arg(source),
            );
        }
        let folder = self.folder.path().display();
        let mut compile = self.folder.as_nobody("halcompile");
        compile.env(
            "LDFLAGS",
            format!("-Wl,--no-as-needed {folder}/libcoaxle.so.1 -Wl,-rpath,{folder}"),
        );
        std::fs::copy(shipped("include/coaxle.h"), self.folder.file("coaxle.h")).expect("a copy");
        succeeds(
            compile
                .arg("--compile")
                .args(COMPONENTS.map(|name| format!("{name}.c"))),
        );
    }

    /// Runs LinuxCNC's threads: samples without a lock, and with one.
    pub(crate) fn run(&self) -> [Vec<Sample>; 2] {
        for script in ["axes.hal", "try.hal"] {
            let text = std::fs::read_to_string(shipped(&format!("linuxcnc/{script}")));
            let memories = format!("{}/memory-", self.folder.path().display());
            let text = text
                .expect("a script")
                .replace("/dev/shm/coaxle-", &memories);
            std::fs::write(self.folder.file(script), text).expect("a script");
        }
        self.folder.write("test.hal", SCRIPT);
        self.folder.write("until.sh", UNTIL);
        let threads = self.folder.threads("test.hal");
        threads.may_end();
        assert!(threads.wait().success(), "{}", threads.log());
        ["free", "locked"].map(|name| self.samples(name))
    }

    fn samples(&self, name: &str) -> Vec<Sample> {
        let text = std::fs::read_to_string(self.folder.file(name)).expect("samples");
        let samples: Vec<_> = text.lines().filter_map(sample).collect();
        assert!(samples.len() > 1_000, "{name}: {} samples", samples.len());
        samples
    }
}

/// A line of `halsampler`; none for its notes of samples that were lost.
fn sample(line: &str) -> Option<Sample> {
    let words: Vec<_> = line.split_whitespace().collect();
    let [
        number,
        time,
        age,
        position,
        velocity,
        carriage,
        _,
        ok,
        carriage_ok,
        _,
        _,
        correction,
    ] = words[..]
    else {
        return None;
    };
    Some(Sample {
        number: number.parse().ok()?,
        time: time.parse().ok()?,
        age: age.parse().ok()?,
        position: position.parse().ok()?,
        velocity: velocity.parse().ok()?,
        carriage_position: carriage.parse().ok()?,
        is_ok: ok == "1" && carriage_ok == "1",
        correction: correction.parse().ok()?,
    })
}

/// What keeps this machine from running the test.
fn obstacle() -> Option<&'static str> {
    let runs = |program: &str, option: &str| Command::new(program).arg(option).output().is_ok();
    if !runs("halcompile", "--help") || !Path::new(HEADERS).exists() {
        Some("linuxcnc-uspace-dev is missing")
    } else if !rustix::process::geteuid().is_root() {
        Some("no right to mount HAL components for the time of a test")
    } else if !output(Command::new("unshare").args(["--mount", "true"]))
        .status
        .success()
    {
        Some("no right to make namespaces")
    } else {
        None
    }
}

/// The shipped config, with memories in this folder, and with tolerances of a machine that compiles something else meanwhile.
fn receiver_config(folder: &Path) -> String {
    let config = std::fs::read_to_string(shipped("linuxcnc/receiver.toml")).expect("a config");
    config
        .replace("/dev/shm/coaxle-", &format!("{}/memory-", folder.display()))
        .replace(
            "following-error-window = 50",
            "following-error-window = 1e6",
        )
        .replace("max-silent-cycles = 1000", "max-silent-cycles = 100000")
}

pub(crate) fn shipped(name: &str) -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.join("../common/c").join(name)
}

fn succeeds(command: &mut Command) {
    let output = output(command);
    assert!(output.status.success(), "{command:?}: {output:?}");
}
