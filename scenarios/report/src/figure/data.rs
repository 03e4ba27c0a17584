//! Data of a curve.

use coaxle_lab::curves::{Series, Stretch, joined};

/// Data of a curve, in the order of their places.
#[derive(Clone, Debug)]
pub enum Data {
    /// Observed points; one that is not finite is a gap.
    Points(Vec<(f64, f64)>),
    /// Points of a continuous course, linear between two of them.
    Course(Vec<(f64, f64)>),
    /// Extremes of stretches of time, and every cycle of some windows.
    Levels {
        /// The extremes, in order.
        stretches: Vec<Stretch>,
        /// The cycles, in order.
        windows: Vec<Vec<(f64, f64)>>,
    },
}

impl Data {
    /// Returns a series shifted by an offset, thinned to the room: neighbouring stretches joined, and its first windows.
    pub(crate) fn of(series: &Series, room: Room, offset: f64) -> Self {
        // Rounded up, as rounding down would leave more groups than there is room for.
        let per_group = series.stretches.len().div_ceil(room.stretches.max(1));
        // Without stretches the quotient is 0, and chunks of no length panic.
        let groups = series.stretches.chunks(per_group.max(1));
        let shifted = |stretch: Stretch| Stretch {
            low: stretch.low + offset,
            high: stretch.high + offset,
            ..stretch
        };
        let windows = series.windows.iter().take(room.windows);
        let cycles = |window: &Vec<(f64, f64)>| {
            let cycles = window.iter();
            cycles.map(|(t, value)| (*t, value + offset)).collect()
        };
        Self::Levels {
            stretches: groups.filter_map(joined).map(shifted).collect(),
            windows: windows.map(cycles).collect(),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        match self {
            Self::Points(points) | Self::Course(points) => points.is_empty(),
            Self::Levels { stretches, .. } => stretches.is_empty(),
        }
    }

    /// Returns the places where it begins and ends.
    pub(super) fn ends(&self) -> Vec<f64> {
        match self {
            Self::Points(points) | Self::Course(points) => {
                let finite = || points.iter().map(|point| point.0);
                // Gaps at the ends have no place. Points are in order, so the first and the last are the ends.
                let mut finite = finite().filter(|at| at.is_finite());
                let first = finite.next();
                first.into_iter().chain(finite.next_back()).collect()
            }
            Self::Levels { stretches, .. } => {
                let (Some(first), Some(last)) = (stretches.first(), stretches.last()) else {
                    return Vec::new();
                };
                // The last one lasts as long as the others.
                let each = (last.t_s - first.t_s) / (stretches.len() - 1).max(1) as f64;
                vec![first.t_s, last.t_s + each]
            }
        }
    }

    pub(super) fn values_from(&self, from: f64) -> Vec<f64> {
        match self {
            Self::Points(points) | Self::Course(points) => {
                let points = points.iter().filter(|(at, _)| *at >= from);
                points.map(|(_, value)| *value).collect()
            }
            Self::Levels { stretches, .. } => {
                let stretches = stretches.iter().filter(|stretch| stretch.t_s >= from);
                stretches.flat_map(|s| [s.low, s.high]).collect()
            }
        }
    }
}

/// Room of a report for each series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Room {
    pub(crate) stretches: usize,
    pub(crate) windows: usize,
}

impl Room {
    /// Greatest number of stretches, and of cycles, in all curves together.
    // At 2.4 characters a number (`step_of`): two numbers of each stretch are 0.3 MB, those of the cycles 0.6 MB.
    // A report stays below 2 MB (docs/REPORTS.md), with the frame, the tables and the scenario.
    const MOST_STRETCHES: usize = 60_000;
    const MOST_CYCLES: usize = 260_000;

    /// Divides the room among all series. Each of them keeps the same windows, the first ones.
    pub(crate) fn shared_by<'a>(all: impl Iterator<Item = &'a Series> + Clone) -> Self {
        let known = all.clone().filter(|series| !series.stretches.is_empty());
        let stretches = Self::MOST_STRETCHES / known.count().max(1);
        let most = all.clone().map(|series| series.windows.len()).max();
        let mut cycles = 0;
        // A window counts with all series: kept of some only, they could not be compared in it.
        let fits = |window: &usize| {
            let lengths = all.clone().filter_map(|series| series.windows.get(*window));
            cycles += lengths.map(Vec::len).sum::<usize>();
            cycles <= Self::MOST_CYCLES
        };
        Self {
            // No series of the lab has more than 4000. Fewer than 200 would be blocks of several pixels each.
            stretches: stretches.clamp(200, 4_000),
            windows: (0..most.unwrap_or(0)).take_while(fits).count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joining_keeps_the_extremes() {
        let mut series = Series::default();
        for k in 0..1_000 {
            let value = if k == 500 { 7.0 } else { 1.0 };
            series.push(f64::from(k), Some(value));
        }
        let room = Room {
            stretches: 90,
            windows: 0,
        };
        let Data::Levels { stretches, .. } = Data::of(&series, room, 1.0) else {
            panic!("no levels");
        };
        assert!(stretches.len() <= 90);
        assert_eq!(stretches.iter().filter(|s| s.high == 8.0).count(), 1);
        assert!(stretches.iter().all(|s| s.low == 2.0));
    }

    #[test]
    fn many_curves_share_the_room() {
        let mut series = Series::default();
        series.keep(0.0, 999.0);
        (0..1_500).for_each(|k| series.push(f64::from(k), Some(1.0)));
        series.keep(2_000.0, 2_999.0);
        (1_500..5_000).for_each(|k| series.push(f64::from(k), Some(1.0)));
        let alone = Room::shared_by([&series].into_iter());
        assert_eq!((alone.stretches, alone.windows), (4_000, 2));
        let many = vec![&series; 200];
        let shared = Room::shared_by(many.into_iter());
        // 60 000 / 200, and 200 · 1000 cycles of the first window: the second would make 400 000.
        assert_eq!((shared.stretches, shared.windows), (300, 1));
    }
}
