//! A phase of constant velocity between the shortest ramps that the limits allow.

use coaxle_curve::profile::bracket;

use super::ramp::{RampBounds, shortest_ramp};
use super::sync_span::SyncSpan;

/// P5+P1+P5: the slope of P1, and the signed lengths of the ramps to it and from it.
pub(super) struct Plateau {
    pub(super) slope: f64,
    pub(super) first: f64,
    pub(super) last: f64,
}

impl Plateau {
    /// Returns the plateau between the shortest ramps, if the distance has room for them.
    pub(super) fn with_shortest_ramps(span: &SyncSpan) -> Option<Self> {
        // As seen by a master that moves forwards.
        let direction = span.master.signum();
        let problem = PlateauProblem {
            bounds: span.task.ramp_bounds(span.task.checked_jerk()),
            distance: span.master.abs(),
            slave: span.slave,
            from: span.from * direction,
            to: span.task.ratio * direction,
        };
        let lower = problem.from.min(problem.to);
        // Even the lower velocity of both leads too far: the
        // plateau lies below both, which is the mirrored case.
        let slope = if problem.excess(lower) > 0.0 {
            -problem.mirrored().solve()?
        } else {
            problem.solve()?
        };
        let (first, last) = problem.ramps(slope);
        Some(Self {
            slope: slope * direction,
            first: first * direction,
            last: last * direction,
        })
    }
}

/// Search for the slope between two ramps that covers the distance.
struct PlateauProblem {
    bounds: RampBounds,
    distance: f64,
    slave: f64,
    from: f64,
    to: f64,
}

impl PlateauProblem {
    fn mirrored(&self) -> Self {
        Self {
            slave: -self.slave,
            from: -self.from,
            to: -self.to,
            ..*self
        }
    }

    /// Finds a slope not below the lower of the two ends; the slave's path grows with it as long as there
    /// is room for the ramps.
    fn solve(&self) -> Option<f64> {
        let (lower, upper) = (self.from.min(self.to), self.from.max(self.to));
        // Room for the ramps is checked when the pieces are made.
        if self.excess(upper) >= 0.0 {
            return Some(last_before(lower, upper, |slope| self.excess(slope)));
        }
        // Ramps at the larger of the two limits reach at most this far.
        let steepest = self.bounds.acceleration.max(self.bounds.deceleration);
        let beyond = upper + self.distance * steepest;
        // The fastest slope whose ramps leave room, since the
        // distance grows with the slope only up to there.
        let highest = last_before(upper, beyond, |slope| {
            let (first, last) = self.ramps(slope);
            first + last - self.distance
        });
        (self.excess(highest) >= 0.0)
            .then(|| last_before(upper, highest, |slope| self.excess(slope)))
    }

    /// Excess of the slave's distance over the one needed.
    fn excess(&self, slope: f64) -> f64 {
        let (first, last) = self.ramps(slope);
        // A symmetric ramp has the mean of its two slopes, so
        // it loses half of the difference over its length.
        let lost = (slope - self.from) * first / 2.0 + (slope - self.to) * last / 2.0;
        slope * self.distance - lost - self.slave
    }

    fn ramps(&self, slope: f64) -> (f64, f64) {
        (
            shortest_ramp(self.from, slope, &self.bounds),
            shortest_ramp(slope, self.to, &self.bounds),
        )
    }
}

/// Returns the last place from `low` to `high` at which the rising `f` is not above zero; `low` if there
/// is none.
fn last_before(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (at_low, at_high) = (f(low), f(high));
    // The whole interval is on one side: its end is the answer, and there is no sign to search for.
    if at_high <= 0.0 {
        high
    } else if at_low >= 0.0 {
        low
    } else {
        bracket((low, at_low), (high, at_high), f).below
    }
}
