//! Several slaves: life cycle, cams, programs, slaves of slaves.

use std::slice::from_mut;

use crate::bench::{Far, MILLISECOND, Near, SECOND, Shown, SlaveShown, VELOCITY, run, run_pair};
use coaxle_axis::{AxisStatus, CoupleState};
use coaxle_clock::Instant;
use coaxle_node::config::parse;
use coaxle_node::frame::decode;
use coaxle_receiver::{Health, ProgramState, Receiver, ReceiverConfig};
use coaxle_slave::{Command, CouplingPhase};

const LIMITS: &str = "limits = { velocity = 2000, acceleration = 100000, jerk = 1e7 }";

/// A plate of 100 u, up by 40 u and down again.
const CAM: &str = "
[[slave.cams]]
table-id = 1
course = 'cyclic'
point = [
  { master = 0, slave = 0, law = 'polynom5' },
  { master = 50, slave = 40, law = 'polynom5' },
  { master = 100, slave = 0 },
]
[[slave.cams]]
table-id = 2
course = 'cyclic'
point = [
  { master = 0, slave = 0, law = 'bestehorn' },
  { master = 60, slave = 20, law = 'bestehorn' },
  { master = 100, slave = 0 },
]
";

fn slave(snapshot: &Shown, n: usize) -> SlaveShown {
    snapshot.slaves[n]
}

/// The largest step of a slave beyond that of its velocities, in units of the slave.
fn largest_jump(near: &Near, n: usize) -> f64 {
    near.snapshots
        .windows(2)
        .filter(|pair| slave(&pair[0], n).status != AxisStatus::Disabled)
        .filter_map(|pair| {
            let [before, after] = [0, 1].map(|k| slave(&pair[k], n).set);
            let (before, after) = (before?, after?);
            // Mean velocity over a cycle of 1 ms.
            let way = 0.5e-3 * (before.velocity + after.velocity);
            Some((after.position - before.position - way).abs())
        })
        .fold(0.0, f64::max)
}

fn refusal(slaves: &str) -> String {
    let text = format!("name = 'saw'\nmaster.node = 'conveyor'\ncycle-time-us = 1000\n{slaves}");
    let config: ReceiverConfig = parse("r.toml", &text).expect("a config");
    let refused = Receiver::new(&config, Instant::EPOCH, 1);
    refused.expect_err("no receiver").to_string()
}

#[test]
fn what_no_receiver_can_have_is_refused_by_name() {
    let two = |a: &str, b: &str| format!("[[slave]]\nname = 'a'\n{a}\n[[slave]]\nname = 'b'\n{b}");
    let limited = |rest: &str| format!("[[slave]]\n{LIMITS}\n{rest}");
    for (slaves, expected) in [
        (
            two("master = 'b'", "master = 'a'"),
            "slave[0].master: 0x816f: received \"b\"",
        ),
        (
            two("", "master = 'b'"),
            "slave[1].master: 0x816f: received \"b\"",
        ),
        (
            two("", "master = 'c'"),
            "slave[1].master: received \"c\", expected one of: conveyor.1, a",
        ),
        (
            two("", "id = 1"),
            "slave[1].id: received 1 twice, expected an id of its own",
        ),
        (
            "[[slave]]\n[[slave]]".to_owned(),
            "slave[1].name: received \"slave\" twice",
        ),
        (
            "[[slave]]\nname = 'conveyor.1'".to_owned(),
            "slave[0].name: received \"conveyor.1\", which is a far axis",
        ),
        (
            (0..129)
                .map(|n| format!("[[slave]]\nname = 's{n}'\n"))
                .collect(),
            "slave: received 129 slaves, expected at most 128",
        ),
        (
            limited("limits.velocity = 0")
                .replace(
                    &format!("{LIMITS}\n"),
                    "limits = { acceleration = 1, jerk = 1, velocity = 0 }\n",
                )
                .replace("limits.velocity = 0", ""),
            "slave[0].limits: velocity: received 0",
        ),
        (
            limited("couple.cam.table = 7"),
            "slave[0].couple.cam.table: 0x4216: ",
        ),
        (
            limited("cams = ['no-such.toml']"),
            "slave[0].cams[0]: no-such.toml: cannot be read",
        ),
        (
            limited("cams = [{ point = [{ master = 0, slave = 0 }] }]"),
            "slave[0].cams[0]: 0x4b32: received no table-id",
        ),
        (
            limited(&format!(
                "{CAM}[[slave.cams]]\ntable-id = 1\ntable.rows = [[0, 0], [1, 1]]"
            )),
            "slave[0].cams[2]: 0x4063: ",
        ),
        (
            limited("[[slave.step]]\nrepeat-from = 'there'"),
            "slave[0].step[0].repeat-from: received \"there\"",
        ),
        (
            limited(
                "[slave.marks]\nspacing = 5\nsensor-distance = 9\nspacing-swing = { amplitude = 5, marks = 4 }",
            ),
            "slave[0].marks.spacing-swing.amplitude: received 5",
        ),
        (limited("tool.ratio = 0"), "slave[0].tool.ratio: received 0"),
        (
            limited("tool.cuts-every = 360\n[[slave.step]]\ncut = true"),
            "slave[0].tool.cuts-every: received one beside steps that cut",
        ),
    ] {
        let message = refusal(&slaves);
        assert!(message.starts_with(expected), "{message}\n{slaves}");
    }
}

#[test]
fn slaves_follow_slaves_and_all_are_in_one_frame_by_id() {
    let mut far = Far::new(1000, 100, 0, 1);
    let mut near = Near::new(
        1000,
        0,
        "[[slave]]\nname = 'last'\nid = 9\nmaster = 'middle'\ngear = { ratio = 2.0, offset = 1.0 }\n\
         [[slave]]\nname = 'first'\nid = 7\n\
         [[slave]]\nname = 'middle'\nid = 3\nmaster = 'first'\ngear.ratio = -0.5\n",
    );
    run_pair(&mut far, &mut near, SECOND);
    for snapshot in near.newest(500) {
        let master = snapshot.master.expect("a master").corrected.position;
        let set = |n: usize| slave(snapshot, n).set.expect("coupled").position;
        assert_eq!(set(1), master);
        // Ratios that are powers of two do not round.
        assert_eq!(set(2), -0.5 * master);
        assert_eq!(set(0), 1.0 - master, "of the same cycle");
    }
    let mut axes = Vec::new();
    let frame = near.slave_frame.as_ref().expect("a frame");
    decode("coaxle/saw/slaves", frame, |axis| axes.push(*axis)).expect("a good frame");
    let told: Vec<_> = axes.iter().map(|a| (a.axis_id, a.couple_state)).collect();
    assert_eq!(
        told,
        [
            (3, CoupleState::MasterSlave),
            (7, CoupleState::MasterSlave),
            (9, CoupleState::Slave)
        ]
    );
}

#[test]
fn a_cam_from_the_start_follows_the_corrected_master() {
    let mut far = Far::new(1000, 300, 0, 1);
    let config = format!("[[slave]]\n{LIMITS}\ncouple = {{ cam = {{ table = 1 }} }}\n{CAM}");
    let mut near = Near::new(1000, 0, &config);
    run_pair(&mut far, &mut near, 4 * SECOND);
    let last = near.last();
    assert_eq!(last.health, Health::Ok);
    assert_eq!(slave(last, 0).status, AxisStatus::SynchronizedMotion);
    for snapshot in near.newest(500) {
        let x = snapshot
            .master
            .expect("a master")
            .corrected
            .position
            .rem_euclid(100.0);
        let z = if x < 50.0 {
            x / 50.0
        } else {
            (100.0 - x) / 50.0
        };
        // Quintic of a stretch from rest to rest: 10z³ − 15z⁴ + 6z⁵.
        let expected = 40.0 * z * z * z * (10.0 - 15.0 * z + 6.0 * z * z);
        let set = slave(snapshot, 0).set.expect("coupled").position;
        assert!((set - expected).abs() < 1e-9, "{set} {expected}");
    }
    assert!(largest_jump(&near, 0) < 1e-2, "{}", largest_jump(&near, 0));
}

#[test]
fn a_program_couples_switches_scales_and_edits_without_a_jump() {
    let mut far = Far::new(1000, 0, 0, 1);
    let config = format!(
        "mode = 'bypass'\n[[slave]]\n{LIMITS}\n{CAM}
        [[slave.step]]
        when = {{ master-ready = true }}
        do = {{ power = true }}
        [[slave.step]]
        do = {{ cam-in = {{ table = 1, activation.mode = 'next-cycle' }} }}
        [[slave.step]]
        when = {{ in-sync = true }}
        [[slave.step]]
        when = {{ after-s = 0.5 }}
        do = {{ cam-in = {{ table = 2, activation.mode = 'next-cycle' }} }}
        [[slave.step]]
        when = {{ after-s = 0.5 }}
        do = {{ cam-scaling = {{ activation.mode = 'next-cycle', scaling.slave = {{ scaling = 2 }} }} }}
        [[slave.step]]
        when = {{ after-s = 0.5 }}
        do = {{ set-cam-online-change-mode = {{ table = 2, mode.activation.mode = 'next-cycle' }} }}
        [[slave.step]]
        do = {{ write-motion-function = {{ table = 2, points = [{{ index = 2, law = 'bestehorn', type = 'rest', master = 40, slave = 15 }}] }} }}
        "
    );
    let mut near = Near::new(1000, 0, &config);
    run_pair(&mut far, &mut near, 4 * SECOND);
    let last = slave(near.last(), 0);
    assert_eq!((last.error, last.refusal), (None, None));
    let program = last.program.expect("a program");
    assert_eq!((program.state, program.step), (ProgramState::Finished, 7));
    let highest = |from: usize, to: usize| {
        let set = |s: &Shown| slave(s, 0).set.expect("an axis").position;
        near.snapshots[from..to].iter().map(set).fold(0.0, f64::max)
    };
    let [a, b, c, d] = [
        highest(300, 500),
        highest(1_000, 1_200),
        highest(1_500, 1_700),
        highest(3_000, 3_500),
    ];
    // Plate 1 has 40, plate 2 first 20, then twice that, then twice its new 15.
    for (height, expected) in [(a, 40.0), (b, 20.0), (c, 40.0), (d, 30.0)] {
        assert!((height - expected).abs() < 0.1, "{a} {b} {c} {d}");
    }
    assert!(largest_jump(&near, 0) < 2e-2, "{}", largest_jump(&near, 0));
}

#[test]
fn a_change_that_is_refused_when_it_is_due_stops_the_program_and_not_the_slave() {
    let mut far = Far::new(1000, 0, 0, 1);
    let config = format!(
        "mode = 'bypass'\n[[slave]]\n{LIMITS}\ncouple = {{ cam.table = 1 }}\n{CAM}
        [[slave.step]]
        when = {{ time-s = 1 }}
        do = {{ cam-scaling = {{ activation.mode = 'next-cycle', scaling.slave = {{ offset = 500 }} }} }}
        [[slave.step]]
        when = {{ time-s = 9 }}
        "
    );
    let mut near = Near::new(1000, 0, &config);
    run_pair(&mut far, &mut near, 2 * SECOND);
    assert_eq!(near.last().health, Health::CommandRefused { slave: 0 });
    let last = slave(near.last(), 0);
    assert_eq!(last.refusal.map(|refusal| refusal.code()), Some(0x421a));
    let job = last.refusal.and_then(|refused| refused.job).unwrap();
    assert_eq!(job.command, "MC_CamScaling");
    assert_eq!(last.program.map(|p| p.state), Some(ProgramState::Refused));
    assert_eq!(last.status, AxisStatus::SynchronizedMotion);
    assert_eq!(last.phase, Some(CouplingPhase::InSync));
}

#[test]
fn a_refusal_that_is_expected_is_passed_and_one_that_is_not_ends_the_program() {
    let program = |expected: &str| {
        format!(
            "[[slave]]\n{LIMITS}\n[[slave.step]]\ndo = {{ gear-in = {{ ratio = 2 }} }}\n{expected}\n[[slave.step]]\nwhen = {{ time-s = 9 }}"
        )
    };
    for (expected, state, health) in [
        (
            "",
            ProgramState::Refused,
            Health::CommandRefused { slave: 0 },
        ),
        (
            "expect-refusal = 0x422a",
            ProgramState::Running,
            Health::WaitingForMaster,
        ),
        (
            "expect-refusal = 0x1",
            ProgramState::NotAsExpected,
            Health::CommandRefused { slave: 0 },
        ),
    ] {
        let mut near = Near::new(1000, 0, &program(expected));
        run(None, from_mut(&mut near), 100 * MILLISECOND);
        let last = slave(near.last(), 0);
        // No step has given it power.
        assert_eq!(last.refusal.map(|refusal| refusal.code()), Some(0x422a));
        assert_eq!(last.program.map(|p| p.state), Some(state));
        assert_eq!(near.last().health, health);
    }
}

/// A geared slave with limits, at the velocity of its master.
fn geared(rest: &str) -> (Far, Near) {
    geared_in("time", rest)
}

fn geared_in(mode: &str, rest: &str) -> (Far, Near) {
    let mut far = Far::new(1000, 100, 0, 1);
    let limits = "limits = { velocity = 2000, acceleration = 5000, jerk = 1e6 }";
    let config = format!("mode = '{mode}'\n[[slave]]\n{limits}\n{rest}");
    let mut near = Near::new(1000, 0, &config);
    run_pair(&mut far, &mut near, SECOND);
    assert_eq!(near.last().health, Health::Ok);
    (far, near)
}

#[test]
fn a_lost_master_stops_the_slave_within_its_limits_for_good() {
    let (_, mut near) = geared("gear.ratio = 2.0");
    let set = slave(near.last(), 0).set.expect("coupled");
    assert!((set.velocity - 2.0 * VELOCITY).abs() < 1.0);
    let before = near.snapshots.len();
    run(None, from_mut(&mut near), 2 * SECOND);
    for pair in near.snapshots[before..].windows(2) {
        let [a, b] = [0, 1].map(|k| slave(&pair[k], 0).set.expect("an axis").velocity);
        // 5 000 u/s² in a cycle of 1 ms.
        assert!((b - a).abs() <= 5.0 * (1.0 + 1e-6), "{a} {b}");
    }
    // The node returns, and the slave stays at its position.
    let mut again = Far::new(1000, 100, 2 * SECOND, 2);
    run_pair(&mut again, &mut near, 4 * SECOND);
    assert_eq!(near.last().health, Health::SlaveFailed { slave: 0 });
    let last = slave(near.last(), 0);
    assert_eq!(last.status, AxisStatus::ErrorStop);
    assert_eq!(last.error.map(|error| error.code()), Some(0x42a0));
    assert_eq!(last.set.expect("an axis").velocity, 0.0);
    assert_eq!(last.phase, None);
}

#[test]
fn a_slave_whose_master_is_in_error_stops_too_and_both_can_be_reset() {
    // In other modes the far axis would be brought to its master's new position.
    let (mut far, mut near) = geared_in(
        "bypass",
        "name = 'first'\nmax = 0\n[[slave]]\nname = 'second'\nmaster = 'first'\nlimits = { velocity = 2000, acceleration = 5000, jerk = 1e6 }"
            .replace("max = 0\n", "")
            .as_str(),
    );
    near.tweak = Some(Box::new(|sent, sample| {
        if sent > 1_100 * MILLISECOND && sent < 1_300 * MILLISECOND {
            // 300 u in a cycle are far above its velocity limit of 2 000 u/s.
            sample.set.position += 300.0;
        }
    }));
    run_pair(&mut far, &mut near, 2 * SECOND);
    let codes = [0, 1].map(|n| slave(near.last(), n).error.map(|error| error.code()));
    assert_eq!(codes, [Some(0x42dd), Some(0x42a0)]);
    for name in ["first", "second"] {
        let number = near.node.slave_number(name).expect("a slave");
        assert!(near.node.command(number, &Command::Reset {}).is_ok());
    }
    run_pair(&mut far, &mut near, 3 * SECOND);
    for n in [0, 1] {
        assert_eq!(slave(near.last(), n).status, AxisStatus::Standstill);
    }
    assert_eq!(near.last().health, Health::Ok);
}

#[test]
fn a_slave_without_limits_takes_commands() {
    let mut near = Near::new(1000, 0, "");
    let number = near.node.slave_number("slave").expect("a slave");
    assert_eq!(near.node.slave_number("saw"), None);
    assert!(near.node.command(number, &Command::Power(true)).is_ok());
    run(None, from_mut(&mut near), 10 * MILLISECOND);
    let last = slave(near.last(), 0);
    assert_eq!((last.status, last.refusal), (AxisStatus::Standstill, None));
    assert_eq!(near.last().health, Health::WaitingForMaster);
}
