//! Room for the line that the waits of batched messages leave open.
//!
//! The last message of a batch waited for its batch to leave: for anything from no time to a cycle, as the next one would
//! have come with it otherwise. So all waits lie within a cycle above the line, and a line that they leave room below is
//! as likely as the one that is followed. They are not independent: from batch to batch the wait changes by the same part
//! of a cycle, so that waits are on a grid, which moves with the drift as a whole. A line through their lower edge moves
//! with it for tens of seconds, and predicts itself perfectly.

use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the waits.
    WaitsTuning {
        /// The part of a cycle that stays open even where waits seem to fill it, as the queue of a batch and what is lost of it move waits, too.
        // In observer_table, power saving: errors of 0.03 cycles rms and up to 0.09 at cycles of 1 and 10 ms; the standard deviation of this part is
        // 0.06 cycles.
        least_open: f64 = 0.2,
    }
}

/// The waits that are compared: those of three seconds of an access point's beacons.
const KEPT: usize = 32;

/// The last waits, as seen from the line.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) struct Waits {
    /// s
    last: [f64; KEPT],
    taken: usize,
}

impl Waits {
    pub(in crate::observer) const fn new() -> Self {
        Self {
            last: [0.0; KEPT],
            taken: 0,
        }
    }

    /// Takes how far above the line the last message of a batch came, s.
    pub(in crate::observer) const fn take(&mut self, above: f64) {
        self.last[self.taken % KEPT] = above;
        self.taken += 1;
    }

    /// Width of the room that they leave, for this cycle time, s; 0 if messages do not come in batches.
    pub(in crate::observer) fn open(&self, cycle: f64) -> f64 {
        let known = &self.last[..self.taken.min(KEPT)];
        if known.is_empty() {
            return 0.0;
        }
        // Waits lie within one cycle, so the line may be as far below the least as the greatest leaves of it.
        let least = known.iter().copied().fold(f64::INFINITY, f64::min);
        let most = known.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (cycle - (most - least)).clamp(TUNING.least_open * cycle, cycle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_wait_fills_is_open() {
        let mut waits = Waits::new();
        assert_eq!(waits.open(1e-3), 0.0);
        waits.take(0.0);
        assert_eq!(waits.open(1e-3), 1e-3);
        // Two waits, half a cycle apart.
        for n in 0..200 {
            waits.take(if n % 2 == 0 { 0.1e-3 } else { 0.6e-3 });
        }
        assert!((waits.open(1e-3) - 0.5e-3).abs() < 1e-12);
        // And all there are.
        for n in 0..200 {
            waits.take(f64::from(n % 20) * 0.05e-3);
        }
        assert_eq!(waits.open(1e-3), 0.2e-3);
    }
}
