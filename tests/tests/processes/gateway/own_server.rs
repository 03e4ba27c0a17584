//! Against our own server: both ways to read, both images, a connection that ends, refusals and malformed replies.

use std::process::Output;

use coaxle_axis::{ImageLayout, NcToPlcAxis};
use coaxle_clock::{Instant, Span};
use coaxle_os::{Machine, machine};
use coaxle_test_process::{assert_alive, output, until};
use coaxle_tests::ports::free_port;

use crate::gateway::server::{CYCLE_S, Plc};
use crate::gateway::{command, node};

/// The machine may be very busy.
const TIMEOUT: Span = Span::from_secs(120);
/// Cycles without data after which the receiver that locks in has no master any more: 0.4 s, longer than a busy machine pauses a node time and again.
const SILENT: u32 = 100;

/// Config of a gateway to a PLC, with its axis.
fn gateway(plc: &Plc, port: u16, read: &str, symbol: &str, output: &str) -> String {
    format!(
        "name = 'plc'\ncycle-time-us = 4000\n\
         [transport]\nlisten = ['tcp/127.0.0.1:{port}']\n\
         [ads]\naddress = '{}'\nnet-id = '5.6.7.8.1.1'\ncycle-index = 'G.n'\nread = '{read}'\n\
         [[axis]]\nid = 1\nname = 'belt'\nsymbol = '{symbol}'\n\
         [[output]]\nnode = 'saw'\ncycle-index = 'G.m'\n[[output.axis]]\nid = 1\n{output}\n",
        plc.address()
    )
}

/// A running PLC, and the axis that it gets back.
struct Circle<'a> {
    plc: &'a Plc,
    next: Instant<Machine>,
    index: Vec<u8>,
    /// Name of the variable that is written, and offset of its position.
    variable: (&'a str, usize),
    /// Delays of the values that came back, cycles.
    behind: Vec<f64>,
}

impl Circle<'_> {
    /// Runs cycles until a quarter of the newest hundred that came back are within ten cycles: the receiver has locked in.
    fn turn_until_it_is_close(&mut self, what: &str) {
        let until = machine::now() + TIMEOUT;
        let mut quarter = f64::NAN;
        loop {
            self.behind.clear();
            while self.behind.len() < 100 {
                let came = self.behind.len();
                assert!(
                    machine::now() < until,
                    "{what}: {came} came since a quarter was within {quarter} cycles"
                );
                self.step();
            }
            self.behind.sort_by(f64::total_cmp);
            // The others are as late as the machine is busy.
            quarter = self.behind[self.behind.len() / 4];
            // 40 ms: far less than without a correction that has locked in.
            if quarter < 10.0 {
                println!("{what}: a quarter within {quarter:.3} cycles");
                return;
            }
        }
    }

    /// Runs a cycle of the PLC, and notes the value that came back in it.
    fn step(&mut self) {
        assert_alive("the PLC gets its axis back");
        // A PLC misses no cycle while this machine is busy: its clock would step, and the receiver would have to find it once more.
        self.next += Span::from_secs_f64(CYCLE_S);
        machine::sleep_until(self.next);
        self.plc.step();
        let index = self.plc.value("G.m");
        // The gateway has written nothing since.
        if index == self.index {
            return;
        }
        self.index = index;
        let (name, at) = self.variable;
        let value = self.plc.value(name);
        let eight = value[at..at + 8].try_into().expect("eight bytes");
        let behind = self.plc.position() - f64::from_le_bytes(eight);
        self.behind.push(behind.abs());
    }
}

#[test]
fn polled_or_notifying_it_gets_its_axis_back_and_is_found_again_when_it_was_away() {
    for (read, variable, output) in [
        // Offset of the set position in the image of an axis; an image of set values begins with it.
        ("polling", ("G.c", 80), "symbol = 'G.c'"),
        (
            "notifications",
            ("G.e", 0),
            "symbol = 'G.e'\nimage = 'external-set-values'",
        ),
    ] {
        let (plc, port) = (Plc::start(), free_port());
        let folder = tempfile::tempdir().expect("a scratch folder");
        let config = gateway(&plc, port, read, "G.a", output);
        // A PLC that was away for long is another run, which a receiver follows by itself if it is to.
        let receiver = format!(
            "name = 'saw'\ncycle-time-us = 4000\npublish-far-axes = true\n\
             [transport]\nconnect = ['tcp/127.0.0.1:{port}']\n\
             [[far]]\nnode = 'plc'\naxes = [1]\n\
             sync.time-sync = {{ age-of-data-limit = {SILENT}, automatic-re-init = true }}\n"
        );
        let _gateway = node("gateway", folder.path(), &config);
        let _receiver = node("receiver", folder.path(), &receiver);
        let mut circle = Circle {
            plc: &plc,
            next: machine::now(),
            index: vec![0; 2],
            variable,
            behind: Vec::new(),
        };
        circle.turn_until_it_is_close(read);
        plc.hang_up();
        // Long enough for the receiver to notice.
        for _ in 0..2 * SILENT {
            circle.step();
        }
        plc.come_back();
        circle.turn_until_it_is_close(&format!("{read}, once more"));
    }
}

#[test]
fn far_axes_of_one_receiver_and_slaves_of_another_come_back_and_a_stop_of_the_plc_is_told_and_survived()
 {
    let (plc, port) = (Plc::start(), free_port());
    let folder = tempfile::tempdir().expect("a scratch folder");
    let second = "symbol = 'G.c'\n[[output]]\nnode = 'knife'\nchannel = 'slaves'\n\
                  cycle-index = 'G.k'\n[[output.axis]]\nid = 1\nsymbol = 'G.s'";
    let config = gateway(&plc, port, "polling", "G.a", second);
    let receiver = |name: &str, more: &str| {
        format!(
            "name = '{name}'\ncycle-time-us = 4000\n{more}\n\
             [transport]\nconnect = ['tcp/127.0.0.1:{port}']\n\
             [[far]]\nnode = 'plc'\naxes = [1]\n"
        )
    };
    let gateway = node("gateway", folder.path(), &config);
    let saw = receiver("saw", "publish-far-axes = true");
    let knife = receiver(
        "knife",
        "slave = [{ name = 'blade', gear = { ratio = -2.0 } }]",
    );
    let others = tempfile::tempdir().expect("a scratch folder");
    let of_far_axes = node("receiver", folder.path(), &saw);
    let _knife = node("receiver", others.path(), &knife);
    let mut circle = Circle {
        plc: &plc,
        next: machine::now(),
        index: vec![0; 2],
        variable: ("G.c", 80),
        behind: Vec::new(),
    };
    circle.turn_until_it_is_close("far axes beside slaves");
    let deadline = machine::now() + TIMEOUT;
    // Gear ratio of -2, and a unit per cycle.
    let expected = -2.0 / CYCLE_S;
    loop {
        circle.step();
        let slave = NcToPlcAxis::from_image_slice(ImageLayout::AxisRef, &plc.value("G.s"));
        let velocity = slave.expect("128 bytes").set_velocity;
        if (velocity / expected - 1.0).abs() < 0.05 && plc.value("G.k") != [0, 0] {
            break;
        }
        assert!(machine::now() < deadline, "{velocity} of {expected} u/s");
    }
    plc.stop();
    until("the gateway says that the PLC is in stop", || {
        gateway.logged("does not run any more (state 6)")
    });

    // The PLC continues while both outputs are written; then a publisher of one of them restarts.
    plc.run();
    circle.turn_until_it_is_close("after the PLC was in stop");
    drop(of_far_axes);
    for _ in 0..100 {
        circle.step();
    }
    let _saw = node("receiver", folder.path(), &saw);
    circle.turn_until_it_is_close("after the receiver started anew");
}

/// Runs the gateway for two seconds. Returns its output with the log.
fn run_shortly(config: &str) -> Output {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let mut command = command("gateway", folder.path(), config);
    output(command.args(["--for", "2s"]))
}

#[test]
fn a_symbol_that_is_missing_is_named_once_and_nonsense_does_no_harm() {
    let (plc, port) = (Plc::start(), free_port());
    let output = "symbol = 'G.c'";
    let config = gateway(&plc, port, "polling", "G.x", output);
    let ended = run_shortly(&config);
    let log = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(ended.status.success(), "{log}");
    // Once, though the gateway tries for two seconds: the log must stay readable.
    let named = "\"G.x\": ADS error 0x710: the PLC has no such symbol";
    assert_eq!(log.matches(named).count(), 1, "{log}");

    plc.talk_nonsense();
    let ended = run_shortly(&config);
    let log = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(ended.status.success() && !log.contains("panicked"), "{log}");
    assert_eq!(
        log.matches("an AMS packet of 3 bytes came").count(),
        1,
        "{log}"
    );
}
