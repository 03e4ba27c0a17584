//! Lock-in and the time after it, which have separate figures.

use coaxle_clock::{Instant, Span};

use super::moments::Moments;
use crate::row::Reference;

/// Time in sync after which a receiver has blended and slewed all corrections.
const SETTLED_AFTER: Span = Span::from_secs(1);

/// Time for which a receiver has been in sync without a break.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Settling {
    in_sync_since: Option<Instant<Reference>>,
}

impl Settling {
    /// True if it is settled in the cycle at `at`.
    pub(super) fn is_settled(&mut self, in_sync: bool, at: Instant<Reference>) -> bool {
        if !in_sync {
            // Each break locks in again, and its blends belong to the lock-in.
            self.in_sync_since = None;
            return false;
        }
        at - *self.in_sync_since.get_or_insert(at) >= SETTLED_AFTER
    }
}

/// A figure over the whole evaluation, and apart once settled and before.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SettledFigure {
    pub(super) all: Moments,
    pub(super) settled: Moments,
    pub(super) lock_in: Moments,
}

impl SettledFigure {
    pub(super) fn push(&mut self, x: f64, is_settled: bool) {
        self.all.push(x);
        if is_settled {
            self.settled.push(x);
        } else {
            self.lock_in.push(x);
        }
    }

    /// A figure over the settled time, if there is any.
    pub(super) fn once_settled(&self, figure: fn(&Moments) -> f64) -> Option<f64> {
        (self.settled.count > 0).then(|| figure(&self.settled))
    }

    /// The largest distance from `centre` before it was settled, if there was such a time.
    pub(super) fn locking_in(&self, centre: f64) -> Option<f64> {
        (self.lock_in.count > 0).then(|| self.lock_in.largest_distance_from(centre))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(millis: i64) -> Instant<Reference> {
        Instant::from_nanos(millis * 1_000_000)
    }

    #[test]
    fn a_second_in_sync_settles_and_each_break_begins_anew() {
        let mut settling = Settling::default();
        let mut is_settled = |millis, in_sync| settling.is_settled(in_sync, at(millis));
        assert!(!is_settled(0, false) && !is_settled(10, true));
        assert!(!is_settled(1_009, true) && is_settled(1_010, true));
        assert!(!is_settled(1_020, false));
        assert!(!is_settled(1_030, true) && !is_settled(2_029, true));
        assert!(is_settled(2_030, true));
    }

    #[test]
    fn each_part_has_its_own_figures() {
        let mut figure = SettledFigure::default();
        assert_eq!(figure.once_settled(Moments::largest_magnitude), None);
        assert_eq!(figure.locking_in(0.0), None);
        for (x, is_settled) in [(-9.0, false), (4.0, false), (1.0, true), (3.0, true)] {
            figure.push(x, is_settled);
        }
        assert_eq!(figure.all.largest_magnitude(), 9.0);
        assert_eq!(figure.once_settled(Moments::largest_magnitude), Some(3.0));
        assert_eq!(figure.locking_in(0.0), Some(9.0));
        // From -3 to 4. The -9 is only 6 away.
        assert_eq!(figure.locking_in(-3.0), Some(7.0));
    }
}
