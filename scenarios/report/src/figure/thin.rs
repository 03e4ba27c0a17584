//! Thinning of points without a visible difference.

/// Points per column that are kept.
// The first, the lowest, the highest and the last one.
const KEPT: usize = 4;

/// Thins points, in the order of their places, to a number of columns: of each column the first, the lowest, the highest and
/// the last one stay. A line through these covers the same pixels as one through all (M4: Jugel, Jerzak, Hackenbroich, Markl,
/// "M4: a visualization-oriented time series data aggregation", VLDB 2014); means or every n-th point would hide a beat, which
/// lasts a single cycle. A point that is not finite is a gap and stays one.
#[must_use]
pub fn thinned(points: &[(f64, f64)], columns: usize) -> Vec<(f64, f64)> {
    let columns = columns.max(1);
    // Fewer than could be kept: thinning could only lose some.
    if points.len() <= KEPT * columns {
        return points.to_vec();
    }
    let mut finite = points.iter().filter(|point| is_finite(point));
    let (Some(first), Some(last)) = (finite.next(), finite.next_back()) else {
        return points.iter().take(1).copied().collect();
    };
    let (from, length) = (first.0, last.0 - first.0);
    let column = |point: &(f64, f64)| -> Option<usize> {
        // Points of a single place have no length: 0/0 is not a number, which becomes column 0.
        let share = (point.0 - from) / length;
        is_finite(point).then_some((share * columns as f64) as usize)
    };
    // Points that are not finite have no column, so that a gap is a run of its own.
    let runs = points.chunk_by(|a, b| column(a) == column(b));
    runs.flat_map(outline).collect()
}

fn is_finite((at, value): &(f64, f64)) -> bool {
    at.is_finite() && value.is_finite()
}

/// Returns the first, the lowest, the highest and the last point, in their order; of a gap only one.
fn outline(run: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let numbers = || run.iter().enumerate();
    let lowest = numbers().min_by(|(_, a), (_, b)| a.1.total_cmp(&b.1));
    let highest = numbers().max_by(|(_, a), (_, b)| a.1.total_cmp(&b.1));
    let (Some((lowest, _)), Some((highest, point))) = (lowest, highest) else {
        return Vec::new();
    };
    // Runs are finite as a whole or not at all.
    if !is_finite(point) {
        return vec![run[0]];
    }
    let mut kept = vec![0, lowest, highest, run.len() - 1];
    // An extreme may be the first or the last point, and either extreme may come first.
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|n| run[n]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_of_a_single_cycle_stay() {
        let value = |n: usize| match n {
            7_777 => 5.0,
            7_778 => -5.0,
            _ => 0.1 * (n as f64 * 0.01).sin(),
        };
        let points: Vec<_> = (0..100_000).map(|n| (n as f64, value(n))).collect();
        let thin = thinned(&points, 200);
        // The last point lies at the end of the last column, and has one of its own.
        assert!(thin.len() <= 4 * 201, "{}", thin.len());
        for spike in [(7_777.0, 5.0), (7_778.0, -5.0)] {
            assert_eq!(thin.iter().filter(|point| **point == spike).count(), 1);
        }
        assert_eq!((thin.first(), thin.last()), (points.first(), points.last()));
        assert!(thin.is_sorted_by(|a, b| a.0 <= b.0));
        let column = |point: &(f64, f64)| (point.0 / 500.0) as usize;
        let highest = |points: &[(f64, f64)], n: usize| {
            let of = points.iter().filter(|point| column(point) == n);
            of.map(|point| point.1).fold(f64::NEG_INFINITY, f64::max)
        };
        assert!((0..200).all(|n| highest(&thin, n) == highest(&points, n)));
    }

    #[test]
    fn a_gap_stays_and_few_points_are_left_alone() {
        let few = vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, 1.0)];
        assert_eq!(thinned(&few, 1).len(), 3);
        assert!(thinned(&[], 10).is_empty());
        let mut points: Vec<_> = (0..10_000).map(|n| (f64::from(n), 1.0)).collect();
        for point in &mut points[4_000..6_000] {
            point.1 = f64::NAN;
        }
        let thin = thinned(&points, 100);
        assert_eq!(thin.iter().filter(|point| point.1.is_nan()).count(), 1);
        assert!(thin.len() < 300, "{}", thin.len());
        let none: Vec<_> = (0..100).map(|n| (f64::from(n), f64::NAN)).collect();
        assert_eq!(thinned(&none, 10).len(), 1);
    }

    #[test]
    fn what_goes_backwards_and_what_stands_is_thinned_too() {
        let back: Vec<_> = (0..1_000).map(|n| (-f64::from(n), f64::from(n))).collect();
        assert!(thinned(&back, 10).len() <= 44);
        let stands: Vec<_> = (0..1_000).map(|n| (1.0, f64::from(n % 7))).collect();
        let thin = thinned(&stands, 10);
        assert!(thin.len() <= 4 && thin.iter().any(|point| point.1 == 6.0));
    }
}
