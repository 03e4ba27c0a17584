//! The true drift between two clocks.

use coaxle_clock::{Instant, Span};
use coaxle_sim::Truth;

use crate::row::Reference;

/// The stretch over which the true drift is taken: one to two of these.
// Instants are whole nanoseconds: over 5 s that is 0.0002 ppm.
const STRETCH: Span = Span::from_secs(5);

/// The true drift: the sender's time against the receiver's own cycles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DriftTruth {
    older: Option<DriftMark>,
    newer: Option<DriftMark>,
    last: Option<DriftMark>,
}

#[derive(Clone, Copy, Debug)]
struct DriftMark {
    at: Instant<Reference>,
    epoch: u64,
    truth: Truth,
    own: f64,
}

impl DriftTruth {
    pub(super) fn push(&mut self, at: Instant<Reference>, truth: &Truth, own: f64) {
        let mark = DriftMark {
            at,
            epoch: truth.epoch,
            truth: *truth,
            own,
        };
        // Another run counts its time from another zero.
        if self.last.is_some_and(|last| last.epoch != mark.epoch) {
            *self = Self::default();
        }
        self.last = Some(mark);
        if self.newer.is_none_or(|newer| at - newer.at >= STRETCH) {
            // Two marks, so that the older one lies a whole stretch back when the newer one has just been set.
            self.older = self.newer.or(Some(mark));
            self.newer = Some(mark);
        }
    }

    pub(super) fn ppm(&self) -> Option<f64> {
        let (from, to) = (self.older?, self.last?);
        let own = to.own - from.own;
        let far = to.truth.seconds_since(&from.truth).0;
        // In its first cycle a run has no stretch yet.
        (own > 0.0).then(|| 1e6 * (far / own - 1.0))
    }
}
