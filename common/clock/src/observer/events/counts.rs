//! Detection of duplicate and late messages by their counts.

use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the counts.
    CountsTuning {
        /// Old counts in a row that are no stragglers any more.
        // Twice as many as are remembered.
        restart_after: u32 = 128,
    }
}

/// Remembers the newest count and which of the 64 counts up to it were seen.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) struct Counts {
    newest: u64,
    seen: u64,
    refused: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::observer) enum News {
    /// Seen for the first time.
    New,
    /// A duplicate, or too old to distinguish from one.
    Old,
    /// Only old counts for a long time: the sender's count began again.
    Restarted,
}

impl Counts {
    pub(in crate::observer) const fn starting_at(count: u64) -> Self {
        Self {
            newest: count,
            seen: 0,
            refused: 0,
        }
    }

    pub(in crate::observer) fn take(&mut self, count: u64) -> News {
        // Wrapping, as counts are what a stranger sends: any difference is a signed one of 64 bits.
        let ahead = count.wrapping_sub(self.newest) as i64;
        if ahead > 0 {
            // A shift by 64 or more would overflow, and nothing of before is remembered then anyway.
            self.seen = if ahead < 64 { self.seen << ahead } else { 0 };
            self.newest = count;
        }
        let back = ahead.min(0).unsigned_abs();
        if back < 64 && self.seen & (1 << back) == 0 {
            self.seen |= 1 << back;
            self.refused = 0;
            return News::New;
        }
        self.refused = self.refused.saturating_add(1);
        // Duplicates of what is remembered are no restart, however many there are.
        if back >= 64 && self.refused >= TUNING.restart_after {
            News::Restarted
        } else {
            News::Old
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_count_is_news_once() {
        let mut counts = Counts::starting_at(100);
        for count in [100, 101, 104, 103, 102, 300, 299] {
            assert_eq!(counts.take(count), News::New, "{count}");
            assert_eq!(counts.take(count), News::Old, "{count}");
        }
        assert_eq!(counts.take(100), News::Old);
    }

    #[test]
    fn a_sender_that_counts_anew_is_noticed() {
        let mut counts = Counts::starting_at(10_000);
        let _ = counts.take(10_000);
        let noticed = (0..1_000).find(|count| counts.take(*count) == News::Restarted);
        // A link that keeps back fewer messages than that does not begin the run again.
        assert!(
            noticed.is_some_and(|after| (100..150).contains(&after)),
            "{noticed:?}"
        );
    }
}
