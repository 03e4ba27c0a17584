//! Violations found.

use crate::invariants::{Broken, Invariant, InvariantViolation, WatchedPart};

/// A cycle, its ideal start, and its distance from the one before: none for the first of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct WatchedCycle {
    pub(super) number: u64,
    pub(super) t_s: f64,
    pub(super) since: Option<u32>,
}

/// Violations by one slave, far axis or far node, or by the receiver: an entry for each invariant.
#[derive(Debug, Default)]
pub(super) struct Found(Vec<OfInvariant>);

#[derive(Debug)]
struct OfInvariant {
    invariant: Invariant,
    first: Broken,
    worst: Broken,
    limit: f64,
    cycles: u64,
}

impl Found {
    pub(super) fn add(
        &mut self,
        cycle: &WatchedCycle,
        invariant: Invariant,
        value: f64,
        limit: f64,
    ) {
        let this = Broken {
            cycle: cycle.number,
            t_s: cycle.t_s,
            value,
        };
        match self.0.iter_mut().find(|known| known.invariant == invariant) {
            Some(known) => {
                known.cycles += 1;
                // By the distance from the limit, as some values are wrong when small: a count that goes back, a time that stands.
                if (value - limit).abs() > (known.worst.value - known.limit).abs() {
                    known.worst = this;
                }
            }
            // A list: there are two dozen invariants, and nearly always none is violated.
            None => self.0.push(OfInvariant {
                invariant,
                first: this,
                worst: this,
                limit,
                cycles: 1,
            }),
        }
    }

    /// Violations by this part.
    pub(super) fn violations(&self, of: WatchedPart) -> impl Iterator<Item = InvariantViolation> {
        self.0.iter().map(move |found| found.violation(of.clone()))
    }
}

impl OfInvariant {
    fn violation(&self, of: WatchedPart) -> InvariantViolation {
        InvariantViolation {
            of,
            invariant: self.invariant,
            first: self.first,
            worst: self.worst,
            limit: self.limit,
            cycles: self.cycles,
        }
    }
}
