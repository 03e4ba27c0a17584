//! Every situation of TS5055 13 that is not permitted, and inputs that make no sense.

use super::super::{SawForm, SawRefusal, SyncMask, saw_table_id};
use super::*;

fn refused(command: &GearInPos, moment: &CouplingMoment) -> SawRefusal {
    command.plan(moment).expect_err("is refused")
}

/// The situations that TS5055 13 lists: command, coupling moment and code.
#[test]
fn every_situation_of_ts5055_13_is_refused() {
    const RESTING: (f64, f64) = (0.0, 0.0);
    const FORWARD: (f64, f64) = (0.0, 100.0);
    let ahead = (50.0, 50.0);
    let plain = SyncLimits::default();
    let negative = |field: &str| {
        let limit = |name: &str| (name == field).then_some(-1.0);
        SyncLimits {
            velocity: limit("velocity"),
            acceleration: limit("acceleration"),
            deceleration: limit("deceleration"),
            jerk: limit("jerk"),
            ..plain
        }
    };
    // Master, slave, gear, synchronisation positions, limits; for a velocity, and to positions.
    let velocity = [
        (
            "slave moves, master rests",
            RESTING,
            FORWARD,
            1.0,
            plain,
            0x426e,
        ),
        ("gear is 0", FORWARD, RESTING, 0.0, plain, 0x421b),
        (
            "velocity below 0",
            FORWARD,
            RESTING,
            1.0,
            negative("velocity"),
            0x42dd,
        ),
        (
            "acceleration below 0",
            FORWARD,
            RESTING,
            1.0,
            negative("acceleration"),
            0x42dd,
        ),
        (
            "deceleration below 0",
            FORWARD,
            RESTING,
            1.0,
            negative("deceleration"),
            0x42dd,
        ),
        (
            "jerk below 0",
            FORWARD,
            RESTING,
            1.0,
            negative("jerk"),
            0x42dd,
        ),
    ];
    for (situation, master, slave, gear, limits, code) in velocity {
        let start = moment(master, slave);
        for mode in [SyncMode::default(), SyncMode::time_based(SyncMask::empty())] {
            let command = to_velocity(gear, mode, limits);
            assert_eq!(
                command.plan(&start).unwrap_err().code(),
                code,
                "{situation}"
            );
        }
        let command = to_position(gear, ahead, SyncMode::default(), limits);
        assert_eq!(refused(&command, &start).code(), code, "{situation}");
    }
    let positions = [
        ("master's position behind it", FORWARD, 1.0, (-50.0, 50.0)),
        ("master's position where it is", FORWARD, 1.0, (0.0, 50.0)),
        (
            "the same, master backwards",
            (0.0, -100.0),
            1.0,
            (50.0, 50.0),
        ),
        (
            "slave's position behind it, gear above 0",
            FORWARD,
            1.0,
            (50.0, -50.0),
        ),
        (
            "slave's position ahead of it, gear below 0",
            FORWARD,
            -1.0,
            (50.0, 50.0),
        ),
    ];
    for (situation, master, gear, sync) in positions {
        let command = to_position(gear, sync, SyncMode::default(), plain);
        let refusal = refused(&command, &moment(master, RESTING));
        assert_eq!(refusal.code(), 0x42de, "{situation}");
    }
    let table = saw_table_id(3, |id| id == 253).unwrap_err();
    assert_eq!(
        table.code(),
        0x4063,
        "another table has the id of the profile's"
    );
}

#[test]
fn a_master_at_rest_takes_only_a_slave_at_rest() {
    let command = to_position(
        1.0,
        (100.0, 100.0),
        SyncMode::default(),
        SyncLimits::default(),
    );
    let refusal = refused(&command, &moment((0.0, 0.0), (0.0, 1.0)));
    assert_eq!(refusal.code(), 0x426e);
    let plan = command.plan(&moment((0.0, 0.0), (0.0, 0.0))).unwrap();
    assert_eq!(plan.form(), SawForm::Quintic);

    let command = to_velocity(1.0, SyncMode::default(), SyncLimits::default());
    let refusal = command.plan(&moment((0.0, 0.0), (0.0, 1.0))).unwrap_err();
    assert_eq!(refusal.code(), 0x426e);
    let plan = command.plan(&moment((0.0, 0.0), (0.0, 0.0))).unwrap();
    assert_eq!(plan.form(), SawForm::Synchronous);
}

#[test]
fn a_gear_that_couples_nothing_is_refused() {
    let start = moment((0.0, 1.0), (0.0, 0.0));
    let mut command = to_velocity(0.0, SyncMode::default(), SyncLimits::default());
    assert_eq!(command.plan(&start).unwrap_err().code(), 0x421b);
    command.ratio = Ratio {
        numerator: 1.0,
        denominator: 0,
    };
    assert_eq!(command.plan(&start).unwrap_err().code(), 0x4b06);
    command.ratio = Ratio {
        numerator: 1.0,
        denominator: 4,
    };
    assert_eq!(command.plan(&start).unwrap().line().ratio, 0.25);
}

#[test]
fn limits_are_above_zero_and_the_gear_below_them() {
    let start = moment((0.0, 100.0), (0.0, 0.0));
    for bad in [0.0, -1.0, f64::NAN] {
        let good = SyncLimits::default();
        let limits = [
            SyncLimits {
                velocity: Some(bad),
                ..good
            },
            SyncLimits {
                acceleration: Some(bad),
                ..good
            },
            SyncLimits {
                deceleration: Some(bad),
                ..good
            },
            SyncLimits {
                jerk: Some(bad),
                ..good
            },
        ];
        for limits in limits {
            let command = to_velocity(1.0, SyncMode::default(), limits);
            assert_eq!(command.plan(&start).unwrap_err().code(), 0x42dd);
        }
    }
    let command = to_velocity(101.0, SyncMode::default(), SyncLimits::default());
    let refusal = command.plan(&start).unwrap_err();
    assert_eq!(refusal.code(), 0x42dd);
    // The axis's 1e4 u/s divided by the gear.
    let speed = command.remedy(&start).master_speed.unwrap();
    assert!((speed - 1e4 / 101.0).abs() < 1e-4, "{speed}");
}

#[test]
fn synchronisation_positions_lie_ahead() {
    let at = |gear, sync, master, slave| {
        let command = to_position(gear, sync, SyncMode::default(), SyncLimits::default());
        command
            .plan(&moment(master, slave))
            .map_err(|refusal| refusal.code())
    };
    let slave = (0.0, 0.0);
    assert_eq!(at(1.0, (-10.0, 10.0), (0.0, 100.0), slave), Err(0x42de));
    assert_eq!(at(1.0, (0.0, 10.0), (0.0, 100.0), slave), Err(0x42de));
    assert_eq!(at(1.0, (10.0, 10.0), (0.0, -100.0), slave), Err(0x42de));
    assert_eq!(at(1.0, (10.0, -10.0), (0.0, 100.0), slave), Err(0x42de));
    assert_eq!(at(-1.0, (10.0, 10.0), (0.0, 100.0), slave), Err(0x42de));
    assert!(at(-1.0, (10.0, -10.0), (0.0, 100.0), slave).is_ok());
    assert!(at(1.0, (-10.0, -10.0), (0.0, -100.0), slave).is_ok());
}

#[test]
fn the_table_of_the_profile_must_be_free() {
    // 256 − 3.
    assert_eq!(saw_table_id(3, |_| false), Ok(253));
    assert_eq!(saw_table_id(3, |id| id == 253).unwrap_err().code(), 0x4063);
    for axis_id in [0, 256] {
        assert_eq!(saw_table_id(axis_id, |_| false).unwrap_err().code(), 0x4a00);
    }
}

#[test]
fn a_position_is_not_reached_by_time() {
    let mode = SyncMode::time_based(SyncMask::empty());
    let command = to_position(1.0, (10.0, 10.0), mode, SyncLimits::default());
    let refusal = refused(&command, &moment((0.0, 1.0), (0.0, 0.0)));
    assert_eq!(refusal.code(), 0x4b04);
}

#[test]
fn what_is_not_a_number_is_named() {
    let mut start = moment((0.0, 1.0), (0.0, 0.0));
    start.slave.velocity = f64::NAN;
    let command = to_velocity(1.0, SyncMode::default(), SyncLimits::default());
    let refusal = command.plan(&start).unwrap_err();
    assert_eq!(
        std::string::ToString::to_string(&refusal),
        "0x4b06: slave-velocity: received NaN, expected a finite number"
    );
}
