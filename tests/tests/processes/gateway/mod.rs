//! A PLC behind a gateway: a receiver follows its axis, and the PLC gets the corrected axis back. One PLC is a small server of
//! our own; others are third-party programs in Python, left out where they are not available.

#![expect(clippy::print_stdout, reason = "what came back is a figure")]

mod own_server;
mod pipe;
mod server;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use coaxle_test_process::Process;
use coaxle_tests::ports::free_port;
use coaxle_tests::python;

/// Duration of the PLC's run, s: its axis comes back for some seconds of it.
const SECONDS: &str = "30";

fn command(role: &str, folder: &Path, config: &str) -> Command {
    let file = folder.join(format!("{role}.toml"));
    std::fs::write(&file, config).expect("a config");
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
    command.arg(role).arg(file).stdin(Stdio::null());
    command
}

fn node(role: &str, folder: &Path, config: &str) -> Process {
    let log = folder.join(format!("{role}.log"));
    Process::start(role, &mut command(role, folder, config), &log)
}

/// Runs a PLC behind a gateway with this connection, and a receiver behind that. Returns the PLC's report: the number of
/// times that its axis came back, and of the newest ones their error, mm, and velocity, mm/s.
fn circle(way: &str, symbols: [&str; 3], mut plc: Command, cycle_us: u32) -> (u32, Vec<[f64; 2]>) {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let port = free_port();
    let [axis, output, index] = symbols;
    let gateway = format!(
        "name = 'plc'\ncycle-time-us = {cycle_us}\n{way}\n\
         [transport]\nlisten = ['tcp/127.0.0.1:{port}']\n\
         [[axis]]\nid = 1\nname = 'conveyor'\nunit = 'mm'\n{axis}\n\
         [[output]]\nnode = 'saw'\n{index}\n[[output.axis]]\nid = 1\n{output}\n"
    );
    let receiver = format!(
        "name = 'saw'\ncycle-time-us = {cycle_us}\npublish-far-axes = true\n\
         [transport]\nconnect = ['tcp/127.0.0.1:{port}']\n\
         [[far]]\nnode = 'plc'\naxes = [1]\nunit = 'mm'\n"
    );
    let _gateway = node("gateway", folder.path(), &gateway);
    let _receiver = node("receiver", folder.path(), &receiver);
    let said = coaxle_test_process::output(&mut plc);
    let errors = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success(), "the PLC failed: {errors}");
    let text = String::from_utf8(said.stdout).expect("it says text");
    let mut lines = text.lines();
    let came = lines.next().and_then(|line| line.parse().ok());
    let pair = |line: &str| {
        let (error, velocity) = line.split_once(' ').expect("two numbers");
        [error, velocity].map(|number| number.parse().expect("a number"))
    };
    (came.expect("a count"), lines.map(pair).collect())
}

fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("gateway")
        .join(name)
}

/// Requires half of the newest to be within 60 ms of travel, as the machine may be busy.
fn judge(what: &str, (came, newest): (u32, Vec<[f64; 2]>)) {
    // At 2 or 5 ms over 30 s thousands are possible.
    assert!(came > 200, "{what}: {came} came");
    let mut off: Vec<f64> = newest.iter().map(|[error, _]| error.abs()).collect();
    off.sort_by(f64::total_cmp);
    // A median, since a stalled process brings single large errors.
    let median = off[off.len() / 2];
    let mut velocities: Vec<f64> = newest.iter().map(|[_, velocity]| *velocity).collect();
    velocities.sort_by(f64::total_cmp);
    let velocity = velocities[velocities.len() / 2];
    println!("{what}: {came} came back, half of them within {median:.2} mm, {velocity:.2} mm/s");
    // 60 ms at 500 mm/s.
    assert!(median < 30.0, "{what}: {median} mm");
    assert!((velocity - 500.0).abs() < 5.0, "{what}: {velocity} mm/s");
}

#[test]
fn a_plc_behind_an_independent_ads_server_gets_its_axis_back() {
    let Some(python) = python::with("pyads.testserver") else {
        return;
    };
    let port = free_port();
    let mut plc = Command::new(python);
    plc.arg(script("plc_ads.py"))
        .args([&port.to_string(), SECONDS]);
    let way = format!(
        "[ads]\naddress = '127.0.0.1:{port}'\nnet-id = '127.0.0.1.1.1'\n\
         cycle-index = 'GVL.nCycleIndex'\n"
    );
    let symbols = [
        "symbol = 'GVL.stConveyor'",
        "symbol = 'GVL.stCorrected'",
        "cycle-index = 'GVL.nReceivedIndex'",
    ];
    judge("ADS", circle(&way, symbols, plc, 5_000));
}

#[test]
fn a_plc_of_a_few_lines_gets_its_axis_back_by_udp() {
    let Some(python) = python::with("socket") else {
        return;
    };
    let mut plc = Command::new(python);
    plc.arg(script("plc_udp.py"));
    by_udp("UDP", plc);
}

#[test]
fn a_microcontroller_without_a_library_gets_its_axis_back_by_udp() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let program = folder.path().join("microcontroller");
    let source = "../common/c/examples/microcontroller.c";
    let mut compiler = Command::new("cc");
    compiler
        .args([
            "-std=c11",
            "-D_DEFAULT_SOURCE",
            "-Wall",
            "-Wextra",
            "-Werror",
        ])
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join(source))
        .arg("-o")
        .arg(&program);
    let Ok(output) = compiler.output() else {
        println!("not tested: there is no compiler for C");
        return;
    };
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    by_udp("a microcontroller", Command::new(program));
}

/// Judges a PLC that takes the port of its own, that of the gateway, and the duration of its run.
fn by_udp(what: &str, mut plc: Command) {
    let (to_plc, to_gateway) = (free_port(), free_port());
    plc.args([&to_plc.to_string(), &to_gateway.to_string(), SECONDS]);
    let way = format!(
        "layout = 'axlestruct'\n[udp]\nlisten = '127.0.0.1:{to_gateway}'\nsend-to = '127.0.0.1:{to_plc}'\n"
    );
    judge(what, circle(&way, ["", "", ""], plc, 2_000));
}
