//! The peaks of plates ahead of the master.

use super::*;
use coaxle_curve::law::MotionLaw;
use coaxle_plate::{Interpolation, PointType, PositionTable};

const SLAVE: CamLimits = limits(60_000.0, 60_000.0);

const fn limits(acceleration: f64, deceleration: f64) -> CamLimits {
    CamLimits {
        velocity: 2_000.0,
        acceleration,
        deceleration,
        jerk: 1e7,
        cycle: 0.001,
    }
}

/// Plans a coupling of a slave that rests at 0.
fn plan(
    limits: CamLimits,
    cam_in: CamIn,
    tables: &Tables,
    position: f64,
    velocity: f64,
) -> Result<(), CouplingError> {
    let parameters = CouplingParameters {
        master_axis_id: 7,
        slave_axis_id: 8,
        limits,
    };
    let coupling = CamCoupling::new(parameters).expect("parameters");
    let master = Kinematics {
        position,
        velocity,
        acceleration: 0.0,
    };
    let planned = coupling.plan(tables, &cam_in.into(), &master, &Kinematics::at_rest(0.0));
    planned.map(|_| ())
}

/// Couples plate 30 at its next cycle.
fn next_cycle() -> CamIn {
    CamIn {
        activation: Activation::new(ActivationMode::NextCycle),
        ..cam_in(30)
    }
}

/// Couples plate 30 far ahead of a master.
fn later(velocity: f64) -> CamIn {
    CamIn {
        activation: Activation::at(ActivationMode::AtMasterAxisPos, 1e6 * velocity),
        ..cam_in(30)
    }
}

/// Returns a store with plate 30.
fn tables_with(plate: Plate) -> Tables {
    let mut tables = Tables::new(1);
    tables.insert(30, plate).expect("room");
    tables
}

/// Quintic of 40 u over 1.2 u of the master, as narrow as three of 360 degrees.
const NARROW_PEAK: [(f64, f64); 4] = [(102.3, 0.0), (103.5, 40.0), (200.0, 40.0), (360.0, 0.0)];

/// Returns the narrow peak after this number of rests from 0 on, as far apart as `step`.
fn after_rests(count: u32, step: f64) -> Vec<(f64, f64)> {
    let rests = (0..count).map(|row| (f64::from(row) * step, 0.0));
    rests.chain(NARROW_PEAK).collect()
}

/// `narrow-peak`: a plate ten times too fast for its slave was accepted or refused depending on the
/// millisecond.
#[test]
fn a_narrow_peak_is_seen_wherever_the_master_is() {
    let tables = tables_with(plate(&after_rests(1, 0.0), Course::Cyclic));
    // Of the quintic, 5.7735 · 40 / 1.2² u/u²: more than 60 000 u/s² from 19.3 u/s of the master on.
    for (velocity, passes) in [(19.0, true), (19.7, false), (320.0, false), (-19.7, false)] {
        for place in 0..300 {
            // No divisor of the distance of the places, 360/128: each start looks at other ones.
            let position = 0.377 * f64::from(place);
            match plan(SLAVE, next_cycle(), &tables, position, velocity) {
                Ok(()) => assert!(passes, "{velocity} at {position}"),
                Err(CouplingError::BeyondLimits { .. }) => assert!(!passes, "{velocity}"),
                Err(other) => panic!("{velocity}: {other}"),
            }
        }
    }
}

/// Only the ends of segments were once searched in plates of more than 256.
#[test]
fn a_narrow_peak_is_seen_in_a_plate_of_any_length() {
    for (count, step) in [(252, 0.3), (299, 0.3), (4_092, 0.025)] {
        let tables = tables_with(plate(&after_rests(count, step), Course::Cyclic));
        for (velocity, passes) in [(19.0, true), (19.7, false), (-21.0, false), (21.0, false)] {
            for place in 0..300 {
                let position = 0.377 * f64::from(place);
                let planned = plan(SLAVE, next_cycle(), &tables, position, velocity);
                let is_refused = matches!(planned, Err(CouplingError::BeyondLimits { .. }));
                assert_eq!(is_refused, !passes, "{count}, {velocity}: {planned:?}");
                assert_eq!(planned.is_ok(), passes, "{planned:?}");
            }
        }
    }
}

/// A cubic is curved most at its ends. Beside masters of 13 km, a place a thousand-millionth of a millimetre inside was on the other
/// side of the joint: the slave got three times its acceleration.
#[test]
fn a_peak_at_a_joint_far_from_zero_is_seen() {
    let points = [
        rest(1, -12_857.0, 0.0),
        MotionPoint {
            function: MotionLaw::Polynom3,
            ..rest(2, 0.0, 0.015)
        },
        rest(3, 0.001, 0.0),
    ];
    let function = MotionFunction::new(points.to_vec()).expect("a motion function");
    let tables = tables_with(Plate::from_function(function, Course::Cyclic));
    // 6 · 0.015 / 0.001² u/u² where the slave speeds up, and where it brakes.
    let limits = limits(80_000.0, 800_000.0);
    // Scaled, a place is rounded twice more on its way to the plate.
    let cam_in = CamIn {
        master_scaling: -1.3,
        ..next_cycle()
    };
    for (velocity, passes) in [(0.94, true), (0.945, false), (-0.94, true), (-0.945, false)] {
        for place in 0..300 {
            let position = 1_000.7 * f64::from(place);
            let planned = plan(limits, cam_in, &tables, position, 1.3 * velocity);
            assert_eq!(
                planned.is_ok(),
                passes,
                "{position}, {velocity}: {planned:?}"
            );
        }
    }
}

/// A slave that is over its top brakes hardest just before it: rounding determined whether the place of the top counted as braking.
#[test]
fn a_slave_that_brakes_into_a_reversal_is_seen() {
    for shift in 0..200 {
        let shift = 0.377 * f64::from(shift);
        // The spline is over its top in the second row already, where it is curved most.
        let rows = [(0.0, 0.0), (2.0, 1.0), (3.0, 0.3), (5.0, 0.0)];
        let rows = rows.map(|(master, slave)| (shift + master, slave));
        let table = PositionTable::new(&rows, Interpolation::Spline, Course::Cyclic);
        let table = Plate::from_table(table.expect("a table"));
        let top = root(
            |master| table.at(master).velocity,
            rows[0].0 + 1.0,
            rows[1].0,
        );
        let curvature = table.at(top).acceleration.abs();
        let tables = tables_with(table);
        for (part, passes) in [(0.999, true), (1.001, false)] {
            // Forwards it brakes before the top.
            let limits = limits(1e9, 1e4);
            let velocity = part * (limits.deceleration / curvature).sqrt();
            let planned = plan(limits, next_cycle(), &tables, shift + 1.7, velocity);
            assert_eq!(planned.is_ok(), passes, "{shift}: {planned:?}");
        }
    }
}

/// Returns where a function that falls is 0.
fn root(falls: impl Fn(f64) -> f64, mut from: f64, mut to: f64) -> f64 {
    for _ in 0..100 {
        let middle = 0.5 * (from + to);
        if falls(middle) > 0.0 {
            from = middle;
        } else {
            to = middle;
        }
    }
    from
}

/// Cubics of a table are steepest inside, too.
#[test]
fn a_steep_place_between_two_rows_of_a_long_table_is_seen() {
    let rows = after_rests(299, 0.3);
    for kind in [Interpolation::Spline, Interpolation::SlidingSpline] {
        let table = PositionTable::new(&rows, kind, Course::Cyclic).expect("a table");
        let table = Plate::from_table(table);
        let velocity = table
            .characteristics(1.0)
            .expect("figures")
            .extremes
            .velocity;
        let steepest = velocity.maximum.value.max(-velocity.minimum.value);
        // Of the cubic over 1.2 u, the ends are less steep by a third.
        let tables = tables_with(table);
        for place in 0..300 {
            for (part, passes) in [(0.999, true), (1.001, false)] {
                let velocity = part * 2_000.0 / steepest;
                let position = 0.377 * f64::from(place);
                let planned = plan(limits(1e9, 1e9), next_cycle(), &tables, position, velocity);
                assert_eq!(planned.is_ok(), passes, "{kind:?}: {planned:?}");
            }
        }
    }
}

/// A linear plate is passed once: what lies behind the master does not count, however long the plate.
#[test]
fn a_narrow_peak_behind_the_master_of_a_linear_plate_does_not_count() {
    let tables = tables_with(plate(&after_rests(299, 0.3), Course::Linear));
    for (position, velocity, passes) in [
        (100.0, 21.0, false),
        (110.0, 21.0, true),
        (110.0, -21.0, false),
        (100.0, -21.0, true),
    ] {
        let planned = plan(SLAVE, later(velocity), &tables, position, velocity);
        assert_eq!(
            planned.is_ok(),
            passes,
            "{position}, {velocity}: {planned:?}"
        );
    }
}

/// A plate whose slave only brakes for a master that runs forwards on it: 2z - z²/2.
#[test]
fn what_brakes_the_slave_has_the_limit_of_braking() {
    let moving = |index, master, slave, velocity| MotionPoint {
        function: MotionLaw::Polynom3Vv,
        point_type: PointType::Velocity,
        velocity,
        ..rest(index, master, slave)
    };
    let parabola = [moving(1, 0.0, 0.0, 2.0), moving(2, 1.0, 1.5, 1.0)];
    let function = MotionFunction::new(parabola.to_vec()).expect("a motion function");
    let tables = tables_with(Plate::from_function(function, Course::Linear));
    // 10² u/s².
    for (acceleration, deceleration) in [(75.0, 125.0), (125.0, 75.0)] {
        for (velocity, master_scaling) in [(10.0, 1.0), (-10.0, 1.0), (10.0, -1.0), (-10.0, -1.0)] {
            let placed = CamIn {
                master_scaling,
                ..later(velocity)
            };
            let limits = limits(acceleration, deceleration);
            let planned = plan(limits, placed, &tables, -0.5 * velocity, velocity);
            let brakes = velocity * master_scaling > 0.0;
            let limit = if brakes { deceleration } else { acceleration };
            assert_eq!(
                planned.is_ok(),
                limit > 100.0,
                "{limits:?}, {velocity}, {master_scaling}: {planned:?}"
            );
        }
    }
}

/// Two plates with peaks that only together are too great, in the same narrow place.
#[test]
fn the_peaks_of_several_plates_add_up() {
    let points = [(0.0, 0.0), (102.3, 0.0), (103.5, 10.0), (360.0, 0.0)];
    let mut rig = Rig::new();
    for id in [30, 31] {
        rig.tables
            .insert(id, plate(&points, Course::Cyclic))
            .expect("room");
    }
    rig.coupling = CamCoupling::new(CouplingParameters {
        master_axis_id: 7,
        slave_axis_id: 8,
        limits: CamLimits { jerk: 1e9, ..SLAVE },
    })
    .expect("parameters");
    rig.go(-0.03);
    let add = |table, velocity: f64, rig: &mut Rig| {
        rig.master.velocity = velocity;
        let request = CamRequest::from(CamInV2 {
            table,
            ..CamInV2::default()
        });
        rig.start(request)
    };
    // 40.1 · v² for one of them, 60 000 u/s² for both at 27.4 u/s.
    add(30, 30.0, &mut rig).expect("one is slow enough");
    rig.go(0.0);
    rig.master.velocity = 30.0;
    let second = CamRequest::from(CamAdd {
        table: 31,
        ..CamAdd::default()
    });
    let refused = rig.start(second).expect_err("both are not");
    assert!(
        matches!(refused, CouplingError::BeyondLimits { .. }),
        "{refused}"
    );
}
