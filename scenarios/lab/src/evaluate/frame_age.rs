//! Age of the newest frame in the cycles of a receiver: quantiles.

use coaxle_clock::cycle_lock::CycleLockState;

use crate::record::ReceiverCycle;
use crate::summary::ReceiverSummary;

/// Resolution of the ages, µs: an eighth of the spread that a locked cycle may have.
const STEP_US: f64 = 0.25;
/// Longest age that has a place of its own, µs: older ones count as so old.
const OLDEST_US: f64 = 50_000.0;

/// Time for which a cycle is locked before it counts, ns: the rest of its phase falls to a thousandth meanwhile.
const SETTLING_NS: i64 = 10_000_000_000;

/// Histogram of the ages.
#[derive(Debug, Default)]
pub(super) struct FrameAges {
    /// As long as the oldest one so far needs.
    bins: Vec<u32>,
    all: u64,
    /// Newest cycle that was not locked, and was to be.
    unlocked_ns: Option<i64>,
}

impl FrameAges {
    /// Takes the newest frame of a cycle. Where the cycle is to be locked, only once it has been for a while.
    pub(super) fn push(&mut self, record: &ReceiverCycle) {
        let is_unlocked = record
            .node
            .cycle_lock
            .is_some_and(|lock| lock != CycleLockState::Locked);
        if is_unlocked {
            self.unlocked_ns = Some(record.at_ns);
        }
        let is_led = (self.unlocked_ns).is_none_or(|until| record.at_ns - until >= SETTLING_NS);
        let Some(age) = record.far.frame_age_us.filter(|_| is_led) else {
            return;
        };
        let bin = (age.clamp(0.0, OLDEST_US) / STEP_US) as usize;
        if bin >= self.bins.len() {
            self.bins.resize(bin + 1, 0);
        }
        self.bins[bin] = self.bins[bin].saturating_add(1);
        self.all += 1;
    }

    /// Writes the figures, if there was a frame.
    pub(super) fn show(&self, summary: &mut ReceiverSummary) {
        if self.all == 0 {
            return;
        }
        let [first, median, last] = [0.01, 0.5, 0.99].map(|share| self.quantile(share));
        summary.frame_age_p1_us = Some(first);
        summary.frame_age_p50_us = Some(median);
        summary.frame_age_p99_us = Some(last);
        summary.frame_age_spread_us = Some(last - first);
    }

    fn quantile(&self, share: f64) -> f64 {
        let wanted = (self.all as f64 * share) as u64;
        let mut below = 0;
        let bin = self.bins.iter().position(|count| {
            below += u64::from(*count);
            below > wanted
        });
        bin.unwrap_or(self.bins.len() - 1) as f64 * STEP_US
    }
}
