//! The samples of the manual, with its numbers, and properties of all flying gears.

use proptest::prelude::*;
use std::string::ToString;

use super::FlyingGearPhase::{Engaged, Engaging, Released, Releasing, Waiting};
use super::*;
use coaxle_curve::profile::Limits;

fn moving(position: f64, velocity: f64) -> Kinematics {
    Kinematics {
        position,
        velocity,
        acceleration: 0.0,
    }
}

/// Sample 1: master and slave in the same direction, both back to their start.
const SAMPLE_1: FlyingGearParameters = FlyingGearParameters {
    ratio: 1.0,
    master_sync_position: 460.0,
    slave_sync_position: 450.0,
    slave_desync_position: 450.0,
    slave_stop_position: 500.0,
    default_slave_negative: false,
};

/// Sample 2: opposite directions, the slave starts 50 below its sync position.
const SAMPLE_2: FlyingGearParameters = FlyingGearParameters {
    ratio: -1.0,
    slave_stop_position: 400.0,
    ..SAMPLE_1
};

/// Sample 3: as sample 1, but stopped 100 after the desync position.
const SAMPLE_3: FlyingGearParameters = FlyingGearParameters {
    slave_stop_position: 350.0,
    ..SAMPLE_1
};

/// Leads the master to each position in small steps and returns the slave there.
fn travel(gear: &mut FlyingGear, from: f64, to: f64) -> (f64, FlyingGearPhase) {
    let mut slave = f64::NAN;
    for k in 0..=1000 {
        let master = from + (to - from) * f64::from(k) / 1000.0;
        slave = gear.update(&moving(master, to - from)).position;
    }
    (slave, gear.phase())
}

#[test]
fn sample_1_both_return_to_their_start() {
    let mut gear = FlyingGear::enable(&SAMPLE_1, &moving(800.0, 0.0), 500.0).unwrap();
    assert_eq!(gear.start_position(), 560.0);
    // The manual's 2.0 · 50 mm before 460 mm.
    assert_eq!(travel(&mut gear, 800.0, 560.0), (500.0, Waiting));
    let (half_way, phase) = travel(&mut gear, 560.0, 510.0);
    // The quartic at its middle: 100·(1/8 − 1/32).
    assert_eq!((half_way, phase), (500.0 - 9.375, Engaging));
    assert_eq!(travel(&mut gear, 510.0, 460.0), (450.0, Engaged));
    assert_eq!(travel(&mut gear, 460.0, 300.0), (290.0, Engaged));
    assert_eq!(travel(&mut gear, 300.0, 459.0), (449.0, Engaged));
    let (half_way, phase) = travel(&mut gear, 459.0, 510.0);
    assert_eq!((half_way, phase), (500.0 - 9.375, Releasing));
    assert_eq!(travel(&mut gear, 510.0, 800.0), (500.0, Waiting));
    // The next stroke.
    assert_eq!(travel(&mut gear, 800.0, 460.0), (450.0, Engaged));
}

#[test]
fn sample_2_runs_in_opposite_directions() {
    let mut gear = FlyingGear::enable(&SAMPLE_2, &moving(800.0, 0.0), 400.0).unwrap();
    assert_eq!(gear.start_position(), 560.0);
    assert_eq!(travel(&mut gear, 800.0, 560.0), (400.0, Waiting));
    assert_eq!(travel(&mut gear, 560.0, 460.0), (450.0, Engaged));
    assert_eq!(travel(&mut gear, 460.0, 300.0), (610.0, Engaged));
    assert_eq!(travel(&mut gear, 300.0, 459.0), (451.0, Engaged));
    assert_eq!(travel(&mut gear, 459.0, 510.0), (400.0 + 9.375, Releasing));
    assert_eq!(travel(&mut gear, 510.0, 800.0), (400.0, Waiting));
}

#[test]
fn sample_3_stops_on_the_way_out_and_stays_there() {
    let mut gear = FlyingGear::enable(&SAMPLE_3, &moving(800.0, 0.0), 500.0).unwrap();
    assert_eq!(travel(&mut gear, 800.0, 461.0).1, Engaging);
    // The desync position is the sync position, so the release on the way out begins where engaging ends.
    assert_eq!(travel(&mut gear, 461.0, 460.0), (450.0, Releasing));
    assert_eq!(travel(&mut gear, 460.0, 260.0), (350.0, Released));
    assert_eq!(travel(&mut gear, 260.0, 800.0), (350.0, Released));
}

#[test]
fn sample_3_stopped_on_the_way_back_stays_before_its_start() {
    let parameters = FlyingGearParameters {
        slave_desync_position: 370.0,
        slave_stop_position: 470.0,
        ..SAMPLE_1
    };
    let mut gear = FlyingGear::enable(&parameters, &moving(800.0, 0.0), 500.0).unwrap();
    assert_eq!(travel(&mut gear, 800.0, 300.0), (290.0, Engaged));
    assert_eq!(travel(&mut gear, 300.0, 379.0), (369.0, Engaged));
    assert_eq!(travel(&mut gear, 379.0, 579.0).1, Releasing);
    // The slave at 370 has its master at 380, and 100 back take 200 of the master.
    assert_eq!(travel(&mut gear, 579.0, 580.0), (470.0, Released));
    assert_eq!(travel(&mut gear, 580.0, 800.0), (470.0, Released));
}

#[test]
fn a_master_that_turns_round_early_takes_the_slave_back() {
    let mut gear = FlyingGear::enable(&SAMPLE_1, &moving(800.0, 0.0), 500.0).unwrap();
    assert_eq!(travel(&mut gear, 800.0, 480.0).1, Engaging);
    assert_eq!(travel(&mut gear, 480.0, 600.0), (500.0, Waiting));
}

#[test]
fn a_slave_at_its_sync_position_is_told_its_direction() {
    for (negative, way) in [(true, -1.0), (false, 1.0)] {
        let parameters = FlyingGearParameters {
            slave_sync_position: 500.0,
            slave_desync_position: 500.0 + way * 10.0,
            slave_stop_position: 500.0 + way * 60.0,
            default_slave_negative: negative,
            ..SAMPLE_1
        };
        let master = moving(460.0 - way * 5.0, 0.0);
        let mut gear = FlyingGear::enable(&parameters, &master, 500.0).unwrap();
        assert_eq!(gear.start_position(), 460.0);
        // A window of no length, and a slave coupled from its begin: 5 of the master are 5 of the slave.
        let there = 460.0 + way * 5.0;
        assert_eq!(
            travel(&mut gear, master.position, there),
            (500.0 + way * 5.0, Engaged)
        );
    }
}

#[test]
fn a_master_past_the_start_point_is_refused() {
    let refused = FlyingGear::enable(&SAMPLE_1, &moving(559.0, 0.0), 500.0).unwrap_err();
    assert_eq!(refused.code(), 0x421a);
    assert_eq!(
        refused.to_string(),
        "0x421a: master position: received 559, expected one not past 560, where the gear begins to be engaged"
    );
    assert!(FlyingGear::enable(&SAMPLE_1, &moving(f64::NAN, 0.0), 500.0).is_err());
}

#[test]
fn parameters_that_make_no_gear_are_named() {
    let wrong: [(FlyingGearParameters, u32, &str); 5] = [
        (
            FlyingGearParameters {
                ratio: 0.0,
                ..SAMPLE_1
            },
            0x421b,
            "ratio",
        ),
        (
            FlyingGearParameters {
                ratio: f64::NAN,
                ..SAMPLE_1
            },
            0x421b,
            "ratio",
        ),
        (
            FlyingGearParameters {
                slave_sync_position: f64::INFINITY,
                ..SAMPLE_1
            },
            0x425b,
            "slave-sync-position",
        ),
        (
            FlyingGearParameters {
                slave_stop_position: 450.0,
                ..SAMPLE_1
            },
            0x425b,
            "slave-stop-position",
        ),
        (
            FlyingGearParameters {
                slave_desync_position: 480.0,
                slave_stop_position: 400.0,
                ..SAMPLE_1
            },
            0x425b,
            "slave-desync-position",
        ),
    ];
    for (parameters, code, name) in wrong {
        let refused = FlyingGear::enable(&parameters, &moving(800.0, 0.0), 500.0).unwrap_err();
        assert_eq!(refused.code(), code);
        assert!(refused.to_string().contains(name), "{refused}");
    }
}

/// A gear that is released on the way back or out, with its start of the master and of the slave.
fn gears() -> impl Strategy<Value = (FlyingGearParameters, f64, f64)> {
    let sign = || prop_oneof![Just(-1.0), Just(1.0)];
    let way = || 1.0..500.0;
    let ratio = (0.1..10.0, sign()).prop_map(|(ratio, sign): (f64, f64)| ratio * sign);
    let out = (way(), sign()).prop_map(|(way, sign): (f64, f64)| way * sign);
    (
        (ratio, sign()),
        (-1e3..1e3, -1e3..1e3),
        (way(), way(), out, way()),
    )
        .prop_map(|((ratio, direction), (master, slave), ways)| {
            gear_of(ratio, direction, master, slave, ways)
        })
}

/// Makes the gear of a slave with working direction `direction`, by its distances: in, to the desync
/// position, out (negative: on the way back), and the master's before it begins.
fn gear_of(
    ratio: f64,
    direction: f64,
    master_sync: f64,
    slave_sync: f64,
    (way_in, beyond, way_out, before): (f64, f64, f64, f64),
) -> (FlyingGearParameters, f64, f64) {
    let desync = slave_sync + direction * beyond;
    let parameters = FlyingGearParameters {
        ratio,
        master_sync_position: master_sync,
        slave_sync_position: slave_sync,
        slave_desync_position: desync,
        slave_stop_position: desync + direction * way_out,
        default_slave_negative: false,
    };
    let ahead = 2.0 * way_in / ratio.abs() + before;
    let master_start = master_sync - direction * ratio.signum() * ahead;
    (parameters, master_start, slave_sync - direction * way_in)
}

proptest! {
    /// On any path of the master, the slave's position is continuous in the master's and never steeper
    /// than the ratio; its velocity is the slope times the master's.
    #[test]
    fn the_slave_is_never_faster_than_the_rigid_gear(
        (parameters, master_start, slave_start) in gears(),
        turns in proptest::collection::vec(-1500.0..1500.0, 1..6),
    ) {
        let start = moving(master_start, 0.0);
        let mut gear = FlyingGear::enable(&parameters, &start, slave_start).unwrap();
        let (mut master, mut slave) = (master_start, slave_start);
        for turn in turns {
            let goal = parameters.master_sync_position + turn;
            let step = (goal - master) / 400.0;
            for _ in 0..400 {
                master += step;
                let next = gear.update(&moving(master, step));
                let moved = (next.position - slave).abs();
                let most = step.abs() * parameters.ratio.abs();
                // Positions up to some 1e4 have 2e-12 of rounding in each difference.
                prop_assert!(moved <= most + 1e-9, "{moved} {most} {:?}", gear.phase());
                prop_assert!(next.velocity.abs() <= most * (1.0 + 1e-12));
                slave = next.position;
            }
        }
    }

    /// Engaging as the ramp in flying-saw.md: velocity and acceleration are the derivatives of the
    /// position, with the peak acceleration 1.5·ratio·V²/L.
    #[test]
    fn the_ramp_is_the_derivative_of_its_position(
        (parameters, master_start, slave_start) in gears(),
        x in 0.01..0.99,
    ) {
        let start = moving(master_start, 0.0);
        let gear = FlyingGear::enable(&parameters, &start, slave_start).unwrap();
        let from = gear.start_position();
        let length = parameters.master_sync_position - from;
        let at = |x: f64| gear.clone().update(&moving(from + x * length, length));
        // Central differences err by h²/6 of the third derivative: 12 times the distance
        // for the position, 24 times for the velocity. Both are below 1e-7 of it.
        let h = 1e-4;
        let (before, here, after) = (at(x - h), at(x), at(x + h));
        let way = (parameters.slave_sync_position - slave_start).abs();
        let slope = (after.position - before.position) / (2.0 * h);
        prop_assert!((slope - here.velocity).abs() <= 1e-6 * way);
        let bend = (after.velocity - before.velocity) / (2.0 * h);
        prop_assert!((bend - here.acceleration).abs() <= 1e-5 * way);
        let peak = at(0.5).acceleration.abs();
        // The master runs at V = L here, and slope · L is twice
        // the distance: 1.5·slope·V²/L = 1.5 · 2 · distance.
        prop_assert!((peak / (1.5 * 2.0 * way) - 1.0).abs() < 1e-9);
    }
}

/// The manual's distances of 50 take 100 of the master, and the predicted values are those of the gear.
#[test]
fn stretches_are_known_before_they_are_driven() {
    for (sample, start, stop, returns) in [
        (SAMPLE_1, 500.0, 500.0, true),
        (SAMPLE_2, 400.0, 400.0, true),
        (SAMPLE_3, 500.0, 350.0, false),
    ] {
        let mut gear = FlyingGear::enable(&sample, &moving(800.0, -200.0), start).unwrap();
        let [engaging, releasing] = gear.ranges(-200.0, 1e-3);
        assert_eq!((gear.master_direction(), gear.returns()), (-1.0, returns));
        assert_eq!(
            (engaging.master_free, engaging.master_coupled),
            (560.0, 460.0)
        );
        assert_eq!(
            (engaging.slave_free, engaging.slave_coupled),
            (start, 450.0)
        );
        assert_eq!(
            (releasing.slave_free, releasing.slave_coupled),
            (stop, 450.0)
        );
        let mut most: f64 = 0.0;
        for k in 0..=1000 {
            let master = 560.0 - f64::from(k) * 0.1;
            most = most.max(gear.update(&moving(master, -200.0)).acceleration.abs());
        }
        assert!(
            (most - engaging.acceleration).abs() < 1e-9 * most,
            "{most} {engaging:?}"
        );
        assert_eq!(
            (engaging.velocity, engaging.jerk),
            // 6·slope·V³/L² with V = 200 and L = 100: V²/L² is 4.
            (200.0, 6.0 * 200.0 * 4.0)
        );
    }
}

#[test]
fn the_fastest_master_is_the_fastest_that_passes() {
    let gear = FlyingGear::enable(&SAMPLE_3, &moving(800.0, 0.0), 500.0).unwrap();
    let limits = Limits::new(300.0, 1000.0, 900.0, 1e5).unwrap();
    let fastest = gear.fastest(&limits, 1e-3);
    assert!(gear.check_limits(&limits, -fastest, 1e-3).is_ok());
    let refused = gear
        .check_limits(&limits, fastest * 1.01, 1e-3)
        .unwrap_err();
    assert_eq!(refused.code(), 0x42dd);
}
