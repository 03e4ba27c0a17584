//! The newest records of a run, and the bound on floods of refusals.

use std::collections::VecDeque;

use coaxle_clock::Span;

use super::invalid::AUDIT_VERSION;
use super::record::{AuditDoor, AuditEntry, AuditRecord};
use crate::keys::NodeName;

/// Number of records kept for queries.
// At ten refusals a second at one door, more than a minute and a half; at most some 1.5 MB.
pub const KEPT_RECORDS: usize = 1024;

/// Refusals at one door that have a record each within a second; all further ones share one.
// A person or a program that is refused tries a few times a second; a flood makes hundreds.
pub const REFUSALS_PER_SECOND: u32 = 10;

/// Instant of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AuditTime {
    /// Wall clock, microseconds since 1970.
    pub wall_us: i64,
    /// Time since the start of the run, by a clock that is never set.
    pub since_start: Span,
}

/// Records of a run of a node, numbered from 1 without gaps. Holds the newest [`KEPT_RECORDS`].
#[derive(Clone, Debug)]
pub struct AuditTrail {
    node: NodeName,
    run: String,
    /// Number of the newest record.
    newest: u64,
    kept: VecDeque<AuditRecord>,
    doors: [DoorBudget; AuditDoor::ALL.len()],
}

/// Refusals at one door within the current second.
#[derive(Clone, Debug, Default)]
struct DoorBudget {
    second: i64,
    recorded: u32,
    /// Refusals without a record of their own, and the last of them.
    summed: u64,
    last: Option<AuditEntry>,
}

impl AuditTrail {
    /// Begins the run with this epoch.
    #[must_use]
    pub fn new(node: NodeName, epoch: u64) -> Self {
        Self {
            node,
            run: format!("{epoch:016x}"),
            newest: 0,
            kept: VecDeque::with_capacity(KEPT_RECORDS),
            doors: std::array::from_fn(|_| DoorBudget::default()),
        }
    }

    /// The node.
    #[must_use]
    pub const fn node(&self) -> &NodeName {
        &self.node
    }

    /// The run, as in records.
    #[must_use]
    pub fn run(&self) -> &str {
        &self.run
    }

    /// Number of the newest record; 0 without any.
    #[must_use]
    pub const fn newest(&self) -> u64 {
        self.newest
    }

    /// Adds an entry. `out` gets each record that is made by this: none for a refusal in a flood, which is only
    /// counted, and the sum of the last second before the first entry of the next.
    pub fn note(&mut self, at: AuditTime, entry: AuditEntry, out: &mut dyn FnMut(&AuditRecord)) {
        self.sum_up(at, out);
        if entry.outcome.is_refusal() {
            let budget = &mut self.doors[entry.door as usize];
            if budget.recorded >= REFUSALS_PER_SECOND {
                budget.summed += 1;
                budget.last = Some(entry);
                return;
            }
            budget.recorded += 1;
        }
        self.push(at, entry, 1, out);
    }

    /// Makes the records of refusals of past seconds that had none of their own.
    pub fn sum_up(&mut self, at: AuditTime, out: &mut dyn FnMut(&AuditRecord)) {
        let second = at.since_start.as_nanos().div_euclid(NANOS_PER_SECOND);
        for door in 0..self.doors.len() {
            let budget = &mut self.doors[door];
            if budget.second == second {
                continue;
            }
            budget.second = second;
            budget.recorded = 0;
            let summed = std::mem::take(&mut budget.summed);
            if let Some(last) = budget.last.take() {
                self.push(at, last, summed, out);
            }
        }
    }

    /// Returns the kept records after the one of this number, the oldest first.
    pub fn after(&self, number: u64) -> impl DoubleEndedIterator<Item = &AuditRecord> {
        self.kept.iter().filter(move |kept| kept.number > number)
    }

    fn push(
        &mut self,
        at: AuditTime,
        entry: AuditEntry,
        count: u64,
        out: &mut dyn FnMut(&AuditRecord),
    ) {
        self.newest += 1;
        let record = AuditRecord {
            version: AUDIT_VERSION,
            node: self.node.clone(),
            run: self.run.clone(),
            number: self.newest,
            at_us: at.wall_us,
            entry,
            count,
        };
        out(&record);
        if self.kept.len() == KEPT_RECORDS {
            self.kept.pop_front();
        }
        self.kept.push_back(record);
    }
}

const NANOS_PER_SECOND: i64 = 1_000_000_000;

#[cfg(test)]
mod tests {
    use super::super::AuditOutcome;
    use super::*;

    fn at(millis: i64) -> AuditTime {
        AuditTime {
            wall_us: 1_790_000_000_000_000 + 1_000 * millis,
            since_start: Span::from_millis(millis),
        }
    }

    fn trail() -> AuditTrail {
        AuditTrail::new(NodeName::new("saw").unwrap(), 0xf00d)
    }

    fn entry(door: AuditDoor, outcome: AuditOutcome) -> AuditEntry {
        AuditEntry::new(door, Some("10.0.0.7:40000"), "handshake", outcome)
    }

    /// Notes an entry, and returns number and count of the records made by it.
    fn noted(trail: &mut AuditTrail, millis: i64, entry: AuditEntry) -> Vec<(u64, u64)> {
        let mut made = Vec::new();
        trail.note(at(millis), entry, &mut |record| {
            made.push((record.number, record.count));
        });
        made
    }

    #[test]
    fn a_flood_of_refusals_is_ten_records_and_one_sum_a_second() {
        let mut trail = trail();
        let flood = entry(AuditDoor::Connection, AuditOutcome::Refused);
        let mut made = Vec::new();
        for n in 0..7_300 {
            made.extend(noted(&mut trail, n / 10, flood.clone()));
        }
        let each = (1..=10).map(|number| (number, 1));
        assert_eq!(made, each.collect::<Vec<_>>());
        // Another door has a budget of its own, and what is done is never summed up.
        let refused = entry(AuditDoor::Order, AuditOutcome::Refused);
        assert_eq!(noted(&mut trail, 750, refused), [(11, 1)]);
        for number in 12..40 {
            let done = entry(AuditDoor::Order, AuditOutcome::Accepted);
            assert_eq!(noted(&mut trail, 760, done), [(number, 1)]);
        }
        // The sum comes with the next entry, or when it is asked for.
        let mut silent = trail.clone();
        assert_eq!(noted(&mut trail, 1_000, flood), [(40, 7_290), (41, 1)]);
        let mut sums = Vec::new();
        for millis in [999, 1_000, 1_500, 2_000] {
            silent.sum_up(at(millis), &mut |record| sums.push((millis, record.count)));
        }
        assert_eq!(sums, [(1_000, 7_290)]);
    }

    #[test]
    fn the_newest_are_kept_and_none_is_numbered_twice() {
        let mut trail = trail();
        let done = entry(AuditDoor::Order, AuditOutcome::Accepted);
        for n in 0..3_000 {
            noted(&mut trail, n, done.clone());
        }
        let numbers: Vec<_> = trail.after(0).map(|record| record.number).collect();
        let newest = 3_000 - KEPT_RECORDS as u64 + 1..=3_000;
        assert_eq!(numbers, newest.collect::<Vec<_>>());
        assert_eq!(trail.after(2_998).count(), 2);
        assert_eq!((trail.newest(), trail.run()), (3_000, "000000000000f00d"));
    }
}
