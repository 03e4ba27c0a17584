//! Uncertainty of an estimate.

use super::parameters::CheckedEncoder;

/// Standard deviations of the loop in its steady state.
///
/// For a third-order loop at its Riccati bound: with a bandwidth ω and a noise r the variances are
/// 2ωr of the position, 3ω³r of the velocity and 2ω²r of both together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Uncertainty {
    position: f64,
    both: f64,
    velocity: f64,
    /// Standard deviation of a position anywhere in an increment, with vibration.
    at_rest: f64,
    sampling: f64,
}

impl Uncertainty {
    pub(super) fn new(checked: &CheckedEncoder) -> Self {
        let (w, r) = (checked.bandwidth, checked.noise);
        let given = &checked.given;
        let variance = given.increment * given.increment / 12.0 + given.vibration * given.vibration;
        Self {
            position: 2.0 * w * r,
            both: 2.0 * w * w * r,
            velocity: 3.0 * w * w * w * r,
            at_rest: libm::sqrt(variance),
            sampling: checked.sampling,
        }
    }

    /// Standard deviations of position, u, and velocity, u/s, of a moving axis some seconds after
    /// the last sample.
    pub(super) fn moving(&self, horizon: f64) -> (f64, f64) {
        // Variance of p + h·v: P + 2h·C + h²·V.
        let position = self.position + horizon * (2.0 * self.both + horizon * self.velocity);
        (libm::sqrt(position), libm::sqrt(self.velocity))
    }

    /// Standard deviations of an axis that has been standing for this number of seconds.
    pub(super) fn standing(&self, since: f64) -> (f64, f64) {
        // Faster than this the axis would have left its increment in that time.
        (self.at_rest, self.at_rest / since.max(self.sampling))
    }
}
