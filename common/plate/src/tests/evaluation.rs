//! Position and derivatives anywhere, at random and along a path.

use std::vec::Vec;

use proptest::collection::vec;
use proptest::prelude::*;

use super::plates::{any_plate, knots, motion, plate, plate_of, rest};
use crate::{Course, Cursor, MotionPoint, PointType, slave_of};
use coaxle_curve::law::{Motion, MotionLaw};
use coaxle_curve::profile::Kinematics;

fn bits(motion: Motion) -> [u64; 4] {
    [
        motion.position,
        motion.velocity,
        motion.acceleration,
        motion.jerk,
    ]
    .map(f64::to_bits)
}

proptest! {
    #[test]
    fn positions_join_at_every_point(plate in any_plate()) {
        let extremes = plate.characteristics(1.0).unwrap().extremes;
        // The next double of the master moves the slave by slope·ulp, and an ulp is below 1e-12 periods here.
        let tolerance = 1e-12 * (extremes.position.magnitude()
            + extremes.velocity.magnitude() * plate.period());
        for knot in knots(&plate) {
            let [before, here, after] =
                [knot.next_down(), knot, knot.next_up()].map(|m| plate.at(m).position);
            // The last knot of a cyclic plate is the first one of the next turn.
            prop_assert!((before - here).abs() <= tolerance, "{before} {here} at {knot}");
            prop_assert!((after - here).abs() <= tolerance, "{here} {after} at {knot}");
        }
    }

    #[test]
    fn a_turn_later_the_slave_is_a_lift_further(
        plate in plate_of(Course::Cyclic),
        share in 0.01..0.99_f64,
        turns in -1_000..1_000_i32,
    ) {
        let (start, end) = plate.master_range();
        let here = start + share * (end - start);
        let turns = f64::from(turns);
        let there = here + turns * plate.period();
        let extremes = plate.characteristics(1.0).unwrap().extremes;
        // Rounding of the master times the slope, that of the lifts, and that of the law itself.
        let shift = 4.0 * f64::EPSILON * there.abs().max(start.abs()).max(end.abs());
        let tolerance = shift * extremes.velocity.magnitude()
            + 4.0 * f64::EPSILON * (turns.abs() + 1.0) * plate.lift().abs()
            + 1e-13 * extremes.position.magnitude();
        let expected = plate.at(here).position + turns * plate.lift();
        let received = plate.at(there).position;
        prop_assert!((received - expected).abs() <= tolerance, "{received} {expected}");
        prop_assert_eq!(plate.turn(there), turns);
    }

    #[test]
    fn each_derivative_is_the_slope_of_the_one_before(
        plate in any_plate(),
        segment in any::<prop::sample::Index>(),
        share in 0.0..1.0_f64,
    ) {
        let knots = knots(&plate);
        let segment = segment.index(knots.len() - 1);
        let length = knots[segment + 1] - knots[segment];
        // Central differences: the truncation falls with h², the rounding grows with 1/h.
        let step = 1e-4 * length;
        let here = knots[segment] + step + share * (length - 2.0 * step);
        let [before, at, after] = [here - step, here, here + step].map(|m| plate.at(m));
        let extremes = plate.characteristics(1.0).unwrap().extremes;
        let jerk = extremes.jerk.magnitude();
        let slack = |magnitude: f64| 1e-15 * 64.0 * magnitude / step;

        // Taylor: (s(x+h) - s(x-h))/2h = v + h²·j/6, with the greatest jerk as the bound.
        let velocity = (after.position - before.position) / (2.0 * step);
        let tolerance = step * step * jerk / 6.0 + slack(extremes.position.magnitude())
            + 1e-12 * extremes.velocity.magnitude();
        prop_assert!((velocity - at.velocity).abs() <= tolerance, "{velocity} {at:?}");

        // The jerk may turn within the interval, so only |Δa| ≤ h·j is sure.
        let acceleration = (after.velocity - before.velocity) / (2.0 * step);
        let tolerance = step * jerk + slack(extremes.velocity.magnitude())
            + 1e-12 * extremes.acceleration.magnitude();
        prop_assert!((acceleration - at.acceleration).abs() <= tolerance, "{acceleration} {at:?}");
    }

    #[test]
    fn along_a_path_it_is_the_same_to_the_last_bit(
        plate in any_plate(),
        shares in vec(-3.0..4.0_f64, 1..60),
        steps in vec(-0.02..0.02_f64, 1..60),
        (other, elsewhere) in (any_plate(), -1e6..1e6_f64),
    ) {
        let (start, end) = plate.master_range();
        let mut cursor = Cursor::default();
        // A cursor left by any other plate must be valid, too.
        let _ = other.along(&mut cursor, elsewhere);
        let mut share = 0.0;
        let path = steps.into_iter().map(|step| { share += step; share });
        let places = shares.into_iter().chain(path).map(|share| start + share * (end - start));
        let edges = knots(&plate).into_iter().flat_map(|m| [m.next_down(), m, m.next_up()]);
        let far = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e18, -1e300];
        for master in places.chain(edges).chain(far) {
            let (along, at) = (plate.along(&mut cursor, master), plate.at(master));
            prop_assert!(
                bits(along) == bits(at) || at.position.is_nan() && along.position.is_nan(),
                "{along:?} {at:?} at {master}"
            );
        }
    }

    #[test]
    fn at_its_points_the_slave_is_where_they_say(points in super::plates::points()) {
        let plate = plate(&points, Course::Linear);
        // Rounding is relative to the terms of the position's sum.
        let length = |pair: &[MotionPoint]| pair[1].master - pair[0].master;
        let longest = points.windows(2).map(length).fold(0.0, f64::max);
        let terms = |p: &MotionPoint| {
            let derivatives = [p.velocity, p.acceleration, p.jerk].map(f64::abs);
            let [velocity, acceleration, jerk] = derivatives;
            p.slave.abs() + longest * (velocity + longest * (acceleration + longest * jerk))
        };
        let size = points.iter().map(terms).fold(0.0, f64::max);
        for point in &points {
            let received = plate.at(point.master).position;
            prop_assert!((received - point.slave).abs() <= 1e-12 * size, "{received} {point:?}");
        }
    }
}

/// Makes segments from motion to motion, so that all derivatives are given; the last point repeats the
/// first.
fn running(lift: f64) -> [MotionPoint; 3] {
    let with = |index, master, slave, velocity, acceleration, jerk| MotionPoint {
        function: MotionLaw::Polynom7Mm,
        acceleration,
        jerk,
        ..motion(index, master, slave, velocity)
    };
    [
        with(1, 10.0, 5.0, 2.0, 0.5, -0.1),
        with(2, 35.0, -8.0, -1.0, 0.25, 0.2),
        with(3, 50.0, 5.0 + lift, 2.0, 0.5, -0.1),
    ]
}

#[test]
fn motion_goes_on_across_points_and_turns() {
    for lift in [0.0, 120.0, -7.5] {
        let plate = plate(&running(lift), Course::Cyclic);
        assert_eq!(plate.lift(), lift);
        for knot in [10.0, 35.0, 50.0] {
            for turn in [-3.0, -1.0, 0.0, 2.0] {
                let master: f64 = knot + turn * plate.period();
                let (a, b) = (plate.at(master - 1e-9), plate.at(master + 1e-9));
                assert!((a.position - b.position).abs() < 1e-8);
                assert!((a.velocity - b.velocity).abs() < 1e-8);
                assert!((a.acceleration - b.acceleration).abs() < 1e-8);
                assert!((a.jerk - b.jerk).abs() < 1e-7);
            }
        }
    }
}

#[test]
fn a_linear_plate_holds_at_its_edges() {
    let plate = plate(&running(3.0), Course::Linear);
    for (master, slave) in [
        (9.999, 5.0),
        (-1e9, 5.0),
        (50.001, 8.0),
        (f64::INFINITY, 8.0),
    ] {
        // Held at the edges: 5 at the start, 5 + lift at the end.
        let held = plate.at(master);
        assert!((held.position - slave).abs() < 1e-12);
        assert_eq!(
            (held.velocity, held.acceleration, held.jerk),
            (0.0, 0.0, 0.0)
        );
    }
    // At the edges themselves the slave still moves.
    assert!((plate.at(10.0).velocity - 2.0).abs() < 1e-12);
    assert!((plate.at(50.0).velocity - 2.0).abs() < 1e-12);
    assert_eq!(plate.turn(1e6), 0.0);
}

#[test]
fn a_lift_that_is_only_rounding_counts_as_none() {
    // 0.1 + 0.2 is 0.30000000000000004: as a lift it would have moved the slave by 5.6e-11 after a million turns.
    let points = [
        rest(1, 0.0, 0.3),
        rest(2, 1.0, 9.0),
        rest(3, 2.0, 0.1 + 0.2),
    ];
    let plate = plate(&points, Course::Cyclic);
    assert_eq!(plate.lift(), 0.0);
    assert_eq!(plate.at(2e6).position, 0.3);
}

#[test]
fn ignored_and_skipped_points_have_no_effect() {
    let skipping = |steps, point| MotionPoint {
        relative_next: steps,
        ..point
    };
    let ignored = |index| MotionPoint {
        point_type: PointType::Ignore,
        master: f64::NAN,
        ..rest(index, 0.0, 0.0)
    };
    let with = plate(
        &[
            skipping(3, rest(1, 0.0, 0.0)),
            ignored(2),
            rest(3, 5.0, -7.0),
            skipping(2, rest(4, 10.0, 1.0)),
            ignored(5),
            rest(6, 20.0, 0.0),
        ],
        Course::Cyclic,
    );
    let without = plate(
        &[rest(1, 0.0, 0.0), rest(2, 10.0, 1.0), rest(3, 20.0, 0.0)],
        Course::Cyclic,
    );
    for i in -50..=50 {
        let master = f64::from(i) * 0.77;
        assert_eq!(bits(with.at(master)), bits(without.at(master)));
    }
}

#[test]
fn an_acceleration_at_the_turn_places_the_inner_turning_point() {
    let turn = |acceleration| MotionPoint {
        point_type: PointType::Turn,
        function: MotionLaw::HarmonicKombiTr,
        acceleration,
        ..rest(2, 1.0, 1.0)
    };
    let start = MotionPoint {
        function: MotionLaw::HarmonicKombiRt,
        ..rest(1, 0.0, 0.0)
    };
    let up_and_down = |acceleration| {
        plate(
            &[start, turn(acceleration), rest(3, 3.0, 0.0)],
            Course::Linear,
        )
    };
    assert!((up_and_down(-5.0).at(1.0_f64.next_down()).acceleration + 5.0).abs() < 1e-9);
    assert!((up_and_down(-4.0).at(1.0).acceleration + 4.0).abs() < 1e-9);
    // By itself the law turns with π²/μ(πλ + 4μ) at λ = 2 - √2.
    let lambda = 2.0 - core::f64::consts::SQRT_2;
    let mu = 1.0 - lambda;
    let pi = core::f64::consts::PI;
    let own = pi * pi / (mu * (pi * lambda + 4.0 * mu));
    assert!((up_and_down(0.0).at(1.0_f64.next_down()).acceleration + own).abs() < 1e-9);
}

#[test]
fn a_moving_master_moves_the_slave_by_the_chain_rule() {
    let cam = Motion {
        position: 7.0,
        velocity: 2.0,
        acceleration: -3.0,
        jerk: 0.0,
    };
    let master = Kinematics {
        position: 1.0,
        velocity: -4.0,
        acceleration: 5.0,
    };
    let expected = Kinematics {
        position: 7.0,
        velocity: -8.0,
        acceleration: -3.0 * 16.0 + 2.0 * 5.0,
    };
    assert_eq!(slave_of(&cam, &master), expected);

    let plate = plate(&running(0.0), Course::Cyclic);
    let at: Vec<_> = [-12.0, 20.0, 77.0]
        .map(|position| Kinematics { position, ..master })
        .map(|master| {
            (
                plate.slave_dynamics(&master),
                slave_of(&plate.at(master.position), &master),
            )
        })
        .into();
    assert!(at.iter().all(|(received, expected)| received == expected));
}
