//! Growth of a running node's memory: every queue of a node is bounded.

use anyhow::ensure;
use coaxle_clock::{Instant, Span};
use coaxle_os::machine::Machine;

/// Time after which a node has allocated all it needs.
// A receiver knows the clocks that it follows after some six seconds.
const SETTLED: Span = Span::from_secs(10);
/// Interval of checks.
const EVERY: Span = Span::from_secs(1);
/// Allowed growth, bytes: the allocator rounds, and a new peer takes room.
// Frames of 100 axes at 1 kHz, 9030 bytes each, exceed it within two seconds if a queue keeps them all.
const MOST_GROWTH: u64 = 16 << 20;

/// Watches the resident memory of one process.
#[derive(Clone, Copy, Debug)]
pub(super) struct MemoryWatch {
    started: Instant<Machine>,
    looked: Instant<Machine>,
    /// Memory when settled, bytes.
    settled: Option<u64>,
}

impl MemoryWatch {
    pub(super) const fn new(started: Instant<Machine>) -> Self {
        Self {
            started,
            looked: started,
            settled: None,
        }
    }

    /// True if the next check is due.
    pub(super) fn is_due(&self, now: Instant<Machine>) -> bool {
        now - self.looked >= EVERY && now - self.started >= SETTLED
    }

    /// Checks the resident memory of the process, bytes.
    pub(super) fn look(&mut self, now: Instant<Machine>, resident: u64) -> anyhow::Result<()> {
        self.looked = now;
        // Compared with the first reading, not with the previous one: a slow leak would pass each step.
        let settled = *self.settled.get_or_insert(resident);
        let (before, after) = (mebibytes(settled), mebibytes(resident));
        ensure!(
            // Only growth is wrong: memory that was given back to the system is fine.
            resident <= settled.saturating_add(MOST_GROWTH),
            "has grown from {before} to {after} MiB of memory since it settled, expected at most {} MiB more",
            mebibytes(MOST_GROWTH)
        );
        Ok(())
    }
}

const fn mebibytes(bytes: u64) -> u64 {
    bytes >> 20
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_at_the_start_is_no_growth_and_what_comes_later_is() {
        let start = Instant::EPOCH;
        let at = |seconds| start + Span::from_secs(seconds);
        let mut watch = MemoryWatch::new(start);
        assert!(!watch.is_due(at(9)));
        assert!(watch.is_due(at(10)));
        watch.look(at(10), 50 << 20).expect("the first look");
        assert!(!watch.is_due(at(10)));
        // 16 MiB more, the very bound.
        watch.look(at(11), 66 << 20).expect("within the bound");
        let grown = watch.look(at(12), (66 << 20) + 1).expect_err("too much");
        assert!(grown.to_string().contains("from 50 to 66 MiB"), "{grown}");
    }
}
