//! Received messages of a run, by their counts.

/// Received counts of a run, exact for all that are at most 64 behind the newest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sequence {
    first: u64,
    newest: u64,
    /// Bit n: count `newest − n` was received.
    seen: u64,
    distinct: u64,
}

/// Place of a count among those received before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SequencePlace {
    Newest,
    Overtaken,
    Repeated,
    /// Too far behind the newest: an earlier reception is unknown.
    Outdated,
}

impl Sequence {
    /// Starts with a run whose first message has this count.
    pub(super) const fn starting_at(count: u64) -> Self {
        Self {
            first: count,
            newest: count,
            seen: 1,
            distinct: 1,
        }
    }

    /// Takes a count.
    pub(super) fn place(&mut self, count: u64) -> SequencePlace {
        if count > self.newest {
            let ahead = count - self.newest;
            // A shift by the width of the word panics or does nothing, instead of clearing it.
            self.seen = if ahead < 64 { self.seen << ahead } else { 0 } | 1;
            self.newest = count;
            self.distinct += 1;
            return SequencePlace::Newest;
        }
        let behind = self.newest - count;
        // Counts before the first are not expected. Taken in, they would make more distinct ones than expected, and
        // missing would underflow.
        if count < self.first || behind >= 64 {
            return SequencePlace::Outdated;
        }
        let bit = 1 << behind;
        if self.seen & bit != 0 {
            return SequencePlace::Repeated;
        }
        self.seen |= bit;
        self.distinct += 1;
        SequencePlace::Overtaken
    }

    /// Number of counts from the first to the newest.
    pub(super) const fn expected(&self) -> u64 {
        // From 0 to the largest count there is one count more than a u64 holds.
        (self.newest - self.first).saturating_add(1)
    }

    /// Number of those not received.
    pub(super) const fn missing(&self) -> u64 {
        self.expected() - self.distinct
    }
}
