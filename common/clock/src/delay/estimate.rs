//! Estimate of the delay, and its update by another evaluation of the window.

use super::window::Early;
use crate::instant::{Instant, Local};
use crate::numbers::together;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the estimate.
    EstimateTuning {
        /// Greatest number of estimates that the mean is taken over.
        // A hundred seconds' worth.
        memory: u32 = 1_000,
        /// Number of standard deviations that is out of the ordinary …
        // Where delays are correlated that happens by chance, and every exchange sees most of the window before, so it is followed once it has lasted
        // for `lasting` exchanges.
        out_of_the_ordinary: f64 = 5.0,
        /// … half of a window …
        lasting: u32 = 64,
        /// … or at once if it is this far off, which cannot be chance.
        beyond_chance: f64 = 20.0,
        /// An exchange that spans a jump of this size, s, is off by far more than jitter, and by half of it: …
        spanned_jump: f64 = 1e-3,
        /// … more than this part.
        spanning_part: f64 = 0.25,
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub(super) delay: f64,
    /// Half of the least round trip, and what a jump has added since, s.
    pub(super) uncertainty: f64,
    /// The first part of it, which is zero if the asymmetry of the ways is known, s.
    half_round_trip: f64,
    /// Deviation that jitter causes, s.
    pub(super) jitter: f64,
    pub(super) newest: Instant<Local>,
    /// True if enough exchanges have gone into it.
    pub(super) measured: bool,
    /// Number of estimates that it is the mean of; 0: the next one replaces it.
    count: u32,
    /// Estimates in a row that were out of the ordinary.
    contradictions: u32,
}

impl Estimate {
    /// Evaluates the ways of a window; `measured` if there are enough of them.
    pub(super) fn of(there: &Early, back: &Early, newest: Instant<Local>, measured: bool) -> Self {
        // Rounding of stamps may make a loop within one machine shorter than nothing.
        let half_round_trip = 0.5 * (there.least + back.least).max(0.0);
        let moved = 0.5 * libm::fabs((there.early - there.least) - (back.early - back.least));
        Self {
            delay: 0.5 * (there.early - back.early),
            uncertainty: half_round_trip + moved,
            half_round_trip,
            jitter: 0.5 * together(there.deviation, back.deviation),
            newest,
            measured,
            count: 1,
            contradictions: 0,
        }
    }

    /// Possible error, but for jitter, where the asymmetry of the ways is known, s.
    pub(super) fn doubt(&self) -> f64 {
        (self.uncertainty - self.half_round_trip).max(0.0)
    }

    /// The least round trip, s.
    pub(super) fn round_trip(&self) -> f64 {
        2.0 * self.half_round_trip
    }

    /// Shifts the estimate for ways that differ by twice this more than they did.
    pub(super) fn beside(self, asymmetry: f64) -> Self {
        Self {
            delay: self.delay + asymmetry,
            uncertainty: self.uncertainty + libm::fabs(asymmetry),
            ..self
        }
    }

    /// Merges the estimate `seen` of a window. A measured estimate is better than a window with too few exchanges.
    pub(super) fn after(&self, seen: Self) -> Self {
        if self.measured && !seen.measured {
            return Self {
                newest: seen.newest,
                ..*self
            };
        }
        let off = libm::fabs(seen.delay - self.delay) / seen.jitter;
        // Not a number: neither differs from the other, nor is there jitter.
        let contradictions = match off > TUNING.out_of_the_ordinary {
            true => self.contradictions + 1,
            false => 0,
        };
        let holds = off.is_nan() || off <= TUNING.beyond_chance && contradictions <= TUNING.lasting;
        if !(self.measured && self.count > 0 && holds) {
            return seen;
        }
        let count = (self.count + 1).min(TUNING.memory);
        // The newer ones weigh more: the line was not as good when the first ones were measured.
        let part = 2.0 / f64::from(count + 1);
        let delay = self.delay + (seen.delay - self.delay) * part;
        Self {
            delay,
            uncertainty: seen.uncertainty + libm::fabs(seen.delay - delay),
            count,
            contradictions,
            ..seen
        }
    }

    /// Follows a jump: the line fell by `jump`, and the path is taken to have grown by as much, s.
    pub(super) fn follow_jump(&mut self, jump: f64) {
        self.delay += jump;
        self.uncertainty += libm::fabs(jump);
    }

    /// Restores the usual delay after an exchange that spans a jump, which is off by half of it, and may have been
    /// believed for a moment, s.
    pub(super) fn forget_spanning(&mut self, jump: f64, usual: f64) {
        let jump = libm::fabs(jump);
        if jump >= TUNING.spanned_jump
            && libm::fabs(self.delay - usual) > TUNING.spanning_part * jump
        {
            self.delay = usual;
        }
    }

    /// Takes back this part of a jump, which was not the path's, s.
    pub(super) fn take_back(&mut self, jump: f64) {
        self.delay -= jump;
        // It grew by the jump when that was taken for the path's.
        self.uncertainty = (self.uncertainty - libm::fabs(jump)).max(0.0);
    }

    /// Lets the next measured estimate replace this one, whatever it says.
    pub(super) const fn be_replaced(&mut self) {
        self.count = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(delay: f64) -> Estimate {
        Estimate {
            delay,
            uncertainty: 200e-6,
            half_round_trip: 200e-6,
            jitter: 1e-6,
            newest: Instant::EPOCH,
            measured: true,
            count: 1,
            contradictions: 0,
        }
    }

    #[test]
    fn a_mean_of_minutes_follows_a_path_that_changes_a_little() {
        let mut estimate = of(0.0);
        for _ in 0..3_000 {
            estimate = estimate.after(of(0.0));
        }
        // 50 s of ten exchanges a second; two standard deviations may be chance.
        for _ in 0..500 {
            estimate = estimate.after(of(2e-6));
        }
        let followed = estimate.delay / 2e-6;
        assert!((0.59..0.67).contains(&followed), "{followed}");
    }

    #[test]
    fn an_exchange_that_spans_a_jump_is_not_believed() {
        let after = |jump: f64, off: f64| {
            let mut estimate = of(3e-3 + off);
            estimate.forget_spanning(jump, 3e-3);
            estimate.delay - 3e-3
        };
        for sign in [1.0, -1.0] {
            // It is off by half of the jump.
            assert_eq!(after(sign * 10e-3, 5e-3), 0.0);
            assert_eq!(after(sign * 1.2e-3, 0.6e-3), 0.0);
            // Jitter may have done this.
            assert!(after(sign * 0.8e-3, 0.4e-3) > 0.0);
            assert!(after(sign * 10e-3, 2.1e-3) > 0.0);
            assert_eq!(after(sign * 10e-3, 2.9e-3), 0.0);
        }
    }
}
