//! Set values of HAL as a master: a sine of LinuxCNC's threads, by `halsampler` and a gateway, in a receiver.

use std::path::Path;
use std::process::{Command, Stdio};

use coaxle_test_process::{Process, output, until};
use coaxle_tests::ports::free_endpoint;

use super::world::{HalFolder, TOOL, shipped};

/// Amplitude of the sine, mm, and its angular frequency, rad/s.
const AMPLITUDE: f64 = 100.0;
const OMEGA: f64 = std::f64::consts::PI / 2.0;
/// Size of a row of the trace, bytes, hardly more.
const ROW_BYTES: u64 = 1_000;

#[test]
fn a_position_of_hal_leads_axes_of_other_pcs() {
    let Some(folder) = HalFolder::new() else {
        return;
    };
    let [from_hal, follower] = [(); 2].map(|()| free_endpoint());
    let text = |name: &str| {
        std::fs::read_to_string(shipped(&format!("linuxcnc/{name}"))).expect("it is shipped")
    };
    folder.write("wait.sh", "until [ -e done ]; do sleep 0.1; done\n");
    folder.write(
        "publish.hal",
        &(text("publish.hal") + "loadusr -w sh wait.sh\n"),
    );
    let threads = folder.threads("publish.hal");
    // It waits for the threads, whose sampler has to be there.
    let mut sampler = folder.beside_as_nobody("sh");
    sampler.args([
        "-c",
        "until halcmd show comp sampler | grep -q ready; do sleep 0.1; done; exec stdbuf -oL halsampler -t",
    ]);
    sampler.stdout(Stdio::piped()).stdin(Stdio::null());
    let mut sampler = sampler.spawn().expect("a shell");
    let lines = sampler.stdout.take().expect("it is piped");
    let mut gateway = folder.command("gateway", &text("gateway.toml"), &["--listen", &from_hal]);
    gateway.stdin(lines);
    let gateway = Process::start("gateway", &mut gateway, &folder.file("gateway.log"));
    let config =
        "name = 'follower'\ncycle-time-us = 1000\n[master]\nnode = 'cnc-joints'\naxis = 1\n";
    let trace = folder.file("follower.csv");
    let traced = trace.to_str().expect("UTF-8");
    let options = [
        "--listen",
        &follower,
        "--connect",
        &from_hal,
        "--trace",
        traced,
    ];
    let receiver = folder.node("receiver", config, &options);

    let tool = |arguments: &[&str]| {
        let mut command = Command::new(TOOL);
        output(command.args(arguments).args(["--connect", &follower]))
    };
    // Threads without real-time priority may have too few cycles of a busy machine for a clock.
    let is_known = tool(&["wait-sync", "follower", "--timeout", "60s"])
        .status
        .success();
    if is_known {
        let recorded = || std::fs::metadata(&trace).map_or(0, |file| file.len());
        let before = recorded();
        until("two periods are recorded", || {
            recorded() > before + 8_000 * ROW_BYTES
        });
    }
    folder.write("done", "");
    let log = gateway.log();
    // Of lines that are no record, halsampler prints those of lost samples alone.
    assert!(!log.contains("received \""), "{log}");
    drop((receiver, gateway));
    threads.may_end();
    let _ = threads.wait();
    let _ = sampler.kill();
    let _ = sampler.wait();
    match is_known {
        true => judge(&trace),
        false => println!("not judged: the machine was too busy"),
    }
}

/// The position and velocity of a sine are those of a circle. Values that are repeated or missed, or of another instant than their
/// velocity, are not.
fn judge(trace: &Path) {
    let rows = rows(trace);
    let synced: Vec<_> = rows
        .windows(2)
        .filter(|pair| pair.iter().all(|row| row.synced))
        .collect();
    let mut radii = Vec::new();
    let mut steps = Vec::new();
    for pair in &synced {
        let [before, now] = [&pair[0], &pair[1]];
        radii.push((now.position.hypot(now.velocity / OMEGA) - AMPLITUDE).abs());
        let passed = (now.time - before.time) as f64 * 1e-9;
        let expected = 0.5 * (now.velocity + before.velocity) * passed;
        steps.push((now.position - before.position - expected).abs());
    }
    if synced.len() < 500 {
        println!("not judged: {} cycles in sync", synced.len());
        return;
    }
    // A beat is 0.157 mm at the greatest velocity. A machine that is busy takes samples away, and the way over them is a prediction.
    for (what, off) in [("radius", &mut radii), ("step", &mut steps)] {
        off.sort_by(f64::total_cmp);
        let [median, nearly_all] = [off.len() / 2, off.len() * 9 / 10].map(|n| off[n]);
        println!(
            "{what}: {} cycles in sync, off by {median:.6} mm, 90 % by less than {nearly_all:.6} mm",
            off.len()
        );
        assert!(
            median < 0.02 && nearly_all < 0.08,
            "{what}: {median} mm, {nearly_all} mm"
        );
    }
}

/// A cycle of the receiver.
#[derive(Debug)]
struct FollowedCycle {
    /// Ideal start of the cycle, ns.
    time: i64,
    synced: bool,
    position: f64,
    velocity: f64,
}

fn rows(trace: &Path) -> Vec<FollowedCycle> {
    let text = std::fs::read_to_string(trace).expect("a trace");
    let mut lines = text.lines();
    let head: Vec<_> = lines.next().unwrap_or_default().split(',').collect();
    let place = |name: &str| {
        let place = head.iter().position(|column| *column == name);
        place.unwrap_or_else(|| panic!("{name}: {head:?}"))
    };
    let places = [
        "at_ns",
        "cnc-joints.1.synced",
        "cnc-joints.1.corrected_position",
        "cnc-joints.1.corrected_velocity",
    ]
    .map(place);
    // The first rows have no values yet.
    let row = |line: &str| {
        let cells: Vec<_> = line.split(',').collect();
        let [time, synced, position, velocity] = places.map(|place| cells.get(place).copied());
        Some(FollowedCycle {
            time: time?.parse().ok()?,
            synced: synced? == "1" || synced? == "true",
            position: position?.parse().ok()?,
            velocity: velocity?.parse().ok()?,
        })
    };
    lines.filter_map(row).collect()
}
