//! Real nodes and the tool, as `coaxle secure init` sets them up.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use coaxle_test_process::{Process, output, until};
use coaxle_tests::ports::free_port;

const AXIS: &str = "[[axis]]\nid = 1\nname = 'belt'\n\
    program = { start-velocity = 5, limits = { velocity = 10, acceleration = 10, jerk = 10 } }\n";
pub(super) const SLAVE: &str = "master = { node = 'line' }\n[[slave]]\nname = 'carriage'\ncouple = 'off'\n\
    limits = { velocity = 500, acceleration = 2000, jerk = 1e5 }\n";

pub(super) fn coaxle(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
    command
        .args(line.split_whitespace())
        .current_dir(folder)
        .stdin(Stdio::null());
    command
}

/// Output of the tool, and whether it succeeded.
pub(super) fn output_of(folder: &Path, line: &str) -> (String, bool) {
    let Output {
        status,
        stdout,
        stderr,
    } = output(&mut coaxle(folder, line));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&stdout) + &text(&stderr), status.success())
}

/// A node that ends with the test.
pub(super) fn start(folder: &Path, role: &str, name: &str) -> Process {
    let log = folder.join(format!("{name}.log"));
    // Longer than any wait: it is ended by the test.
    let mut command = coaxle(folder, &format!("{role} {name}.toml --for 600s"));
    Process::start(name, &mut command, &log)
}

pub(super) fn write(folder: &Path, name: &str, text: &str) {
    let text = format!("name = '{name}'\ncycle-time-us = 2000\n{text}");
    std::fs::write(folder.join(format!("{name}.toml")), text).expect("a config");
}

/// The sender that all tests have, which listens at this port.
pub(super) fn write_line(folder: &Path, port: u16) {
    let listen = format!("listen = ['tls/127.0.0.1:{port}']");
    let text = format!("{AXIS}[transport]\nsecure = 'net/line'\n{listen}");
    write(folder, "line", &text);
}

#[test]
fn a_node_that_nobody_hears_is_told_so_at_both_ends() {
    let scratch = tempfile::tempdir().expect("a scratch folder");
    let folder = scratch.path();
    let line = free_port();
    write_line(folder, line);
    for name in ["deaf", "saw"] {
        write(
            folder,
            name,
            &format!(
                "{SLAVE}[transport]\nsecure = 'net/{name}'\nconnect = ['tls/127.0.0.1:{line}']"
            ),
        );
    }
    let (text, good) = output_of(folder, "secure init line.toml deaf.toml saw.toml --out net");
    assert!(good, "{text}");
    take_rights(
        &folder.join("net/deaf/zenoh.json5"),
        "put",
        "coaxle/line/axes",
    );
    take_rights(
        &folder.join("net/saw/zenoh.json5"),
        "put",
        "coaxle/line/time-responses",
    );

    let line = start(folder, "sender", "line");
    let deaf = start(folder, "receiver", "deaf");
    until("the line is told that nobody hears it", || {
        // By the tokens of receivers: a sender cannot see by itself whether its data arrive.
        line.logged("nobody says that anything arrives") && line.logged("health is refused")
    });
    until("the deaf one says why that may be", || {
        deaf.logged("still no-data: needs good frames on coaxle/line/axes")
            && deaf.logged("gives no rights")
    });
    let saw = start(folder, "receiver", "saw");
    until("the line is heard", || line.logged("health is ok"));
    until("the saw is not told the time", || {
        saw.logged("the master has responded to no time request (0 responses refused)")
    });
}

/// Loads a plate of 3000 points, some 100 KiB as an order, and reads as many back.
fn a_long_plate_passes(folder: &Path) {
    let point = |n: u32| {
        // 3000 points over 360°, each different from its neighbours.
        let (master, slave) = (f64::from(n) * 0.12, f64::from(n % 7) * 0.01);
        format!("[[point]]\nmaster = {master}\nslave = {slave}\nlaw = 'polynom5'\n")
    };
    let points: String = (0..3_000).map(point).collect();
    std::fs::write(folder.join("long.toml"), points).expect("a cam file");
    let command = "command --secure net/anna saw carriage";
    let select = format!("{command} cam-table-select long.toml --table 2");
    let (text, good) = output_of(folder, &select);
    assert!(good && text.contains("accepted"), "{text}");
    let (text, good) = output_of(folder, &format!("{command} read-motion-function --table 2"));
    assert!(
        good && text.contains("3000 of 3000 points"),
        "{}",
        text.lines().next().unwrap_or_default()
    );
}

/// Takes one right of a profile away.
fn take_rights(profile: &Path, message: &str, key: &str) {
    let text = std::fs::read_to_string(profile).expect("a profile");
    let (message, key) = (format!("\"{message}\""), format!("\"{key}\""));
    let is_it =
        |line: &str| line.contains("\"allow\"") && line.contains(&message) && line.contains(&key);
    // Exactly one line, or the test would take away another right than it means to.
    assert_eq!(text.lines().filter(|line| is_it(line)).count(), 1, "{text}");
    let without = text.lines().map(|line| match is_it(line) {
        true => line.replace(&message, "\"delete\"") + "\n",
        false => line.to_owned() + "\n",
    });
    std::fs::write(profile, without.collect::<String>()).expect("a profile");
}

#[test]
fn nodes_and_operators_find_each_other_and_who_is_refused_says_why() {
    let scratch = tempfile::tempdir().expect("a scratch folder");
    let folder = scratch.path();
    let [line, saw] = [(); 2].map(|()| free_port());
    write_line(folder, line);
    write(
        folder,
        "saw",
        &format!(
            "{SLAVE}[transport]\nsecure = 'net/saw'\nlisten = ['tls/127.0.0.1:{saw}']\n\
             connect = ['tls/127.0.0.1:{line}']"
        ),
    );
    let init = "secure init line.toml saw.toml --out net --operator anna --operator bert=line";
    let (text, good) = output_of(folder, init);
    assert!(good, "{text}");
    let (text, good) = output_of(folder, "doctor line.toml saw.toml");
    assert!(good && text.contains("nothing is open"), "{text}");

    let line_node = start(folder, "sender", "line");
    let saw_node = start(folder, "receiver", "saw");
    until("the saw follows the line", || saw_node.logged("health is "));

    // A client of no secure network, and a member without rights at the line.
    write(
        folder,
        "plain",
        &format!("{SLAVE}[transport]\nconnect = ['tcp/127.0.0.1:{line}']"),
    );
    write(
        folder,
        "stranger",
        &format!(
            "{SLAVE}[transport]\nsecure = 'other/stranger'\nconnect = ['tls/127.0.0.1:{line}']"
        ),
    );
    let (text, good) = output_of(folder, "secure init line.toml stranger.toml --out other");
    assert!(good, "{text}");
    write(
        folder,
        "late",
        &format!("{SLAVE}[transport]\nsecure = 'net/late'\nconnect = ['tls/127.0.0.1:{line}']"),
    );
    let (text, good) = output_of(
        folder,
        "secure renew line.toml late.toml --out net --only late",
    );
    assert!(good, "{text}");
    let refused = [
        ("plain", "wants TLS and a certificate"),
        ("stranger", "of another authority"),
        ("late", "is line and lets this end in, but shows it nothing"),
    ];
    let refused = refused.map(|(name, why)| (start(folder, "receiver", name), why));

    let (text, good) = output_of(folder, "command --secure net/anna saw carriage power on");
    assert!(good && text.contains("accepted"), "{text}");
    until("the order is logged", || {
        saw_node.logged("order of \"anna\": MC_Power to \"carriage\": accepted")
    });
    for (how, why) in [
        (
            format!("--secure net/bert --connect tls/127.0.0.1:{saw}"),
            "gives no rights",
        ),
        (
            format!("--connect tcp/127.0.0.1:{saw}"),
            "wants TLS and a certificate",
        ),
    ] {
        let (text, good) = output_of(folder, &format!("command {how} saw carriage power off"));
        assert!(!good && text.contains(why), "{text}");
    }
    // That of anna alone: refused ones are not even seen.
    let orders = saw_node.log().matches("order of ").count();
    assert_eq!(orders, 1, "{}", saw_node.log());
    a_long_plate_passes(folder);

    for (node, why) in &refused {
        until(why, || node.logged(why) && node.logged("refused"));
        assert!(node.logged("node line is not to be seen"), "{}", node.log());
    }
    assert!(!saw_node.logged("is not to be seen"), "{}", saw_node.log());
    assert!(!line_node.logged("ERROR"), "{}", line_node.log());
}
