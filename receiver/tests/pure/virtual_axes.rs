//! Virtual axes of a receiver's own, and the slaves that follow them.

use crate::nodes::{Far, MILLISECOND, receiver, run};
use coaxle_axis::{AxisStatus, CoupleState, StateWord};
use coaxle_gear::{GearInMultiMaster, MultiMasterSync, Ratios};
use coaxle_node::Node;
use coaxle_node::config::parse;
use coaxle_receiver::signals::{SlaveSignals, VirtualAxisSignals};
use coaxle_receiver::{Health, HealthName, Receiver, ReceiverConfig, SignalRow};
use coaxle_slave::{Command, CouplingPhase, Dynamics, Refusal};
use coaxle_source::Activity;

/// A belt far away, and a line shaft of the receiver's own, as the first and the second master.
const LINE: &str = "
[[far]]
node = 'infeed'
axes = [{ id = 1, name = 'belt' }]
delay = 'off'
[[virtual-axis]]
id = 7
name = 'shaft'
unit = 'mm'
[virtual-axis.program]
limits = { velocity = 500, acceleration = 1000, jerk = 10000 }
steps = [
    { dwell = { for-s = 1.0 } },
    { enable = true },
    { velocity = { value = 300.0, for-s = 3.0 } },
    { halt = {} },
]
[[slave]]
name = 'mixer'
master = 'belt'
further-masters = ['shaft']
limits = { velocity = 1000, acceleration = 5000, jerk = 100000 }
[[slave.step]]
when = { master-ready = true }
do = { power = true }
[[slave.step]]
when = { after-s = 2 }
do = { gear-in-multi-master = { ratios = [1.0, 0.0] } }
[[slave]]
name = 'roll'
master = 'shaft'
gear = { ratio = -2.0, offset = 5.0 }
";

const BELT: f64 = 200.0;

/// Limits of the slave.
const ACCELERATION: f64 = 5_000.0;
const JERK: f64 = 100_000.0;

fn line() -> (Receiver, [Far; 1]) {
    (receiver(LINE), [Far::new(0, 1_000_020, &[BELT])])
}

/// The set positions of a slave, differenced from cycle to cycle.
#[derive(Default)]
struct Differences {
    last: [f64; 4],
    seen: usize,
}

impl Differences {
    fn keep(&mut self, slave: &SlaveSignals) {
        let Some(position) = slave.position else {
            return;
        };
        self.last.rotate_left(1);
        self.last[3] = position;
        self.seen += 1;
        let ([p0, p1, p2, p3], dt) = (self.last, 1e-3_f64);
        let acceleration = (p3 - 2.0 * p2 + p1) / (dt * dt);
        let jerk = (p3 - 3.0 * p2 + 3.0 * p1 - p0) / (dt * dt * dt);
        // A jerk needs four positions.
        if self.seen > 3 {
            // The belt's velocity is per second of its own clock, which drifts and is still being
            // estimated.
            assert!(acceleration.abs() <= ACCELERATION * 1.001, "{acceleration}");
            assert!(jerk.abs() <= JERK * 1.1, "{jerk} {:?}", self.last);
        }
    }
}

fn gear(ratios: &[f64]) -> Command {
    Command::GearInMultiMaster(GearInMultiMaster {
        ratios: Ratios::new(ratios).expect("ratios"),
        dynamics: Dynamics::default(),
        sync_mode: MultiMasterSync::default(),
    })
}

fn shaft(row: &SignalRow) -> &VirtualAxisSignals {
    &row.virtual_axes[0]
}

#[test]
fn a_follower_of_it_is_where_the_gear_puts_it_from_the_first_cycle_on() {
    let (mut receiver, _) = line();
    let mut fastest = 0.0_f64;
    // The belt is not involved: its frames never arrive.
    run(&mut receiver, &mut [], 6_000 * MILLISECOND, |row, _| {
        let (shaft, roll) = (shaft(row), &row.slaves[1]);
        assert_eq!(roll.position, Some(-2.0 * shaft.position + 5.0));
        assert_eq!(roll.velocity, Some(-2.0 * shaft.velocity));
        assert_eq!(roll.phase, Some(CouplingPhase::InSync));
        fastest = fastest.max(shaft.velocity);
    });
    // A profile ends exactly at its set velocity.
    assert_eq!(fastest, 300.0);
    let row = &receiver.snapshot().signals;
    // The axis's program has ended: it stands at the end position.
    assert_eq!((shaft(row).velocity, shaft(row).error), (0.0, 0));
    assert_eq!(shaft(row).activity, Activity::Halted);
    assert_eq!(shaft(row).position, shaft(row).true_position);
    let axis = &receiver.virtual_axes()[0];
    assert_eq!((axis.axis_id, axis.couple_state), (7, CoupleState::Master));
    assert!(axis.state_word.contains(StateWord::OPERATIONAL));
    assert_eq!(axis.set_position, shaft(row).position);
}

#[test]
fn its_time_is_the_clock_of_the_receiver_skipped_cycles_included() {
    let (mut receiver, _) = line();
    let (mut steady, _) = line();
    run(&mut steady, &mut [], 3_000 * MILLISECOND, |_, _| {});
    run(&mut receiver, &mut [], 2_500 * MILLISECOND, |_, _| {});
    // The receiver sleeps for 499 cycles.
    let now = coaxle_clock::Instant::from_nanos(2_999 * MILLISECOND + MILLISECOND / 2);
    let _ = receiver.cycle(now);
    let (late, steady) = (receiver.snapshot(), steady.snapshot());
    assert_eq!(late.ideal_start, steady.ideal_start);
    assert_eq!(late.signals.virtual_axes, steady.signals.virtual_axes);
}

/// From the belt to the shaft and back while both move, and the shaft stops on the way.
#[test]
fn a_slave_goes_over_from_a_far_axis_to_the_shaft_and_back_in_motion() {
    let (mut receiver, mut far) = line();
    let mut differences = Differences::default();
    let mixer = receiver.slave_number("mixer").expect("a slave");
    run(&mut receiver, &mut far, 3_000 * MILLISECOND, |row, _| {
        differences.keep(&row.slaves[0]);
    });
    let velocity = |receiver: &Receiver| {
        let slave = receiver.snapshot().signals.slaves[0];
        assert_eq!(slave.phase, Some(CouplingPhase::InSync));
        slave.velocity.expect("an axis")
    };
    assert!((velocity(&receiver) - BELT).abs() < 0.1);
    // To the shaft, and exactly with it while it stops and stands.
    assert!(receiver.command(mixer, &gear(&[0.0, 1.0])).is_ok());
    run(&mut receiver, &mut far, 4_000 * MILLISECOND, |row, _| {
        differences.keep(&row.slaves[0]);
    });
    assert_eq!(velocity(&receiver), 300.0);
    let mut apart = None;
    run(&mut receiver, &mut far, 6_000 * MILLISECOND, |row, _| {
        differences.keep(&row.slaves[0]);
        let now = row.slaves[0].position.expect("an axis") - shaft(row).position;
        // Coupled by velocity: its distance to the shaft is any, but constant.
        let before = *apart.get_or_insert(now);
        assert!((now - before).abs() < 1e-9, "{now} {before}");
    });
    assert_eq!(velocity(&receiver), 0.0);
    // The far axis may be lost meanwhile: it is not required.
    far[0].silent = true;
    run(&mut receiver, &mut far, 8_000 * MILLISECOND, |row, _| {
        differences.keep(&row.slaves[0]);
    });
    assert_eq!(receiver.snapshot().signals.far[0].health, HealthName::Error);
    let back = gear(&[1.0, 0.0]);
    assert_eq!(receiver.command(mixer, &back), Err(Refusal::NoMaster));
    far[0].silent = false;
    far[0].epoch = 2;
    run(&mut receiver, &mut far, 21_000 * MILLISECOND, |row, _| {
        differences.keep(&row.slaves[0]);
    });
    assert!(receiver.command(mixer, &back).is_ok());
    run(&mut receiver, &mut far, 22_000 * MILLISECOND, |row, _| {
        differences.keep(&row.slaves[0]);
    });
    assert!((velocity(&receiver) - BELT).abs() < 0.1);
    // Out of it again.
    assert!(receiver.command(mixer, &Command::GearOut {}).is_ok());
    let halt = Command::Halt {
        dynamics: Dynamics::default(),
    };
    assert!(receiver.command(mixer, &halt).is_ok());
    run(&mut receiver, &mut far, 23_000 * MILLISECOND, |row, _| {
        differences.keep(&row.slaves[0]);
    });
    let slave = receiver.snapshot().signals.slaves[0];
    assert_eq!((slave.state, slave.error), (AxisStatus::Standstill, 0));
}

#[test]
fn both_together_lead_it_by_their_sum() {
    let text = LINE.replace("ratios = [1.0, 0.0]", "ratios = [0.5, 2.0]");
    let (mut receiver, mut far) = (receiver(&text), line().1);
    let mut differences = Differences::default();
    let mut apart = None;
    run(&mut receiver, &mut far, 6_000 * MILLISECOND, |row, at| {
        differences.keep(&row.slaves[0]);
        if at > 3_000 * MILLISECOND {
            let belt = row.axes[0].corrected_position.expect("known");
            let sum = 0.5 * belt + 2.0 * shaft(row).position;
            let now = row.slaves[0].position.expect("an axis") - sum;
            // Coupled by velocity: its distance to the sum is any, but constant.
            let before = *apart.get_or_insert(now);
            assert!((now - before).abs() < 1e-9, "{now} {before}");
        }
    });
    assert_eq!(receiver.snapshot().health, Health::Ok);
}

/// A receiver without a far node, with a played-back recording and its contents.
fn recorded(rows: &str) -> Receiver {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("taught.csv");
    std::fs::write(&file, rows).expect("a file");
    receiver(&format!(
        "[[virtual-axis]]\nid = 1\nname = 'taught'\nreplay = {{ file = {file:?} }}\n\
         [[slave]]\nname = 'watched'\ncouple = 'gear'\n\
         limits = {{ velocity = 1000, acceleration = 5000, jerk = 100000 }}\n\
         [[slave]]\nname = 'follower'"
    ))
}

#[test]
fn a_replay_at_its_end_stands_and_its_slaves_with_it() {
    let text = "time_s,position,velocity\n0,0,100\n1,100,100\n1.5,125,0\n";
    let mut receiver = recorded(text);
    let mut differences = Differences::default();
    run(&mut receiver, &mut [], 3_000 * MILLISECOND, |row, _| {
        differences.keep(&row.slaves[0]);
        let position = row.virtual_axes[0].position;
        assert_eq!(row.slaves[0].position, Some(position));
        assert_eq!(row.slaves[1].position, Some(position));
    });
    let snapshot = receiver.snapshot();
    let shown = &snapshot.signals.virtual_axes[0];
    assert_eq!((shown.position, shown.velocity), (125.0, 0.0));
    assert_eq!((shown.activity, shown.error), (Activity::Idle, 0));
    assert_eq!(snapshot.health, Health::Ok);
    let phase = snapshot.signals.slaves[0].phase;
    assert_eq!(phase, Some(CouplingPhase::InSync));
}

/// Values that a receiver would reject from a sender: the axis is in error, like a far one.
#[test]
fn an_axis_in_error_stops_its_slaves_within_their_limits_until_they_are_reset() {
    let text = "time_s,position,velocity\n0,0,100\n1,100,100\n1.001,1e16,0\n1.5,1e16,0\n\
                1.501,100,100\n4.001,350,100\n";
    let mut receiver = recorded(text);
    let mut differences = Differences::default();
    run(&mut receiver, &mut [], 1_001 * MILLISECOND, |row, _| {
        differences.keep(&row.slaves[0]);
    });
    let mut stood = None;
    run(&mut receiver, &mut [], 1_500 * MILLISECOND, |row, _| {
        let (axis, follower) = (&row.virtual_axes[0], &row.slaves[1]);
        assert_eq!((axis.error, axis.velocity), (0x42d5, 0.0));
        // Beyond 1e15, no position is plausible.
        assert!(!axis.operational && axis.true_position > 1e15);
        let at = *stood.get_or_insert(axis.position);
        // 0.1 u is the way of a cycle at 100 u/s.
        assert!((at - 100.0).abs() < 0.2, "{at}");
        // The axis stands at its last position, also for a slave without monitoring.
        assert_eq!((axis.position, follower.position), (at, Some(at)));
        differences.keep(&row.slaves[0]);
    });
    let axis = receiver.virtual_axes()[0];
    assert!(axis.state_word.contains(StateWord::ERROR));
    assert_eq!(axis.implausible_field(), None);
    let slave = receiver.snapshot().signals.slaves[0];
    assert_eq!((slave.state, slave.error), (AxisStatus::ErrorStop, 0x42a0));
    assert_eq!(receiver.snapshot().health, Health::SlaveFailed { slave: 0 });
    // The master's values are plausible again, and the slave stays at its position until it is commanded.
    run(&mut receiver, &mut [], 2_000 * MILLISECOND, |row, _| {
        differences.keep(&row.slaves[0]);
        assert_eq!(row.slaves[0].state, AxisStatus::ErrorStop);
    });
    assert_eq!(receiver.snapshot().signals.virtual_axes[0].error, 0);
    let watched = receiver.slave_number("watched").expect("a slave");
    assert!(receiver.command(watched, &Command::Reset {}).is_ok());
    assert!(receiver.command(watched, &gear(&[1.0])).is_ok());
    run(&mut receiver, &mut [], 3_000 * MILLISECOND, |row, _| {
        differences.keep(&row.slaves[0]);
    });
    let snapshot = receiver.snapshot();
    assert_eq!(snapshot.health, Health::Ok);
    let velocity = snapshot.signals.slaves[0].velocity.expect("an axis");
    assert!((velocity - 100.0).abs() < 1e-6, "{velocity}");
}

#[test]
fn an_encoder_is_followed_as_it_shows_and_the_truth_is_beside_it() {
    let mut receiver = receiver(
        "[[virtual-axis]]\nid = 1\nname = 'wheel'\n[virtual-axis.encoder]\nresolution = 0.25\n\
         [virtual-axis.encoder.program]\nstart-velocity = 10.0\n\
         limits = { velocity = 100, acceleration = 100, jerk = 1000 }\n\
         [[slave]]\nname = 'roll'\n",
    );
    run(&mut receiver, &mut [], 2_000 * MILLISECOND, |row, _| {
        let wheel = &row.virtual_axes[0];
        let behind = wheel.true_position - wheel.position;
        // An encoder shows whole increments, rounded down.
        assert!((-1e-9..0.25).contains(&behind), "{behind}");
        assert_eq!(wheel.true_velocity, 10.0);
        assert_eq!(row.slaves[0].position, Some(wheel.position));
    });
    let shown = receiver.snapshot().signals.virtual_axes[0];
    assert_eq!(shown.activity, Activity::Measured);
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let shaft = "[[virtual-axis]]\nid = 1\nname = 'shaft'\nprogram.limits = { velocity = 1, \
                 acceleration = 1, jerk = 1 }\n";
    let two = "limits = { velocity = 1, acceleration = 1, jerk = 1 }\nmaster = 'shaft'";
    for (rest, expected) in [
        (
            "[[slave]]\nname = 'a'\nmaster = 'shat'\n[[slave]]\nname = 'b'".to_owned(),
            "slave[0].master: received \"shat\", expected one of: belt, shaft, b",
        ),
        (
            format!("[[slave]]\nname = 'a'\n{two}\nfurther-masters = ['belt', 'shaft']"),
            "slave[0].further-masters[1]: received \"shaft\" twice, expected each master once",
        ),
        (
            "[[slave]]\nname = 'shaft'".to_owned(),
            "slave[0].name: received \"shaft\", which is a virtual axis, expected a name of its own",
        ),
        (
            "[[virtual-axis]]\nid = 2\nname = 'taught'\nreplay.file = 'nowhere.csv'".to_owned(),
            "virtual-axis[1].replay.file: nowhere.csv: cannot be read: ",
        ),
    ] {
        let far = "[[far]]\nnode = 'a'\naxes = [{ id = 1, name = 'belt' }]\n";
        let text = format!("name = 'line'\ncycle-time-us = 1000\n{far}{shaft}{rest}");
        let config: ReceiverConfig = parse("r.toml", &text).expect("a config");
        let start = coaxle_clock::Instant::EPOCH;
        let error = Receiver::new(&config, start, 1).expect_err("no receiver");
        assert!(error.to_string().starts_with(expected), "{error}\n{rest}");
    }
}
