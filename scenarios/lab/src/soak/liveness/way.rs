//! A way that an axis has to make up, and the time that it takes at most.

use coaxle_curve::profile::Limits;

/// Part of a velocity limit that a target may have for the axis to approach it with the rest.
pub(super) const HALF: f64 = 0.5;

/// A way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    /// Time at which it began, s.
    pub(super) since: f64,
    /// Greatest distance since then, u.
    pub(super) distance: f64,
}

impl Way {
    pub(super) const fn new(since: f64, distance: f64) -> Self {
        Self { since, distance }
    }

    pub(super) const fn note(&mut self, distance: f64) {
        self.distance = self.distance.max(distance);
    }
}

/// Longest time of an axis with limits to a target of at most half of its velocity limit, s.
pub(super) fn within(limits: &Limits, distance: f64) -> f64 {
    let pull = limits.acceleration().min(limits.deceleration());
    // D/(v − v/2), and at either end a ramp over v: v/a + a/j. The target may be on the other side of the axis's motion at first, …
    let ramp = limits.velocity() / pull + pull / limits.jerk();
    // … whose way there and back, up to v·ramp, counts with the distance.
    (distance + limits.velocity() * ramp) / (HALF * limits.velocity()) + 2.0 * ramp
}
