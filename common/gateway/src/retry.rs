//! Schedule of reconnections to a lost PLC.

use coaxle_clock::Span;

/// The pauses between attempts to connect to a PLC: short after the first failure, then doubled each
/// time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Retry {
    failures: u32,
}

impl Retry {
    /// The pause after the first failure.
    pub const SHORTEST: Span = Span::from_millis(200);
    /// The greatest pause.
    pub const LONGEST: Span = Span::from_millis(3_200);

    /// Counts a failed attempt, or the end of a connection. Returns the wait before the next one, and
    /// true if it is to be logged: once, and not again before the PLC was connected.
    pub fn failed(&mut self) -> (Span, bool) {
        // Four doublings of 200 ms are 3.2 s.
        let doubled = self.failures.min(4);
        self.failures = self.failures.saturating_add(1);
        (Self::SHORTEST * (1_i64 << doubled), self.failures == 1)
    }

    /// Resets the pauses: the PLC is connected.
    pub const fn succeeded(&mut self) {
        self.failures = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plc_that_is_away_is_named_once_and_tried_at_growing_intervals() {
        let mut retry = Retry::default();
        let said: Vec<_> = (0..7).map(|_| retry.failed()).collect();
        assert_eq!(said[0], (Retry::SHORTEST, true));
        assert_eq!(said[1], (Retry::SHORTEST * 2, false));
        assert_eq!(said[4], (Retry::LONGEST, false));
        assert_eq!(said[6], (Retry::LONGEST, false));
        retry.succeeded();
        assert_eq!(retry.failed(), (Retry::SHORTEST, true));
    }
}
