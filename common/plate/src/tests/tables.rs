//! Position tables and tables of values.

use std::vec::Vec;

use proptest::prelude::*;

use super::plates::{course, interpolation, plate, rest, rows};
use crate::{Course, Interpolation, Plate, PositionTable, ValueSelect};

fn table(rows: &[(f64, f64)], interpolation: Interpolation, course: Course) -> Plate {
    let table = PositionTable::new(rows, interpolation, course);
    Plate::from_table(table.expect("the rows are right"))
}

proptest! {
    #[test]
    fn rows_are_passed(rows in rows(), interpolation in interpolation(), course in course()) {
        let plate = table(&rows, interpolation, course);
        let extremes = plate.characteristics(1.0).unwrap().extremes;
        for &(master, slave) in &rows {
            let received = plate.at(master).position;
            let tolerance = 1e-12 * extremes.position.magnitude();
            prop_assert!((received - slave).abs() <= tolerance, "{received} {slave}");
        }
        if interpolation != Interpolation::Linear {
            let tolerance = 1e-11 * extremes.velocity.magnitude();
            for &(master, _) in &rows[1..rows.len() - 1] {
                let [before, after] = [master.next_down(), master].map(|m| plate.at(m).velocity);
                prop_assert!((before - after).abs() <= tolerance);
            }
        }
        if interpolation != Interpolation::Linear && course == Course::Cyclic {
            let (start, end) = plate.master_range();
            let velocities = [end.next_down(), start].map(|m| plate.at(m).velocity);
            let tolerance = 1e-11 * extremes.velocity.magnitude();
            prop_assert!((velocities[0] - velocities[1]).abs() <= tolerance);
        }
    }

    #[test]
    fn splines_follow_a_parabola(rows in rows(), a in -2.0..2.0_f64, b in -9.0..9.0_f64) {
        // Parabolas through three rows are the parabola itself, so all slopes are exact, and so is each cubic.
        let parabola = |m: f64| a * m * m + b * m + 3.0;
        let rows: Vec<_> = rows.iter().map(|&(m, _)| (m, parabola(m))).collect();
        for interpolation in [Interpolation::Spline, Interpolation::SlidingSpline] {
            let plate = table(&rows, interpolation, Course::Linear);
            let (start, end) = plate.master_range();
            let size = plate.slave_range().magnitude() + b.abs() * start.abs().max(end.abs());
            for i in 0..=100 {
                let master = start + (end - start) * f64::from(i) / 100.0;
                let received = plate.at(master).position;
                prop_assert!((received - parabola(master)).abs() <= 1e-11 * size);
            }
        }
    }

    #[test]
    fn equal_steps_change_nothing_but_the_way_to_search(
        slaves in prop::collection::vec(-100.0..100.0_f64, 4..40),
        (start, step) in (-100.0..100.0_f64, 0.1..10.0_f64),
        interpolation in interpolation(),
        course in course(),
        shares in prop::collection::vec(-0.5..1.5_f64, 30),
    ) {
        let rows: Vec<_> = slaves
            .iter()
            .enumerate()
            // As in a file with six decimal places.
            .map(|(i, &slave)| (libm::round((start + i as f64 * step) * 1e6) / 1e6, slave))
            .collect();
        let any = table(&rows, interpolation, course);
        let even = PositionTable::equidistant(&rows, interpolation, course).unwrap();
        let even = Plate::from_table(even);
        let (start, end) = any.master_range();
        let masters = rows.iter().flat_map(|r| [r.0.next_down(), r.0, r.0.next_up()]);
        let masters = masters.chain(shares.iter().map(|share| start + share * (end - start)));
        for master in masters {
            prop_assert_eq!(any.at(master), even.at(master));
        }
    }

    #[test]
    fn a_row_reaches_no_further_than_its_second_neighbours(
        rows in rows(),
        row in any::<prop::sample::Index>(),
    ) {
        let row = row.index(rows.len());
        let mut moved = rows.clone();
        moved[row].1 += 1.0;
        let [before, after] =
            [&rows, &moved].map(|rows| table(rows, Interpolation::SlidingSpline, Course::Linear));
        for (i, pair) in rows.windows(2).enumerate() {
            let middle = (pair[0].0 + pair[1].0) / 2.0;
            // The first and the last slope take two neighbours on their only side.
            if i + 3 < row || i > row + 2 {
                prop_assert_eq!(before.at(middle), after.at(middle));
            }
        }
    }
}

#[test]
fn the_interpolation_can_be_chosen_later() {
    let rows = [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (3.0, 2.0)];
    let linear = PositionTable::equidistant(&rows, Interpolation::Linear, Course::Cyclic).unwrap();
    let spline = linear.interpolated(Interpolation::Spline).unwrap();
    assert_eq!(spline.interpolation(), Interpolation::Spline);
    assert_eq!(spline.table_type(), linear.table_type());
    assert_eq!(spline.course(), Course::Cyclic);
    assert_eq!(spline.rows(), &rows[..]);
    for kind in Interpolation::ALL {
        assert_eq!(Interpolation::from_code(kind.code()), Some(kind));
    }
}

#[test]
fn values_are_listed_in_steps() {
    let plate = plate(&[rest(1, 0.0, 0.0), rest(2, 10.0, 5.0)], Course::Linear);
    let all = ValueSelect::all();
    let rows: Vec<_> = plate.values(0.0, 10.0, 0.1, all).unwrap().collect();
    // Fence posts of 100 increments.
    assert_eq!(rows.len(), 101);
    for (i, row) in rows.iter().enumerate() {
        let motion = plate.at(row[0]);
        assert!((row[0] - i as f64 * 0.1).abs() < 1e-12);
        let expected = [
            motion.position,
            motion.velocity,
            motion.acceleration,
            motion.jerk,
        ];
        assert_eq!(row[1..], expected);
    }
    // The end is met although tenths are not exact.
    assert_eq!(rows[100][0], 10.0);

    let some = ValueSelect::POSITION | ValueSelect::ACCELERATION;
    let rows: Vec<_> = plate.values(4.0, -1.0, -2.0, some).unwrap().collect();
    let masters: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    // -1 is half an increment beyond the last whole one.
    assert_eq!(masters, [4.0, 2.0, 0.0]);
    assert_eq!(rows[0].len(), 3);
    assert_eq!(rows[0][2], plate.at(4.0).acceleration);

    let one = plate.values(3.0, 3.0, 1.0, ValueSelect::JERK).unwrap();
    assert_eq!(one.count(), 1);
}

/// The tolerance at the end was less than the rounding of many rows, and of masters far out.
#[test]
fn the_last_row_is_the_end_however_many_rows_there_are() {
    for (from, to, increment, count) in [
        (0.0, 524_288.2_f64, 0.1, 5_242_883),
        (0.0, 999_999.7, 0.1, 9_999_998),
        (1e6, 1_000_000.3, 0.001, 301),
        (-1e6, -1_000_000.3, -0.001, 301),
        (1e9, 1_000_000_000.3, 0.1, 4),
        // An end between two rows is no row.
        (1e9, 1_000_000_000.35, 0.1, 4),
    ] {
        let plate = plate(&[rest(1, 0.0, 0.0), rest(2, to.abs(), 5.0)], Course::Linear);
        let rows = plate
            .values(from, to, increment, ValueSelect::POSITION)
            .unwrap();
        let (rows, last) = rows.fold((0, 0.0), |(rows, _), row| (rows + 1, row[0]));
        assert_eq!(rows, count, "{from} to {to}");
        let end = if to == 1_000_000_000.35 {
            from + 0.3
        } else {
            to
        };
        // Exactly the end: beyond it a linear plate stands.
        let off = if to == end { 0.0 } else { 1e-6 };
        assert!((last - end).abs() <= off, "{from} to {to}: {last}");
    }
}
