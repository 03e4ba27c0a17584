//! Error of a line by its newest measurements, where chance does not explain that: the rate of a clock has changed, or changes
//! more quickly than the line follows.
//!
//! The filters need some measurements until they follow another rate. A servo changes the rate of its clock at once.

use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the doubt.
    DoubtTuning {
        /// Part of an error that is expected in the next measurement, too.
        // A second's worth, in which the filters follow another rate. Of clocks that wander by 0.3 to 1 ppm/√s, with which far time was off by up to
        // twice what was stated, none is any more.
        kept: f64 = 0.9,
        /// Part of the error by chance below which it counts no more.
        negligible: f64 = 0.01,
    }
}

/// Error of a line, as its newest measurements show it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubt {
    /// Time of the newest measurement, s.
    at: f64,
    /// Distance from the line, s, or zero.
    off: f64,
    /// Greatest growth of that, s/s.
    growth: f64,
}

impl Doubt {
    /// No error but by chance.
    pub(super) const NONE: Self = Self {
        at: 0.0,
        off: 0.0,
        growth: 0.0,
    };

    /// Takes a measurement that `missed` the line, `passed` seconds after the last one that the line took; up to `by_chance` that says
    /// nothing.
    pub(super) fn take(&mut self, at: f64, passed: f64, missed: f64, by_chance: f64) {
        let missed = libm::fabs(missed);
        let new = if missed > by_chance { missed } else { 0.0 };
        let off = new.max(TUNING.kept * self.off);
        *self = if off > TUNING.negligible * by_chance && passed > 0.0 {
            // A rate that changed by r at the beginning of a group has moved its middle by r·g/2, and groups follow each other by g.
            let growth = 2.0 * off / passed;
            Self { at, off, growth }
        } else {
            Self::NONE
        };
    }

    /// True if there is an error beyond chance.
    pub(super) fn is_any(&self) -> bool {
        self.off > 0.0
    }

    /// Greatest error at a later time, s.
    pub(super) fn after(&self, at: f64) -> f64 {
        self.off + self.growth * (at - self.at).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chance_is_no_doubt_and_a_miss_beyond_it_grows_and_is_kept_for_some_measurements() {
        let mut doubt = Doubt::NONE;
        doubt.take(1.0, 0.16, 0.9e-6, 1e-6);
        assert!(!doubt.is_any());
        doubt.take(1.16, 0.16, -4e-6, 1e-6);
        // 4 µs, and for each 0.16 s twice that.
        assert!(
            (doubt.after(1.16) - 4e-6).abs() < 1e-12 && (doubt.after(1.32) - 12e-6).abs() < 1e-12
        );
        let kept = (0..100).take_while(|n| {
            doubt.take(1.32 + 0.16 * f64::from(*n), 0.16, 0.0, 1e-6);
            doubt.is_any()
        });
        // 0.9ⁿ of 4 µs is below a hundredth of 1 µs from the 57th on.
        assert_eq!(kept.count(), 56);
    }
}
