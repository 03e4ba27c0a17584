//! A slave of several masters: far axes of several nodes, and other slaves.

use crate::nodes::{Far, MILLISECOND, receiver, run};
use coaxle_axis::{AxisStatus, CoupleState};
use coaxle_gear::{GearInMultiMaster, MultiMasterSync, Ratios};
use coaxle_node::config::parse;
use coaxle_node::frame::{decode, seal};
use coaxle_node::{Channel, Node};
use coaxle_receiver::{Health, HealthName, Receiver, ReceiverConfig, SignalRow};
use coaxle_slave::{Command, CouplingPhase, Dynamics, Refusal};

/// Belt, press and a slave of its own lead the sum.
const LINE: &str = "
[[far]]
node = 'infeed'
axes = [{ id = 1, name = 'belt' }]
delay = 'off'
[[far]]
node = 'press'
axes = ['1-2']
delay = 'off'
[[slave]]
name = 'sum'
id = 9
master = 'belt'
further-masters = ['press.2', 'roll']
limits = { velocity = 1000, acceleration = 5000, deceleration = 4000, jerk = 100000 }
[[slave.step]]
when = { master-ready = true }
do = { power = true }
[[slave.step]]
when = { after-s = 2 }
do = { gear-in-multi-master = { ratios = [0.5, -1.0, 0.25] } }
[[slave]]
name = 'roll'
id = 2
master = 'press.1'
";

const BELT: f64 = 400.0;
const PRESS_1: f64 = 200.0;
const PRESS_2: f64 = 100.0;

/// Limits of the slave.
const VELOCITY: f64 = 1_000.0;
const ACCELERATION: f64 = 5_000.0;
const JERK: f64 = 100_000.0;

fn line() -> (Receiver, [Far; 2]) {
    // Both nodes drift, by −20 and 15 ppm.
    let infeed = Far::new(0, 1_000_020, &[BELT]);
    let press = Far::new(1, 999_985, &[PRESS_1, PRESS_2]);
    (receiver(LINE), [infeed, press])
}

/// The set positions of the slave, differenced from cycle to cycle.
#[derive(Default)]
struct Differences {
    last: [f64; 4],
    seen: usize,
}

impl Differences {
    /// Adds a cycle. A master's velocity is per second of its own clock: by the drift its positions
    /// move differently, which shows at once when the slave is coupled, as some 5 % of the jerk
    /// here.
    fn keep(&mut self, row: &SignalRow) {
        let Some(position) = row.slaves[0].position else {
            return;
        };
        self.last.rotate_left(1);
        self.last[3] = position;
        self.seen += 1;
        let ([p0, p1, p2, p3], dt) = (self.last, 1e-3_f64);
        let velocity = (p3 - p2) / dt;
        let acceleration = (p3 - 2.0 * p2 + p1) / (dt * dt);
        let jerk = (p3 - 3.0 * p2 + 3.0 * p1 - p0) / (dt * dt * dt);
        // A jerk needs four positions.
        if self.seen > 3 {
            assert!(velocity.abs() <= VELOCITY, "{velocity}");
            assert!(acceleration.abs() <= ACCELERATION, "{acceleration}");
            assert!(jerk.abs() <= JERK * 1.1, "{jerk} {:?}", self.last);
        }
    }
}

/// The sum of its masters in a cycle.
fn sum(row: &SignalRow, ratios: [f64; 3]) -> f64 {
    let belt = row.axes[0].corrected_position.expect("known");
    let press = row.axes[2].corrected_position.expect("known");
    let roll = row.slaves[1].position.expect("known");
    ratios[0] * belt + ratios[1] * press + ratios[2] * roll
}

const RATIOS: [f64; 3] = [0.5, -1.0, 0.25];

/// Runs until the slave is in sync, within its limits on the way.
fn in_sync(receiver: &mut Receiver, far: &mut [Far], differences: &mut Differences) {
    run(receiver, far, 4_000 * MILLISECOND, |row, _| {
        differences.keep(row);
    });
    let slave = receiver.snapshot().signals.slaves[0];
    assert_eq!(slave.phase, Some(CouplingPhase::InSync));
    let expected = 0.5 * BELT - PRESS_2 + 0.25 * PRESS_1;
    assert!((slave.velocity.expect("an axis") - expected).abs() < 0.1);
}

#[test]
fn it_is_led_to_the_sum_of_axes_of_several_nodes_and_follows_it() {
    let (mut receiver, mut far) = line();
    let mut differences = Differences::default();
    in_sync(&mut receiver, &mut far, &mut differences);
    let mut apart = None;
    run(&mut receiver, &mut far, 6_000 * MILLISECOND, |row, _| {
        differences.keep(row);
        let now = row.slaves[0].position.expect("an axis") - sum(row, RATIOS);
        // Coupled by velocity: its distance to the sum is any, but constant.
        let before = *apart.get_or_insert(now);
        assert!((now - before).abs() < 1e-9, "{now} {before}");
    });
    assert_eq!(receiver.snapshot().health, Health::Ok);
    // And leaves it.
    let slave = receiver.slave_number("sum").expect("a slave");
    assert!(receiver.command(slave, &Command::GearOut {}).is_ok());
    let halt = Command::Halt {
        dynamics: Dynamics::default(),
    };
    assert!(receiver.command(slave, &halt).is_ok());
    run(&mut receiver, &mut far, 7_000 * MILLISECOND, |row, _| {
        differences.keep(row);
    });
    let state = receiver.snapshot().signals.slaves[0].state;
    assert_eq!(state, AxisStatus::Standstill);
}

#[test]
fn any_master_that_falls_silent_stops_it_within_its_limits_for_good() {
    for silent in [0, 1] {
        let (mut receiver, mut far) = line();
        let mut differences = Differences::default();
        in_sync(&mut receiver, &mut far, &mut differences);
        far[silent].silent = true;
        run(&mut receiver, &mut far, 6_000 * MILLISECOND, |row, _| {
            differences.keep(row);
        });
        let slave = receiver.snapshot().signals.slaves[0];
        assert_eq!(slave.state, AxisStatus::ErrorStop);
        assert_eq!((slave.error, slave.velocity), (0x42a0, Some(0.0)));
        let health = receiver.snapshot().health;
        assert_eq!(health, Health::SlaveFailed { slave: 0 });
        // The master returns, and the slave stays at its position until it is commanded.
        far[silent].silent = false;
        far[silent].epoch = 2;
        run(&mut receiver, &mut far, 9_000 * MILLISECOND, |row, _| {
            differences.keep(row);
            assert_eq!(row.slaves[0].position, slave.position);
        });
        let number = receiver.slave_number("sum").expect("a slave");
        assert!(receiver.command(number, &Command::Reset {}).is_ok());
        assert!(receiver.command(number, &gear(&RATIOS)).is_ok());
        run(&mut receiver, &mut far, 10_000 * MILLISECOND, |row, _| {
            differences.keep(row);
        });
        let slave = receiver.snapshot().signals.slaves[0];
        assert_eq!(slave.phase, Some(CouplingPhase::InSync));
        assert_eq!(receiver.snapshot().health, Health::Ok);
    }
}

#[test]
fn a_master_that_does_not_count_may_be_lost() {
    let (mut receiver, mut far) = line();
    let mut differences = Differences::default();
    in_sync(&mut receiver, &mut far, &mut differences);
    let number = receiver.slave_number("sum").expect("a slave");
    // By the belt alone, an axis of the infeed.
    assert!(receiver.command(number, &gear(&[0.5])).is_ok());
    run(&mut receiver, &mut far, 5_000 * MILLISECOND, |row, _| {
        differences.keep(row);
    });
    far[1].silent = true;
    run(&mut receiver, &mut far, 6_000 * MILLISECOND, |row, _| {
        differences.keep(row);
        assert_eq!(row.slaves[0].phase, Some(CouplingPhase::InSync));
    });
    assert_eq!(receiver.snapshot().signals.far[1].health, HealthName::Error);
    // Even a command to couple again does not take the slave along.
    let refused = receiver.command(number, &gear(&RATIOS));
    assert_eq!(refused, Err(Refusal::NoMaster));
    run(&mut receiver, &mut far, 6_100 * MILLISECOND, |row, _| {
        differences.keep(row);
    });
    let slave = receiver.snapshot().signals.slaves[0];
    assert_eq!((slave.error, slave.refusal), (0, 0x4b09));
}

#[test]
fn it_is_not_ready_before_all_of_its_masters_are() {
    let (mut receiver, mut far) = line();
    far[1].silent = true;
    run(&mut receiver, &mut far, 3_000 * MILLISECOND, |row, _| {
        assert_eq!(row.slaves[0].state, AxisStatus::Disabled);
    });
    assert!(receiver.snapshot().signals.axes[0].synced);
    far[1].silent = false;
    run(&mut receiver, &mut far, 6_000 * MILLISECOND, |_, _| {});
    let slave = receiver.snapshot().signals.slaves[0];
    assert_eq!(slave.phase, Some(CouplingPhase::InSync));
}

/// Coupled from the start, by its first master alone; all of its masters are present at once.
#[test]
fn a_coupling_from_the_start_is_changed_for_one_of_several_masters() {
    let text = LINE.replace(
        "[[slave.step]]\nwhen = { master-ready = true }\ndo = { power = true }\n",
        "couple = 'gear'\ngear.ratio = 0.5\n",
    );
    let text = text.replace("when = { after-s = 2 }", "when = { in-sync = true }");
    let (mut receiver, mut far) = (receiver(&text), line().1);
    run(&mut receiver, &mut far, 4_000 * MILLISECOND, |_, _| {});
    let slave = receiver.snapshot().signals.slaves[0];
    assert_eq!((slave.error, slave.refusal), (0, 0));
    assert_eq!(slave.phase, Some(CouplingPhase::InSync));
    let expected = 0.5 * BELT - PRESS_2 + 0.25 * PRESS_1;
    assert!((slave.velocity.expect("an axis") - expected).abs() < 0.1);
}

#[test]
fn a_slave_that_is_anybody_s_master_shows_that_it_is() {
    let (mut receiver, mut far) = line();
    run(&mut receiver, &mut far, 3_000 * MILLISECOND, |_, _| {});
    let _ = receiver.cycle(receiver.next_cycle());
    let mut states = Vec::new();
    while let Some(outgoing) = receiver.transmit() {
        if outgoing.channel == Channel::Slaves {
            let (key, mut frame) = ("coaxle/line/slaves", Vec::new());
            seal(key, outgoing.body, None, &mut frame);
            decode(key, &frame, |axis| states.push(axis.couple_state)).expect("a frame");
        }
    }
    assert_eq!(states, [CoupleState::MasterSlave, CoupleState::Slave]);
}

fn gear(ratios: &[f64]) -> Command {
    Command::GearInMultiMaster(GearInMultiMaster {
        ratios: Ratios::new(ratios).expect("ratios"),
        dynamics: Dynamics::default(),
        sync_mode: MultiMasterSync::default(),
    })
}

#[test]
fn masters_that_are_not_there_are_refused_by_name() {
    let two = "limits = { velocity = 1, acceleration = 1, jerk = 1 }\nmaster = 'belt'";
    for (slaves, expected) in [
        (
            format!("[[slave]]\nname = 'a'\n{two}\nfurther-masters = ['press.1', 'press.3']"),
            "slave[0].further-masters[1]: received \"press.3\", expected one of: belt, press.1, \
             press.2",
        ),
        (
            format!("[[slave]]\nname = 'a'\n{two}\nfurther-masters = ['press.1', '']"),
            "slave[0].further-masters[1]: received \"\", expected one of: belt, press.1, press.2",
        ),
        (
            format!("[[slave]]\nname = 'a'\n{two}\nfurther-masters = ['press.1', 'infeed.1']"),
            "slave[0].further-masters[1]: received \"infeed.1\" twice, expected each master once",
        ),
        (
            format!(
                "[[slave]]\nname = 'a'\n{two}\nfurther-masters = ['press.1', 'press.2', 'b', 'c']"
            ),
            "slave[0].further-masters: received 4, expected at most 3",
        ),
        (
            format!(
                "[[slave]]\nname = 'a'\n{two}\nfurther-masters = ['press.1', 'b']\n\
                 [[slave]]\nname = 'b'\nmaster = 'c'\n\
                 [[slave]]\nname = 'c'\n{two}\nfurther-masters = ['a']"
            ),
            "slave[0].further-masters[1]: 0x816f: received \"b\", which follows \"a\" in the end \
             or a circle of others, expected a far or virtual axis at the root",
        ),
        (
            // The axis has a name of its own, but node and id are accepted as well.
            format!("[[slave]]\nname = 'infeed.1'\n{two}"),
            "slave[0].name: received \"infeed.1\", which is a far axis, expected a name of its own",
        ),
        (
            format!("[[slave]]\nname = 'a'\n{two}\nfurther-masters = ['a']"),
            "slave[0].further-masters[0]: 0x816f: received \"a\", which follows \"a\" in the end",
        ),
    ] {
        let far = LINE.split("[[slave]]").next().expect("far nodes");
        let text = format!("name = 'line'\ncycle-time-us = 1000\n{far}{slaves}");
        let config: ReceiverConfig = parse("r.toml", &text).expect("a config");
        let start = coaxle_clock::Instant::EPOCH;
        let error = Receiver::new(&config, start, 1).expect_err("no receiver");
        assert!(error.to_string().starts_with(expected), "{error}\n{slaves}");
    }
}
