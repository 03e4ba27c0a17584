//! The direction gate: selects the counts that are progress, in integers only.
//!
//! A count that vibrates about the border of an increment is no motion, and no estimated velocity
//! determines a direction. The range of the counts determines it:
//!
//! * Running, a new extreme is an edge; a retreat from it by the hysteresis is a reversal.
//! * Resting, all counts since then make a range. A range that grows is an edge, but a tentative one;
//!   a range as wide as the hysteresis is a motion, in the direction in which it grew, unless its ends
//!   are extremes of a vibration that lie far apart in time ([`RecentRange`]).

use coaxle_axis::TravelDirection;

use super::recent_range::RecentRange;

/// An increment beyond all previous ones was entered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Edge {
    pub(super) direction: TravelDirection,
    /// The count of that increment.
    pub(super) cell: i64,
    /// Number of edges passed at once; 1 or more.
    pub(super) counts: i64,
}

/// Result of a count for the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Passage {
    Edge(Edge),
    /// The count is that of the last edge.
    SameCell,
    /// The count is behind the last edge, by less than the hysteresis.
    Retreated,
}

/// Lets edges pass.
#[derive(Clone, Debug)]
pub(super) struct Gate {
    hysteresis: i64,
    direction: Option<TravelDirection>,
    extreme: i64,
    /// Counts since it rests; none while it runs.
    resting: Option<Resting>,
}

/// Counts of a resting axis.
#[derive(Clone, Copy, Debug)]
struct Resting {
    /// The lowest and the highest one.
    all: (i64, i64),
    /// Those that show a motion.
    recent: RecentRange,
}

impl Gate {
    /// Creates a gate on a resting axis.
    pub(super) const fn new(hysteresis: i64, count: i64) -> Self {
        Self {
            hysteresis,
            direction: None,
            extreme: count,
            resting: Some(Resting::from(count, count)),
        }
    }

    /// Direction of the newest certain motion; none before the first.
    pub(super) const fn direction(&self) -> Option<TravelDirection> {
        self.direction
    }

    /// True if the axis has certainly moved since it rested.
    pub(super) const fn is_released(&self) -> bool {
        self.resting.is_none()
    }

    /// Notes that the axis came to rest at this count.
    pub(super) fn rest(&mut self, count: i64) {
        let to = self.extreme;
        // A range that has begun stays: replaced at each count, a slow start would never become as wide as the
        // hysteresis.
        self.resting = self.resting.or(Some(Resting::from(count, to)));
    }

    pub(super) fn update(&mut self, count: i64) -> Passage {
        match (self.resting, self.direction) {
            (None, Some(direction)) => self.run(direction, count),
            (Some(resting), _) => self.leave(resting, count),
            // Released without a direction does not occur; at rest is the state that moves nothing.
            (None, None) => {
                self.rest(count);
                Passage::SameCell
            }
        }
    }

    fn run(&mut self, direction: TravelDirection, count: i64) -> Passage {
        let progress = progress(direction, self.extreme, count);
        if progress > 0 {
            self.pass(direction, count, progress)
        } else if progress <= -self.hysteresis {
            self.direction = Some(direction.opposite());
            self.pass(direction.opposite(), count, -progress)
        } else if progress == 0 {
            Passage::SameCell
        } else {
            Passage::Retreated
        }
    }

    fn leave(&mut self, mut resting: Resting, count: i64) -> Passage {
        let recent = resting.recent.ends();
        resting.recent.add(count);
        let (low, high) = resting.recent.ends();
        // Vibration of less than the hysteresis never makes a range as wide as that, wherever in an increment the
        // axis stands.
        let is_motion = high.wrapping_sub(low) >= self.hysteresis;
        let grown = beyond(resting.all, count).or_else(|| {
            // A motion within the range of an earlier vibration.
            beyond(recent, count).filter(|_| is_motion)
        });
        let (low, high) = resting.all;
        resting.all = (low.min(count), high.max(count));
        self.resting = Some(resting);
        let Some((direction, counts)) = grown else {
            return if count == self.extreme {
                Passage::SameCell
            } else {
                Passage::Retreated
            };
        };
        if is_motion {
            self.resting = None;
            self.direction = Some(direction);
        }
        // A tentative edge passes too: the estimator needs its instant if it becomes the first of a motion.
        self.pass(direction, count, counts)
    }

    const fn pass(&mut self, direction: TravelDirection, cell: i64, counts: i64) -> Passage {
        self.extreme = cell;
        Passage::Edge(Edge {
            direction,
            cell,
            counts,
        })
    }
}

impl Resting {
    /// Counts of an axis that rests at the first of the two, and has moved up to the other.
    const fn from(count: i64, extreme: i64) -> Self {
        let all = if count < extreme {
            (count, extreme)
        } else {
            (extreme, count)
        };
        Self {
            all,
            recent: RecentRange::of(all),
        }
    }
}

/// Direction and distance in which a count is outside a range; none inside.
const fn beyond((low, high): (i64, i64), count: i64) -> Option<(TravelDirection, i64)> {
    if count > high {
        Some((TravelDirection::Forward, count.wrapping_sub(high)))
    } else if count < low {
        Some((TravelDirection::Backward, low.wrapping_sub(count)))
    } else {
        None
    }
}

/// Distance from one count to another in this direction.
const fn progress(direction: TravelDirection, from: i64, to: i64) -> i64 {
    match direction {
        TravelDirection::Forward => to.wrapping_sub(from),
        TravelDirection::Backward => from.wrapping_sub(to),
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use TravelDirection::{Backward, Forward};
    use proptest::prelude::*;

    use super::*;

    fn after(hysteresis: i64, counts: &[i64]) -> Gate {
        let mut gate = Gate::new(hysteresis, 0);
        for &count in counts {
            let _ = gate.update(count);
        }
        gate
    }

    fn edge(direction: TravelDirection, cell: i64, counts: i64) -> Passage {
        Passage::Edge(Edge {
            direction,
            cell,
            counts,
        })
    }

    #[test]
    fn the_first_edge_from_rest_is_tentative_and_the_second_a_motion() {
        let mut gate = Gate::new(2, 0);
        assert_eq!(gate.update(1), edge(Forward, 1, 1));
        assert_eq!((gate.direction(), gate.is_released()), (None, false));
        assert_eq!(gate.update(2), edge(Forward, 2, 1));
        assert_eq!(
            (gate.direction(), gate.is_released()),
            (Some(Forward), true)
        );
    }

    #[test]
    fn running_extremes_are_edges_and_a_long_retreat_is_a_reversal() {
        let mut gate = after(2, &[1, 2]);
        assert_eq!(gate.update(5), edge(Forward, 5, 3));
        assert_eq!(gate.update(5), Passage::SameCell);
        assert_eq!(gate.update(4), Passage::Retreated);
        assert_eq!(gate.direction(), Some(Forward));
        assert_eq!(gate.update(3), edge(Backward, 3, 2));
        assert_eq!(gate.direction(), Some(Backward));
        assert_eq!(gate.update(2), edge(Backward, 2, 1));
    }

    #[test]
    fn a_start_from_a_trembling_rest_is_known_by_its_range() {
        for (counts, direction) in [([1, 0, 1, 2], Forward), ([1, 0, 0, -1], Backward)] {
            let gate = after(2, &counts);
            assert_eq!(gate.direction(), Some(direction));
            assert!(gate.is_released());
        }
    }

    #[test]
    fn rest_keeps_the_direction_and_holds_the_output() {
        let mut gate = after(2, &[1, 2, 3]);
        gate.rest(2);
        assert_eq!(
            (gate.direction(), gate.is_released()),
            (Some(Forward), false)
        );
        let _ = gate.update(3);
        assert!(!gate.is_released(), "that far it was before");
        let _ = gate.update(1);
        assert_eq!(
            (gate.direction(), gate.is_released()),
            (Some(Backward), true)
        );
    }

    #[test]
    fn extremes_of_a_vibration_that_lie_far_apart_are_no_motion() {
        // Vibration of one increment: 11 counts. Both extremes are within five standard deviations.
        let mut gate = Gate::new(11, 0);
        for extreme in [-5, 6, -5, 6, 0] {
            for k in 0..5_000 {
                let _ = gate.update([-1, 0, 1, 0][k % 4]);
            }
            let _ = gate.update(extreme);
            assert_eq!((gate.direction(), gate.is_released()), (None, false));
        }
        // A start within the range of the extremes is one all the same.
        let _ = (0..5_000).map(|_| gate.update(-5)).count();
        let passages: Vec<_> = (-4..=6).map(|count| gate.update(count)).collect();
        assert!(gate.is_released());
        assert_eq!(gate.direction(), Some(Forward));
        assert_eq!(passages.last(), Some(&edge(Forward, 6, 1)));
    }

    #[test]
    fn a_drift_under_vibration_is_a_motion_however_slow() {
        for (sign, direction) in [(1, Forward), (-1, Backward)] {
            let mut gate = Gate::new(11, 0);
            let mut drift = 0;
            // A count in 20 000 samples, with three counts of vibration to either side.
            for k in 0..400_000_i64 {
                drift = sign * (k / 20_000);
                let _ = gate.update(drift + [0, 1, -1, 3, -2, 2, -3][(k % 7) as usize]);
                if gate.is_released() {
                    break;
                }
            }
            assert_eq!(gate.direction(), Some(direction));
            assert!(drift.abs() <= 11, "{drift}");
        }
    }

    proptest! {
        #[test]
        fn what_stays_within_the_hysteresis_never_moves(
            hysteresis in 2_i64..20,
            counts in prop::collection::vec(0.0..1.0, 1..300),
            runs_first in any::<bool>(),
        ) {
            let mut gate = after(hysteresis, if runs_first { &[-20, 0] } else { &[] });
            let before = gate.direction();
            let start = if runs_first { hysteresis - 1 } else { 0 };
            for share in counts {
                let count = (share * hysteresis as f64) as i64 - start;
                let _ = gate.update(count);
                prop_assert_eq!(gate.direction(), before);
            }
        }

        #[test]
        fn a_direction_is_that_of_a_way_as_long_as_the_hysteresis(
            hysteresis in 2_i64..6,
            steps in prop::collection::vec(-3_i64..=3, 1..300),
        ) {
            let mut gate = Gate::new(hysteresis, 0);
            let (mut count, mut low, mut high) = (0, 0, 0);
            for step in steps {
                count += step;
                (low, high) = (low.min(count), high.max(count));
                let before = gate.direction();
                let _ = gate.update(count);
                if gate.direction() != before {
                    let way = if gate.direction() == Some(Forward) { count - low } else { high - count };
                    prop_assert!(way >= hysteresis);
                    (low, high) = (count, count);
                }
            }
        }
    }
}
