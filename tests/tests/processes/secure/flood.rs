//! Floods of connects beside a secure line of three: a sender, two followers, and members that come meanwhile.

use std::io::Write as _;
use std::net::TcpStream;
use std::thread::JoinHandle;
use std::time::Duration;

use coaxle_test_process::{Process, until};
use coaxle_tests::ports::free_port;
use serde_json::Value;

use super::processes::{output_of, start};

/// Slow enough that a busy machine skips few cycles.
const CYCLE_TIME_US: u32 = 10_000;
/// Frames of half a second: the statuses of sender and followers are that far apart in time, at most.
const FRAMES_OF_SKEW: i64 = 50;
/// Descriptors of connections without a complete handshake, at most (`common/zenoh-link-tls/src/accept.rs`).
const MOST_DESCRIPTORS: usize = 256;
/// Descriptors of links, files and polls that come beside: members of the test, and their status commands.
const OTHER_DESCRIPTORS: usize = 24;
/// Time in which a new member is in. Three seconds is the goal, which a quiet machine keeps by far.
const MOST_SECONDS: f64 = 10.0;

/// A kind of connect.
#[derive(Clone, Copy, Debug)]
enum Connect {
    /// Five bytes that are no TLS, and the end.
    Bogus,
    /// Nothing, and no end.
    Silent,
    /// The head of a ClientHello, and no end.
    Slow,
}

struct Line {
    folder: tempfile::TempDir,
    port: u16,
    sender: Process,
    _followers: [Process; 2],
}

/// Counts of a moment: cycles that the sender skipped, and frames that each follower misses.
struct Counts {
    skipped: i64,
    lost: [i64; 2],
}

impl Line {
    fn start() -> Self {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let ports = [(); 3].map(|()| free_port());
        let [port, saw, press] = ports;
        let write = |name: &str, text: String| {
            let head = format!("name = '{name}'\ncycle-time-us = {CYCLE_TIME_US}\n");
            let file = folder.path().join(format!("{name}.toml"));
            std::fs::write(file, head + &text).expect("a config");
        };
        let secure = |name: &str| format!("[transport]\nsecure = 'net/{name}'\n");
        let axis = "[[axis]]\nid = 1\nname = 'belt'\n\
            program = { start-velocity = 5, limits = { velocity = 10, acceleration = 10, jerk = 10 } }\n";
        let listen = |port: u16| format!("listen = ['tls/127.0.0.1:{port}']\n");
        write("line", axis.to_owned() + &secure("line") + &listen(port));
        let slave = "master = { node = 'line' }\n[[slave]]\nname = 'carriage'\ncouple = 'off'\n\
            limits = { velocity = 500, acceleration = 2000, jerk = 1e5 }\n";
        let follower = |name: &str, listens: &str| {
            let connect = format!("connect = ['tls/127.0.0.1:{port}']\n");
            write(name, slave.to_owned() + &secure(name) + listens + &connect);
        };
        follower("saw", &listen(saw));
        follower("press", &listen(press));
        follower("late", "");
        let init = "secure init line.toml saw.toml press.toml late.toml --out net --operator anna";
        let (text, good) = output_of(folder.path(), init);
        assert!(good, "{text}");
        let sender = start(folder.path(), "sender", "line");
        let followers = ["saw", "press"].map(|name| start(folder.path(), "receiver", name));
        for follower in &followers {
            until("the line is followed", || follower.logged("health is "));
        }
        Self {
            folder,
            port,
            sender,
            _followers: followers,
        }
    }

    /// Statuses of all nodes, by name.
    fn statuses(&self) -> Vec<Value> {
        let command = "status --secure net/anna --format json --quiet";
        let (text, good) = output_of(self.folder.path(), command);
        assert!(good, "{text}");
        // Lines of the log may follow.
        let mut values = serde_json::Deserializer::from_str(&text).into_iter();
        let statuses = values.next().and_then(Result::ok);
        statuses.unwrap_or_else(|| panic!("{text}"))
    }

    fn counts(&self) -> Counts {
        let statuses = self.statuses();
        let of = |name: &str| {
            let status = statuses.iter().find(|status| status["node"] == name);
            status.unwrap_or_else(|| panic!("{name}: {statuses:?}"))
        };
        let lost = |name: &str| of(name)["far"]["line"]["lost"].as_i64().expect("a count");
        Counts {
            skipped: of("line")["overruns"].as_i64().expect("a count"),
            lost: [lost("saw"), lost("press")],
        }
    }

    /// Opens connections to the sender in a thread of its own, with a pause after each. They stay open, if they do not end,
    /// until the result is dropped.
    fn flood(&self, count: u32, how: Connect, pause: Duration) -> JoinHandle<Vec<TcpStream>> {
        let port = self.port;
        std::thread::spawn(move || {
            let mut held = Vec::new();
            for _ in 0..count {
                let Ok(mut socket) = TcpStream::connect(("127.0.0.1", port)) else {
                    continue;
                };
                // The listener may have closed it already.
                let _ = match how {
                    Connect::Bogus => socket.write_all(&[0x16; 5]),
                    Connect::Silent => Ok(()),
                    Connect::Slow => socket.write_all(&[0x16, 3, 1, 2, 0, 1]),
                };
                if !matches!(how, Connect::Bogus) {
                    held.push(socket);
                }
                if !pause.is_zero() {
                    std::thread::park_timeout(pause);
                }
            }
            held
        })
    }

    /// A new member, which is in once it judges its health by the frames of the line. Returns the seconds that it needed,
    /// by its own stamps.
    fn new_member(&self) -> f64 {
        let late = start(self.folder.path(), "receiver", "late");
        until("the new member is in", || {
            late.logged("health is ") && late.logged(" running, ")
        });
        let log = late.log();
        assert!(!log.contains("health is waiting: needs"), "{log}");
        // The thread that reports its health may be ahead of the one that reports the start.
        since(
            seconds_of(&log, " running, "),
            seconds_of(&log, "health is "),
        )
        .max(0.0)
    }

    fn descriptors(&self) -> usize {
        let held = std::fs::read_dir(format!("/proc/{}/fd", self.sender.id()));
        held.map_or(0, Iterator::count)
    }
}

/// Seconds of the day in the stamp of the first line of a log with these words.
fn seconds_of(log: &str, words: &str) -> f64 {
    let line = log.lines().find(|line| line.contains(words));
    let line = line.unwrap_or_else(|| panic!("{words:?}: {log}"));
    let (_, time) = line.split_once('T').expect("a date and a time");
    let (time, _) = time.split_once('Z').expect("a time in UTC");
    let parts = time.split(':').map(|part| part.parse::<f64>());
    parts.fold(0.0, |seconds, part| {
        seconds * 60.0 + part.expect("a number")
    })
}

/// Seconds from one time of the day to another one, over midnight if that is nearer.
fn since(from: f64, to: f64) -> f64 {
    const DAY: f64 = 86_400.0;
    (to - from + DAY / 2.0).rem_euclid(DAY) - DAY / 2.0
}

/// Runs a flood with a new member in it, and checks that it costs nobody anything.
fn check(line: &Line, name: &str, flood: impl FnOnce() -> JoinHandle<Vec<TcpStream>>) {
    let links = line.descriptors();
    let before = line.counts();
    let flood = flood();
    let seconds = line.new_member();
    assert!(seconds < MOST_SECONDS, "{name}: in after {seconds} s");
    let mut most = 0;
    until("the flood is over", || {
        most = most.max(line.descriptors());
        flood.is_finished()
    });
    let after = line.counts();
    most = most.max(line.descriptors());
    assert!(
        most <= links + MOST_DESCRIPTORS + OTHER_DESCRIPTORS,
        "{name}: {links} descriptors before, {most} meanwhile"
    );
    // The cycles that the sender skipped are missing at any follower.
    let skipped = after.skipped - before.skipped;
    for (before, after) in before.lost.iter().zip(after.lost) {
        let lost = after - before - skipped;
        assert!(lost <= FRAMES_OF_SKEW, "{name}: {lost} frames were lost");
    }
    drop(flood.join());
}

/// Lines about floods in the log of the sender, as seconds of the day.
fn flood_lines(line: &Line) -> Vec<f64> {
    let log = line.sender.log();
    let lines = log.lines().filter(|line| line.contains("connection flood"));
    let named = lines.inspect(|line| {
        assert!(line.contains("of them from 127.0.0.1"), "{line}");
        assert!(line.contains("WARN"), "{line}");
    });
    named
        .map(|line| seconds_of(line, "connection flood"))
        .collect()
}

#[test]
fn a_burst_of_connects_costs_no_follower_a_frame_and_keeps_no_member_out() {
    let line = Line::start();
    check(&line, "without a flood", || std::thread::spawn(Vec::new));
    assert_eq!(flood_lines(&line), [] as [f64; 0], "nobody floods it yet");
    for (count, how) in [
        (600, Connect::Bogus),
        (1_500, Connect::Bogus),
        (7_300, Connect::Bogus),
        (1_500, Connect::Silent),
        (1_500, Connect::Slow),
    ] {
        let name = format!("{count} × {how:?}");
        check(&line, &name, || line.flood(count, how, Duration::ZERO));
    }
    until("the node notices it", || {
        line.sender.logged("health is connection-flood")
    });
    let lines = flood_lines(&line);
    assert!(!lines.is_empty(), "{}", line.sender.log());
    // At most one a minute, by its own stamps; the floods of this test may last longer.
    let often = lines.windows(2).any(|two| since(two[0], two[1]) < 59.0);
    assert!(!often, "{lines:?}");
    let statuses = line.statuses();
    let sender = statuses.iter().find(|status| status["node"] == "line");
    let sender = sender.expect("a status");
    // All but the connections that are silent still.
    assert!(
        sender["connections_refused"].as_u64() >= Some(12_000),
        "{sender}"
    );
}

#[test]
fn steady_connects_are_a_flood_too_and_cost_nobody_anything() {
    let line = Line::start();
    // Nine a second, until the node notices: after some 13 s.
    let pause = Duration::from_secs(1) / 9;
    check(&line, "9 a second", || {
        line.flood(180, Connect::Bogus, pause)
    });
    until("the node notices it", || {
        line.sender.logged("health is connection-flood")
    });
    assert!(!flood_lines(&line).is_empty(), "{}", line.sender.log());
    until("it is over", || {
        let log = line.sender.log();
        log.rfind("health is ok") > log.rfind("health is connection-flood")
    });
}
