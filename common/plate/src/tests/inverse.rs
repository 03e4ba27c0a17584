//! From the slave back to the master.

use std::vec::Vec;

use proptest::prelude::*;

use super::plates::{any_plate, plate, rest};
use crate::{Course, MasterQuery, MotionPoint, Plate};
use coaxle_curve::law::MotionLaw;

/// Returns the greatest error of a position by rounding of the master and of the lifts.
fn tolerance(plate: &Plate, master: f64) -> f64 {
    let extremes = plate.characteristics(1.0).unwrap().extremes;
    let (start, end) = plate.master_range();
    let largest = master.abs().max(start.abs()).max(end.abs());
    1e-12 * extremes.position.magnitude()
        + 64.0 * f64::EPSILON * extremes.velocity.magnitude() * largest
        + 1e-14 * (plate.turn(master).abs() + 1.0) * plate.lift().abs()
}

proptest! {
    #[test]
    fn a_master_is_found_by_its_slave(plate in any_plate(), share in 0.0..1.0_f64) {
        let (start, end) = plate.master_range();
        let master = start + share * (end - start);
        let slave = plate.at(master).position;
        let found: Vec<f64> = plate.masters_at(slave).collect();
        prop_assert!(found.is_sorted());
        for &m in &found {
            prop_assert!((plate.at(m).position - slave).abs() <= tolerance(&plate, m));
        }
        let velocity = plate.at(master).velocity.abs();
        let most = plate.characteristics(1.0).unwrap().extremes.velocity.magnitude();
        // Near an extreme a position determines the master only roughly.
        if velocity > 1e-3 * most {
            let near = 1e-9 * (end - start);
            prop_assert!(found.iter().any(|m| (m - master).abs() <= near), "{master} {found:?}");
        }
    }

    #[test]
    fn neighbours_are_the_nearest_of_all(
        plate in any_plate(),
        share in -3.0..4.0_f64,
        slave_share in -2.0..3.0_f64,
    ) {
        let (start, end) = plate.master_range();
        let from = start + share * (end - start);
        let slave = plate.at(start + slave_share * (end - start)).position;
        let all: Vec<f64> = (-300..300)
            .map(f64::from)
            .filter(|&turn| turn == 0.0 || plate.course() == Course::Cyclic)
            .flat_map(|turn| {
                let masters: Vec<f64> = plate.masters_at(slave - turn * plate.lift()).collect();
                masters.into_iter().map(move |m| m + turn * (end - start))
            })
            .collect();
        // Near an extreme of the slave, a rounding of 1e-12 shifts the master by its square root, 1e-6.
        let near = 1e-6 * (end - start);
        let below = plate.master_below(slave, from, 0.0);
        let above = plate.master_above(slave, from, 0.0);
        let rests = below == Some(from) && above == Some(from);
        prop_assume!(!rests);
        // Far away masters are beyond the list.
        let listed = |m: &f64| (m - from).abs() < 250.0 * (end - start);
        let same = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => (a - b).abs() <= near,
            (None, None) => true,
            _ => false,
        };
        let expected = all.iter().copied().filter(|&m| m <= from).max_by(f64::total_cmp);
        prop_assert!(same(below.filter(listed), expected.filter(listed)), "{below:?} {expected:?}");
        let expected = all.iter().copied().filter(|&m| m >= from).min_by(f64::total_cmp);
        prop_assert!(same(above.filter(listed), expected.filter(listed)), "{above:?} {expected:?}");
        for m in [below, above].into_iter().flatten() {
            let received = plate.at(m).position;
            prop_assert!((received - slave).abs() <= tolerance(&plate, m), "{received} {slave}");
        }
    }
}

/// Makes a plate straight up to 106⅔ at 180 and down again, so that 80 is passed at 135 and 225.
fn gable(course: Course) -> Plate {
    let straight = |index, master, slave| MotionPoint {
        function: MotionLaw::Polynom1,
        ..rest(index, master, slave)
    };
    // TF5050 7.5 names 225 and 135 for a slave of 80 from a master of 180, and -135 below 90 if cyclic.
    let top = 80.0 * 180.0 / 135.0;
    plate(
        &[
            straight(1, 0.0, 0.0),
            straight(2, 180.0, top),
            straight(3, 360.0, 0.0),
        ],
        course,
    )
}

fn assert_at(received: Option<f64>, expected: f64) {
    let received = received.expect("there is one");
    assert!((received - expected).abs() < 1e-9, "{received} {expected}");
}

#[test]
fn the_manuals_example() {
    let cyclic = gable(Course::Cyclic);
    assert_at(cyclic.master_above(80.0, 180.0, 0.0), 225.0);
    assert_at(cyclic.master_below(80.0, 180.0, 0.0), 135.0);
    assert_at(cyclic.master_above(80.0, 90.0, 0.0), 135.0);
    assert_at(cyclic.master_below(80.0, 90.0, 0.0), -135.0);

    let linear = gable(Course::Linear);
    assert_at(linear.master_above(80.0, 90.0, 0.0), 135.0);
    assert_eq!(linear.master_below(80.0, 90.0, 0.0), None);
    assert_eq!(linear.master_above(107.0, 0.0, 0.0), None);
}

#[test]
fn what_is_accurate_enough_counts_on_both_sides() {
    let plate = gable(Course::Cyclic);
    let start = 135.01;
    assert_at(plate.master_above(80.0, start, 0.0), 225.0);
    assert_at(plate.master_above(80.0, start, 0.1), 135.0);
    assert_at(plate.master_below(80.0, 134.99, 0.1), 135.0);
    // Across the edge of a turn too.
    assert_at(
        plate.master_above(1e-3 * 80.0, 360.0 - 0.01, 0.05),
        360.0 + 0.135,
    );
    assert_at(
        plate.master_above(1e-3 * 80.0, 360.0 + 0.2, 0.5),
        360.0 - 0.135,
    );
}

#[test]
fn with_lift_the_master_may_be_many_turns_away() {
    for lift in [50.0, -50.0] {
        let plate = plate(&[rest(1, 0.0, 0.0), rest(2, 100.0, lift)], Course::Cyclic);
        // A quintic between rests is symmetric, so half a lift is at half a period.
        let slave = 1_000_000.5 * lift;
        let expected = 100.0 * 1_000_000.5;
        assert_at(plate.master_above(slave, 0.0, 0.0), expected);
        assert_eq!(plate.master_below(slave, 0.0, 0.0), None);
        assert_at(plate.master_below(-slave, 0.0, 0.0), -expected);
        // Where one turn ends and the next begins.
        assert_at(plate.master_above(3.0 * lift, 0.0, 0.0), 300.0);
        assert_at(plate.master_below(3.0 * lift, 1e6, 0.0), 300.0);
    }
}

#[test]
fn while_the_slave_rests_the_start_is_its_own_neighbour() {
    let points = [
        rest(1, 0.0, 0.0),
        rest(2, 10.0, 5.0),
        rest(3, 20.0, 5.0),
        rest(4, 30.0, 0.0),
    ];
    let plate = plate(&points, Course::Cyclic);
    assert_eq!(plate.master_above(5.0, 13.0, 0.0), Some(13.0));
    assert_eq!(plate.master_below(5.0, 17.0, 0.0), Some(17.0));
    assert_eq!(plate.masters_at(5.0).collect::<Vec<_>>(), [10.0, 20.0]);
    // The end of a cyclic plate is the begin of the next cycle.
    assert_eq!(plate.masters_at(0.0).collect::<Vec<_>>(), [0.0]);
    let linear = super::plates::plate(&points, Course::Linear);
    assert_eq!(linear.masters_at(0.0).collect::<Vec<_>>(), [0.0, 30.0]);
}

#[test]
fn a_coupling_is_asked_in_axis_positions() {
    let plate = plate(&[rest(1, 0.0, 0.0), rest(2, 100.0, 50.0)], Course::Cyclic);
    for (master_scaling, slave_scaling) in [(2.0, 3.0), (-2.0, 3.0), (0.5, -1.0)] {
        let query = MasterQuery {
            slave_position: 7.0 + slave_scaling * (125.0),
            master_offset: 13.0,
            slave_offset: 7.0,
            master_scaling,
            slave_scaling,
            master_start: 0.0,
            accuracy: 0.0,
        };
        let [low, high] = plate.master_positions(&query).unwrap();
        // Two and a half turns on: the lift of two turns is what a coupling there must add.
        let expected = 250.0 * master_scaling - 13.0;
        let (found, none) = if expected < 0.0 {
            (low, high)
        } else {
            (high, low)
        };
        let found = found.unwrap();
        assert!((found.axis - expected).abs() < 1e-9);
        assert!((found.cam - 50.0).abs() < 1e-9);
        assert_eq!(found.slave_offset, 7.0 + 100.0 * slave_scaling);
        assert_eq!(none, None);
        let there = (found.axis + query.master_offset) / master_scaling;
        let slave = plate.at(there).position * slave_scaling + query.slave_offset;
        assert!((slave - query.slave_position).abs() < 1e-9);
    }
}
