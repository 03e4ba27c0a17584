//! A sender, a receiver with a slave, `coaxle opcua`, and clients in Python.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Command, Output, Stdio};

use coaxle_test_process::{Process, output, until};
use coaxle_tests::ports::{free_endpoint, free_port};
use coaxle_tests::python;
use serde_json::{Value, json};
use tempfile::TempDir;

const SENDER: &str = "name = 'conveyor'\ncycle-time-us = 5000\n[[axis]]\nid = 1\nname = 'belt'\nunit = 'mm'\n\
                      [axis.program]\nstart-velocity = 500\nlimits = { velocity = 600, acceleration = 100, jerk = 1000 }\n\
                      steps = []\n";
const RECEIVER: &str = "name = 'saw'\ncycle-time-us = 5000\nmaster = { node = 'conveyor', axis = 1 }\n\
                        sync.time-sync.age-of-data-limit = 2000\n\
                        [[slave]]\nname = 'carriage'\nunit = 'mm'\ncouple = 'off'\n\
                        limits = { velocity = 800, acceleration = 5000, jerk = 1e5 }\n";

/// The running processes, until this is dropped.
pub(crate) struct ServedPlant {
    pub(crate) folder: TempDir,
    pub(crate) python: PathBuf,
    pub(crate) port: u16,
    pub(crate) conveyor: Process,
    pub(crate) saw: Process,
}

impl ServedPlant {
    /// Starts the nodes of a plain network; none, with a note on the output, where there is no Python for it.
    pub(crate) fn plain() -> Option<Self> {
        let [conveyor, saw] = [(); 2].map(|()| free_endpoint());
        let world = Self::start(|folder| {
            let transport = |own: &str| format!("[transport]\nlisten = ['{own}']\n");
            write(
                folder,
                "conveyor",
                &format!("{SENDER}{}", transport(&conveyor)),
            );
            let connect = format!("connect = ['{conveyor}']\n");
            write(
                folder,
                "saw",
                &format!("{RECEIVER}{}{connect}", transport(&saw)),
            );
        })?;
        world.write_server("", &format!("connect = ['{conveyor}', '{saw}']"));
        Some(world)
    }

    /// Starts the nodes of a secure network, with the operator `opcua`.
    pub(crate) fn secure() -> Option<Self> {
        let [conveyor, saw] = [(); 2].map(|()| free_port());
        Self::start(|folder| {
            let transport = |name: &str, port: u16| {
                format!("[transport]\nsecure = 'net/{name}'\nlisten = ['tls/127.0.0.1:{port}']\n")
            };
            write(
                folder,
                "conveyor",
                &format!("{SENDER}{}", transport("conveyor", conveyor)),
            );
            let connect = format!("connect = ['tls/127.0.0.1:{conveyor}']\n");
            write(
                folder,
                "saw",
                &format!("{RECEIVER}{}{connect}", transport("saw", saw)),
            );
            let init = "secure init conveyor.toml saw.toml --out net --operator opcua";
            let made = run(folder, init);
            assert!(made.status.success(), "{made:?}");
        })
    }

    fn start(prepare: impl FnOnce(&Path)) -> Option<Self> {
        let python = python::with("asyncua")?;
        let folder = tempfile::tempdir().expect("a scratch folder");
        prepare(folder.path());
        let [conveyor, saw] = [("sender", "conveyor"), ("receiver", "saw")].map(|(role, name)| {
            let mut command = coaxle(folder.path(), &format!("{role} {name}.toml"));
            Process::start(
                name,
                &mut command,
                &folder.path().join(format!("{name}.log")),
            )
        });
        Some(Self {
            folder,
            python,
            port: free_port(),
            conveyor,
            saw,
        })
    }

    /// Writes the config of a server without certificates.
    pub(crate) fn write_server(&self, more: &str, transport: &str) {
        let port = self.port;
        let text = format!(
            "name = 'opcua'\nendpoint = {{ listen = '127.0.0.1:{port}', security = 'none' }}\n\
             rights = {{ anonymous-commands = true }}\n{more}\n[transport]\n{transport}\n"
        );
        write(self.folder.path(), "opcua", &text);
    }

    pub(crate) fn server(&self) -> Process {
        let mut command = coaxle(self.folder.path(), "opcua opcua.toml");
        Process::start("opcua", &mut command, &self.folder.path().join("opcua.log"))
    }

    /// Output of the tool.
    pub(crate) fn run(&self, line: &str) -> Output {
        run(self.folder.path(), line)
    }

    /// A client, named by its log, with certificates of a folder if any.
    pub(crate) fn client(&self, log: &str, certificates: Option<&str>) -> PythonClient {
        let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("python/opcua.py");
        let url = format!("opc.tcp://127.0.0.1:{}/", self.port);
        let mut command = Command::new(&self.python);
        command
            .arg("-B")
            .arg(script)
            .arg(url)
            .current_dir(self.folder.path());
        if let Some(name) = certificates {
            command.args([name, &format!("pki/clients/{name}")]);
        }
        let file = |ending| self.folder.path().join(format!("{log}.{ending}"));
        let out = File::create(file("out")).expect("a file");
        command.stdin(Stdio::piped()).stdout(out);
        let process = Process::start(log, &mut command, &file("log"));
        let input = process.take_stdin().expect("it listens");
        PythonClient {
            process,
            input,
            out: file("out"),
            seen: 0,
        }
    }
}

/// A client in Python.
pub(crate) struct PythonClient {
    process: Process,
    input: ChildStdin,
    out: PathBuf,
    /// Lines of the output that were read as responses.
    seen: usize,
}

impl PythonClient {
    /// Everything that it has printed.
    pub(crate) fn printed(&self) -> Vec<Value> {
        let text = std::fs::read_to_string(&self.out).unwrap_or_default();
        // The last line may still be in the course of being written.
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole
            .lines()
            .filter_map(|line| serde_json::from_str(line).ok())
            .collect()
    }

    /// Waits for the next response: a line with one of these names.
    pub(crate) fn response(&mut self, what: &str, names: &[&str]) -> Value {
        let mut found = None;
        until(what, || {
            let all = self.printed();
            let next = all.iter().enumerate().skip(self.seen);
            let mut next =
                next.filter(|(_, line)| names.iter().any(|name| line.get(name).is_some()));
            found = next.next().map(|(place, line)| (place, line.clone()));
            found.is_some()
        });
        let (place, line) = found.expect("it was found");
        self.seen = place + 1;
        line
    }

    /// Has it do something, and returns the result.
    pub(crate) fn ask(&mut self, request: &Value) -> Value {
        writeln!(self.input, "{request}").expect("it listens");
        let response = self.response(&request.to_string(), &["done", "failed"]);
        response.get("done").cloned().unwrap_or(response)
    }

    pub(crate) fn read(&mut self, path: &str) -> Value {
        self.ask(&json!({ "do": "read", "path": path }))
    }

    pub(crate) fn call(&mut self, path: &str, arguments: &Value) -> Value {
        self.ask(&json!({ "do": "call", "path": path, "arguments": arguments }))
    }

    /// Arguments of a method by their names: null for all others.
    pub(crate) fn call_named(&mut self, path: &str, named: &Value) -> Value {
        let names = self.ask(&json!({ "do": "arguments", "path": path }));
        let names = names.as_array().expect("arguments").iter();
        let values = names.map(|name| named.get(name.as_str().unwrap_or_default()).cloned());
        let values: Vec<_> = values.map(Option::unwrap_or_default).collect();
        self.call(path, &values.into())
    }

    /// Waits until a variable has a value that fits.
    pub(crate) fn until(&mut self, path: &str, fits: impl Fn(&Value) -> bool) {
        until(path, || fits(&self.read(path)));
    }

    /// Lets it end by itself, as one without a connection does.
    pub(crate) fn may_end(&self) {
        self.process.may_end();
    }

    /// Ends it.
    pub(crate) fn end(self) {
        let Self { process, input, .. } = self;
        drop(input);
        let ended = process.wait();
        assert!(ended.success(), "{}", process.log());
    }
}

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(format!("{name}.toml")), text).expect("a config");
}

fn coaxle(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
    command
        .args(line.split_whitespace())
        .current_dir(folder)
        .stdin(Stdio::null());
    command
}

fn run(folder: &Path, line: &str) -> Output {
    output(&mut coaxle(folder, line))
}
