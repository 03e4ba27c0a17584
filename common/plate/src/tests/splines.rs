//! Splines against another method of computing them: second derivatives instead of slopes, and full
//! elimination with pivoting instead of three diagonals.

use std::vec;
use std::vec::Vec;

use proptest::prelude::*;

use super::plates::{motion, plate, rest, rows, spline_points};
use crate::{Course, Interpolation, MotionPoint, Plate, PositionTable};
use coaxle_curve::law::MotionLaw;

/// Condition at an end.
#[derive(Clone, Copy, Debug)]
enum End {
    Natural,
    Slope(f64),
}

/// Solves by Gauss's elimination with partial pivoting.
fn solved(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for column in 0..n {
        let pivot = (column..n)
            .max_by(|&i, &j| a[i][column].abs().total_cmp(&a[j][column].abs()))
            .expect("there are rows left");
        a.swap(column, pivot);
        b.swap(column, pivot);
        let (above, below) = a.split_at_mut(column + 1);
        let pivot_row = &above[column];
        for (row, offset) in below.iter_mut().zip(column + 1..) {
            let factor = row[column] / pivot_row[column];
            for (entry, pivot_entry) in row.iter_mut().zip(pivot_row) {
                *entry -= factor * pivot_entry;
            }
            b[offset] -= factor * b[column];
        }
    }
    let mut x = vec![0.0; n];
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|k| a[row][k] * x[k]).sum();
        x[row] = (b[row] - known) / a[row][row];
    }
    x
}

/// Returns the second derivatives at the knots; `None` for a periodic spline.
fn moments(knots: &[(f64, f64)], ends: Option<[End; 2]>) -> Vec<f64> {
    let n = knots.len();
    let h = |i: usize| knots[i + 1].0 - knots[i].0;
    let d = |i: usize| (knots[i + 1].1 - knots[i].1) / h(i);
    let mut a = vec![vec![0.0; n]; n];
    let mut b = vec![0.0; n];
    // Continuity of the slope: h₀M₀/6 + (h₀ + h₁)M₁/3 + h₁M₂/6 = d₁ - d₀, with the secants d.
    for i in 1..n - 1 {
        a[i][i - 1] = h(i - 1) / 6.0;
        a[i][i] = (h(i - 1) + h(i)) / 3.0;
        a[i][i + 1] = h(i) / 6.0;
        b[i] = d(i) - d(i - 1);
    }
    let last = n - 1;
    match ends {
        Some([start, end]) => {
            match start {
                End::Natural => a[0][0] = 1.0,
                // Slope of the first piece at its start: d - h(2M₀ + M₁)/6.
                End::Slope(slope) => {
                    (a[0][0], a[0][1], b[0]) = (h(0) / 3.0, h(0) / 6.0, d(0) - slope);
                }
            }
            match end {
                End::Natural => a[last][last] = 1.0,
                End::Slope(slope) => {
                    let h = h(last - 1);
                    (a[last][last], a[last][last - 1]) = (h / 3.0, h / 6.0);
                    b[last] = slope - d(last - 1);
                }
            }
        }
        None => {
            // Curvature and slope are equal at both ends.
            (a[0][0], a[0][last]) = (1.0, -1.0);
            let (first, second) = (h(0), h(last - 1));
            a[last][0] += first / 3.0;
            a[last][1] += first / 6.0;
            a[last][last - 1] += second / 6.0;
            a[last][last] += second / 3.0;
            b[last] = d(0) - d(last - 1);
        }
    }
    solved(a, b)
}

fn spline_at(knots: &[(f64, f64)], moments: &[f64], master: f64) -> [f64; 3] {
    let i = (1..knots.len() - 1)
        .filter(|&i| knots[i].0 <= master)
        .max()
        .unwrap_or(0);
    let (x0, x1) = (knots[i].0, knots[i + 1].0);
    let h = x1 - x0;
    let (l, r) = (x1 - master, master - x0);
    let (m0, m1) = (moments[i], moments[i + 1]);
    let (c0, c1) = (
        knots[i].1 / h - m0 * h / 6.0,
        knots[i + 1].1 / h - m1 * h / 6.0,
    );
    [
        (m0 * l * l * l + m1 * r * r * r) / (6.0 * h) + c0 * l + c1 * r,
        (m1 * r * r - m0 * l * l) / (2.0 * h) - c0 + c1,
        (m0 * l + m1 * r) / h,
    ]
}

fn assert_same_spline(plate: &Plate, knots: &[(f64, f64)], ends: Option<[End; 2]>) {
    let moments = moments(knots, ends);
    let extremes = plate.characteristics(1.0).unwrap().extremes;
    let (start, end) = plate.master_range();
    for i in 0..200 {
        let master = start + (end - start) * f64::from(i) / 200.0;
        let expected = spline_at(knots, &moments, master);
        let received = plate.at(master);
        let received = [received.position, received.velocity, received.acceleration];
        let sizes = [
            extremes.position.magnitude(),
            extremes.velocity.magnitude(),
            extremes.acceleration.magnitude(),
        ];
        // Relative to the largest value of each derivative, as near their zeros only the absolute error is bounded.
        for order in 0..3 {
            let error = (received[order] - expected[order]).abs();
            assert!(
                error <= 1e-12 * sizes[order],
                "derivative {order} at {master}: {received:?} {expected:?}"
            );
        }
    }
}

proptest! {
    #[test]
    fn motion_function_splines(points in spline_points()) {
        let knots: Vec<_> = points.iter().map(|p| (p.master, p.slave)).collect();
        let last = points.len() - 1;
        let secant = |i: usize| (knots[i + 1].1 - knots[i].1) / (knots[i + 1].0 - knots[i].0);
        let ends = match points[0].function {
            MotionLaw::SplineNatural => Some([End::Natural; 2]),
            MotionLaw::SplineTangential => {
                Some([points[0].velocity, points[last].velocity].map(End::Slope))
            }
            // Linear ends have the slope of their secant, hence the same equation as tangential ones.
            MotionLaw::SplineLinear => Some([secant(0), secant(last - 1)].map(End::Slope)),
            _ => None,
        };
        assert_same_spline(&plate(&points, Course::Linear), &knots, ends);
    }

    #[test]
    fn table_splines(rows in rows(), cyclic in any::<bool>()) {
        let course = if cyclic { Course::Cyclic } else { Course::Linear };
        let table = PositionTable::new(&rows, Interpolation::Spline, course).unwrap();
        // Lagrange's parabola through three rows, differentiated at the first one.
        let tangent = |rows: [(f64, f64); 3]| {
            let [(x0, y0), (x1, y1), (x2, y2)] = rows;
            y0 * (1.0 / (x0 - x1) + 1.0 / (x0 - x2))
                + y1 * (x0 - x2) / ((x1 - x0) * (x1 - x2))
                + y2 * (x0 - x1) / ((x2 - x0) * (x2 - x1))
        };
        let n = rows.len();
        let ends = (!cyclic).then(|| {
            [[rows[0], rows[1], rows[2]], [rows[n - 1], rows[n - 2], rows[n - 3]]]
                .map(|end| End::Slope(tangent(end)))
        });
        assert_same_spline(&Plate::from_table(table), &rows, ends);
    }
}

fn through(law: MotionLaw, index: u32, master: f64, slave: f64, velocity: f64) -> MotionPoint {
    MotionPoint {
        function: law,
        ..motion(index, master, slave, velocity)
    }
}

#[test]
fn each_end_has_its_own_condition() {
    use MotionLaw::{Spline, SplineNatural, SplineTangential};
    let points = [
        through(SplineNatural, 1, 0.0, 1.0, 9.0),
        through(Spline, 2, 2.0, 5.0, 9.0),
        through(Spline, 3, 3.0, -1.0, 9.0),
        through(SplineTangential, 4, 5.0, 2.0, -3.0),
    ];
    let knots: Vec<_> = points.iter().map(|p| (p.master, p.slave)).collect();
    let ends = Some([End::Natural, End::Slope(-3.0)]);
    assert_same_spline(&plate(&points, Course::Linear), &knots, ends);
}

#[test]
fn another_law_goes_on_smoothly_from_a_tangential_spline() {
    use MotionLaw::{Polynom5Mm, Spline, SplineTangential};
    let points = [
        through(SplineTangential, 1, 0.0, 1.0, 2.0),
        through(Spline, 2, 2.0, 5.0, 0.0),
        through(Polynom5Mm, 3, 3.0, -1.0, -4.0),
        rest(4, 5.0, 2.0),
    ];
    let plate = plate(&points, Course::Linear);
    assert!((plate.at(3.0).velocity + 4.0).abs() < 1e-12);
    assert!((plate.at(3.0_f64.next_down()).velocity + 4.0).abs() < 1e-12);
}

#[test]
fn one_spline_may_follow_another() {
    use MotionLaw::{Spline, SplineLinear, SplineNatural};
    let points = [
        through(SplineNatural, 1, 0.0, 1.0, 0.0),
        through(Spline, 2, 2.0, 5.0, 0.0),
        through(SplineLinear, 3, 3.0, -1.0, 0.0),
        through(SplineLinear, 4, 5.0, 2.0, 0.0),
    ];
    let plate = plate(&points, Course::Linear);
    // The second one is a straight line.
    assert!((plate.at(4.0).position - 0.5).abs() < 1e-12);
    assert!((plate.at(4.0).velocity - 1.5).abs() < 1e-12);
    assert!(plate.at(4.0).acceleration.abs() < 1e-12);
    // The first one ends with the slope of its last secant.
    assert!((plate.at(3.0_f64.next_down()).velocity + 6.0).abs() < 1e-9);
}
