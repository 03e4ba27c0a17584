//! A phase of constant velocity between the shortest ramps that the limits allow.

use super::ramp::{RampBounds, shortest_ramp};
use super::span::Span;
use super::task::Task;

/// Halvings that leave nothing to find in an interval of ordinary size.
const HALVINGS: usize = 64;

/// P5+P1+P5: the slope of P1, and the signed lengths of the ramps to it and from it.
pub(super) struct Plateau {
    pub(super) slope: f64,
    pub(super) first: f64,
    pub(super) last: f64,
}

impl Plateau {
    /// The plateau between the shortest ramps, if the distance has room for them.
    pub(super) fn with_shortest_ramps(span: &Span) -> Option<Self> {
        // As seen by a master that moves forwards.
        let direction = span.master.signum();
        let problem = PlateauProblem {
            task: span.task,
            distance: span.master.abs(),
            slave: span.slave,
            from: span.from * direction,
            to: span.task.ratio * direction,
        };
        let lower = problem.from.min(problem.to);
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

/// Which slope between two ramps makes up the distance?
struct PlateauProblem<'a> {
    task: &'a Task,
    distance: f64,
    slave: f64,
    from: f64,
    to: f64,
}

impl PlateauProblem<'_> {
    fn mirrored(&self) -> Self {
        Self {
            slave: -self.slave,
            from: -self.from,
            to: -self.to,
            ..*self
        }
    }

    /// A slope not below the lower of the two ends; the slave's way grows with it as long as the
    /// ramps leave room.
    fn solve(&self) -> Option<f64> {
        let (lower, upper) = (self.from.min(self.to), self.from.max(self.to));
        if self.excess(upper) >= 0.0 {
            return Some(last_before(lower, upper, |slope| self.excess(slope) <= 0.0));
        }
        // Ramps at the larger of the two limits reach at most this far.
        let bounds = self.bounds();
        let steepest = bounds.acceleration.max(bounds.deceleration);
        let beyond = upper + self.distance * steepest;
        let highest = last_before(upper, beyond, |slope| {
            let (first, last) = self.ramps(slope);
            first + last <= self.distance
        });
        (self.excess(highest) >= 0.0)
            .then(|| last_before(upper, highest, |slope| self.excess(slope) <= 0.0))
    }

    /// How much farther than needed the slave gets.
    fn excess(&self, slope: f64) -> f64 {
        let (first, last) = self.ramps(slope);
        let lost = (slope - self.from) * first / 2.0 + (slope - self.to) * last / 2.0;
        slope * self.distance - lost - self.slave
    }

    fn ramps(&self, slope: f64) -> (f64, f64) {
        let bounds = self.bounds();
        (
            shortest_ramp(self.from, slope, &bounds),
            shortest_ramp(slope, self.to, &bounds),
        )
    }

    fn bounds(&self) -> RampBounds {
        self.task.ramp_bounds(self.task.checked_jerk())
    }
}

/// The last place from `low`, where `holds` does, to `high` at which it does.
fn last_before(low: f64, high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    if holds(high) {
        return high;
    }
    let (mut low, mut high) = (low, high);
    for _ in 0..HALVINGS {
        let middle = low + (high - low) / 2.0;
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}
