//! A common time by a real PTP service, over a pair of virtual cards in network namespaces.

use std::path::Path;
use std::process::{Command, Stdio};

use coaxle_test_process::{Process, output, until};
use coaxle_tests::ports::free_port;

use crate::watched::line::{Line, log_text, printed};

/// Socket of `ptp4l`, by which others ask it.
const SERVICE: &str = "/var/run/ptp4l";

/// A grandmaster and a PTP service of this machine that follows it, each in a network namespace, both over one kernel's clock.
struct Ptp {
    namespaces: [String; 2],
    grandmaster: Option<Process>,
    service: Option<Process>,
}

impl Ptp {
    /// Starts both; none, with a note on the output, where that is not possible.
    #[expect(clippy::print_stdout, reason = "so a test says that it tested nothing")]
    fn start(folder: &Path) -> Option<Self> {
        let not = |why: &str| println!("not tested: {why}");
        let version = Command::new("ptp4l").arg("-v").output();
        if version.is_err() {
            not("ptp4l is not installed");
            return None;
        }
        if Path::new(SERVICE).exists() {
            not("a ptp4l of this machine runs, or has left its socket");
            return None;
        }
        let own = std::process::id();
        let mut ptp = Self {
            namespaces: ["g", "s"].map(|which| format!("coaxle-{which}-{own}")),
            grandmaster: None,
            service: None,
        };
        if !ptp.make_ways() {
            not("no right to make network namespaces");
            return None;
        }
        let start = |namespace: &str, log: &str, options: &[&str]| {
            let mut command = Command::new("ip");
            command.args([
                "netns",
                "exec",
                namespace,
                "ptp4l",
                "-S",
                "-m",
                "-i",
                "ptp",
                "--free_running",
                "1",
            ]);
            command.args(options).stdin(Stdio::null());
            let log = folder.join(log);
            command.stdout(std::fs::File::create(&log).expect("a log"));
            Process::start("ptp4l", &mut command, &log.with_extension("errors"))
        };
        let elsewhere = folder.join("grandmaster");
        let elsewhere = elsewhere.to_str().expect("UTF-8");
        let [of_grandmaster, of_service] = ptp.namespaces.clone();
        ptp.grandmaster = Some(start(
            &of_grandmaster,
            "grandmaster.log",
            &["--uds_address", elsewhere],
        ));
        ptp.service = Some(start(&of_service, "service.log", &["--slaveOnly", "1"]));
        Some(ptp)
    }

    /// Makes the namespaces, and a pair of cards between them.
    fn make_ways(&self) -> bool {
        let [one, other] = &self.namespaces;
        let mut all = vec![
            format!("netns add {one}"),
            format!("netns add {other}"),
            format!("link add ptp netns {one} type veth peer name ptp netns {other}"),
        ];
        for (n, namespace) in self.namespaces.iter().enumerate() {
            all.push(format!(
                "-n {namespace} addr add 10.211.0.{}/24 dev ptp",
                n + 1
            ));
            all.push(format!("-n {namespace} link set ptp up"));
        }
        all.iter().all(|words| {
            let done = Command::new("ip").args(words.split(' ')).output();
            done.is_ok_and(|done| done.status.success())
        })
    }
}

impl Drop for Ptp {
    fn drop(&mut self) {
        (self.service, self.grandmaster) = (None, None);
        for namespace in &self.namespaces {
            let _ = Command::new("ip")
                .args(["netns", "delete", namespace])
                .output();
        }
        // Killed, it leaves its socket behind.
        let _ = std::fs::remove_file(SERVICE);
    }
}

#[test]
fn the_time_of_a_ptp_service_is_followed_until_it_is_gone() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let Some(mut ptp) = Ptp::start(folder.path()) else {
        return;
    };
    let mut line = Line {
        folder,
        endpoints: Vec::new(),
        nodes: Vec::new(),
    };
    let port = free_port();
    let sender = format!(
        "cycle-time-us = 2000\ntiming.listen = '127.0.0.1:{port}'\ntime = {{ ptp = 'auto', bound-us = 0.5 }}\n\
         [[axis]]\nid = 3\nname = 'belt'\n[axis.program]\nlimits = {{ velocity = 100, acceleration = 100, jerk = 1000 }}\nsteps = []\n"
    );
    line.start("sender", "belt", &sender);
    let receiver = format!(
        "cycle-time-us = 2000\nmaster = {{ node = 'belt', axis = 3 }}\ntiming.connect = '127.0.0.1:{port}'\ntime.ptp = 'auto'\n"
    );
    line.start("receiver", "saw", &receiver);
    let value = |signal: &str| {
        let got = line.run_tool(&["get", "saw", &format!("belt.{signal}")]);
        printed(&got).trim().to_owned()
    };
    until("it is followed", || value("common_time_state") == "in-use");
    assert_eq!(value("common_time_lack"), "none");
    assert!(log_text(&line.log("saw")).contains("common time: of the grandmaster"));
    let doctor = output(Command::new(env!("CARGO_BIN_EXE_coaxle-under-test")).args([
        "doctor",
        "--measure",
        "1s",
    ]));
    let doctor = printed(&doctor);
    assert!(
        doctor.contains("good: common time: ptp4l follows the grandmaster"),
        "{doctor}"
    );
    ptp.service = None;
    until("it is left", || value("common_time_lack") == "not-here");
    // Its newest readings count for two seconds more.
    until("it is held", || value("common_time_state") == "held");
    assert_eq!(value("synced"), "true");
}
