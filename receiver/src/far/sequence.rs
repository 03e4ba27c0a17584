//! Which messages of a run have come, by their counts.

/// Which counts of a run have come, exactly, for all that are at most 64 behind the newest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sequence {
    first: u64,
    newest: u64,
    /// Bit n: count `newest − n` has come.
    seen: u64,
    distinct: u64,
}

/// What a count is among those that have come before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Newest,
    Overtaken,
    Repeated,
    /// Nobody knows any more whether it has come before.
    Outdated,
}

impl Sequence {
    /// Of a run whose first message has this count.
    pub(super) const fn starting_at(count: u64) -> Self {
        Self {
            first: count,
            newest: count,
            seen: 1,
            distinct: 1,
        }
    }

    /// Takes a count.
    pub(super) fn place(&mut self, count: u64) -> Place {
        if count > self.newest {
            let ahead = count - self.newest;
            self.seen = if ahead < 64 { self.seen << ahead } else { 0 } | 1;
            self.newest = count;
            self.distinct += 1;
            return Place::Newest;
        }
        let behind = self.newest - count;
        if count < self.first || behind >= 64 {
            return Place::Outdated;
        }
        let bit = 1 << behind;
        if self.seen & bit != 0 {
            return Place::Repeated;
        }
        self.seen |= bit;
        self.distinct += 1;
        Place::Overtaken
    }

    /// From the first to the newest.
    pub(super) const fn expected(&self) -> u64 {
        (self.newest - self.first).saturating_add(1)
    }

    /// How many of those have not come.
    pub(super) const fn missing(&self) -> u64 {
        self.expected() - self.distinct
    }
}
