//! Audit of the nodes of this process: one handle for every part that refuses something or does it.
//!
//! [`note`] takes an [`AuditEntry`] from any thread but that of the cycle. Each node logs it under the target
//! [`LOG`], which no option of the log drops, keeps it for queries, and hands it to its telemetry thread, which
//! publishes and records it. All memory is bounded; a flood of refusals is summed up.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError, Weak};

use coaxle_clock::Instant;
use coaxle_node::audit::{
    AuditDoor, AuditEntry, AuditExcerpt, AuditOutcome, AuditQuery, AuditRecord, AuditTime,
    AuditTrail, KEPT_RECORDS,
};
use coaxle_node::keys::NodeName;
use coaxle_os::machine::{self, Machine};

/// Target of the records in the log.
pub const LOG: &str = "audit";

/// Nodes of this process: one, but in tests.
static NODES: Mutex<Vec<Weak<Mutex<AuditState>>>> = Mutex::new(Vec::new());

/// Notes an entry in the audit of each node of this process, for parts that belong to the process, such as its
/// listeners and its page. Without a node it has no effect.
pub fn note(entry: &AuditEntry) {
    let nodes = lock(&NODES).clone();
    for node in nodes.iter().filter_map(Weak::upgrade) {
        Audit(node).note(entry.clone());
    }
}

/// The audit of a node. Copies share it.
#[derive(Clone)]
pub(crate) struct Audit(Arc<Mutex<AuditState>>);

struct AuditState {
    trail: AuditTrail,
    started: Instant<Machine>,
    /// Records for the telemetry thread. The oldest gives way: its number is missing then.
    fresh: VecDeque<FreshRecord>,
}

/// A record, and the time of the machine's clock at which it was made.
pub(crate) type FreshRecord = (Instant<Machine>, AuditRecord);

impl Audit {
    /// Begins the audit of a run.
    pub(crate) fn new(node: &NodeName, epoch: u64) -> Self {
        let state = AuditState {
            trail: AuditTrail::new(node.clone(), epoch),
            started: machine::now(),
            fresh: VecDeque::with_capacity(KEPT_RECORDS),
        };
        let state = Arc::new(Mutex::new(state));
        let mut nodes = lock(&NODES);
        nodes.retain(|node| node.strong_count() > 0);
        nodes.push(Arc::downgrade(&state));
        drop(nodes);
        watch_links();
        Self(state)
    }

    /// Numbers an entry, and logs it.
    pub(crate) fn note(&self, entry: AuditEntry) {
        lock(&self.0).note(entry);
    }

    /// Answers a query.
    pub(crate) fn excerpt(&self, query: &AuditQuery) -> AuditExcerpt {
        AuditExcerpt::of(&lock(&self.0).trail, query)
    }

    /// Takes the records since the last call, with the sums that are due.
    pub(crate) fn take(&self) -> VecDeque<FreshRecord> {
        let mut state = lock(&self.0);
        state.sum_up();
        std::mem::take(&mut state.fresh)
    }
}

impl AuditState {
    fn note(&mut self, entry: AuditEntry) {
        let at = self.time();
        let fresh = &mut self.fresh;
        // Under the lock, so that the lines are in the order of their numbers.
        (self.trail).note(at.1, entry, &mut |record| keep(fresh, at.0, record));
    }

    fn sum_up(&mut self) {
        let at = self.time();
        let fresh = &mut self.fresh;
        (self.trail).sum_up(at.1, &mut |record| keep(fresh, at.0, record));
    }

    fn time(&self) -> (Instant<Machine>, AuditTime) {
        let now = machine::now();
        let wall_ns = now
            .as_nanos()
            .saturating_add(machine::wall_clock_offset_ns());
        let at = AuditTime {
            wall_us: wall_ns / 1_000,
            since_start: now - self.started,
        };
        (now, at)
    }
}

fn keep(fresh: &mut VecDeque<FreshRecord>, at: Instant<Machine>, record: &AuditRecord) {
    tracing::info!(target: LOG, node = %record.node, "audit {record}");
    if fresh.len() == KEPT_RECORDS {
        fresh.pop_front();
    }
    fresh.push_back((at, record.clone()));
}

/// Notes what the links of this process refuse, from now on.
fn watch_links() {
    static WATCHED: Once = Once::new();
    WATCHED.call_once(|| {
        zenoh_link_tls::on_link_event(|event| {
            let outcome = match event.kind {
                zenoh_link_tls::LinkEventKind::Refused => AuditOutcome::Refused,
                zenoh_link_tls::LinkEventKind::Ended => AuditOutcome::Ended,
            };
            let action = match event.kind {
                zenoh_link_tls::LinkEventKind::Refused => "handshake",
                zenoh_link_tls::LinkEventKind::Ended => "link",
            };
            let entry = AuditEntry::new(AuditDoor::Connection, Some(event.client), action, outcome);
            note(&entry.because(event.reason));
        });
    });
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Each call leaves the state whole: a panic elsewhere does not spoil it.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(door: AuditDoor, n: usize) -> AuditEntry {
        let outcome = AuditOutcome::Refused;
        let entry = AuditEntry::new(door, Some("127.0.0.1:5"), "POST /orders/saw", outcome);
        entry.because(&n.to_string())
    }

    fn pages(records: &VecDeque<FreshRecord>) -> u64 {
        // Other tests of this process may report connections.
        let records = records.iter().map(|(_, record)| record);
        let records = records.filter(|record| record.entry.door == AuditDoor::Page);
        records.map(|record| record.count).sum()
    }

    #[test]
    fn a_flood_takes_no_more_memory_than_a_few_records() {
        let audit = Audit::new(&NodeName::new("saw").unwrap(), 1);
        for n in 0..100_000 {
            audit.note(refusal(AuditDoor::Page, n));
        }
        let noted = pages(&audit.take());
        let mut state = lock(&audit.0);
        // The sum of the current second is not due yet.
        assert!(noted <= 100_000 && state.fresh.capacity() <= 2 * KEPT_RECORDS);
        state.started = Instant::EPOCH;
        state.sum_up();
        assert_eq!(noted + pages(&state.fresh), 100_000);
    }

    #[test]
    fn parts_of_the_process_report_to_each_of_its_nodes() {
        let audit = Audit::new(&NodeName::new("press").unwrap(), 2);
        note(&refusal(AuditDoor::Beacon, 7));
        let query = AuditQuery::newest(1_000);
        let noted = audit.excerpt(&query).records;
        let is_it = |record: &AuditRecord| record.entry == refusal(AuditDoor::Beacon, 7);
        assert!(noted.iter().any(is_it), "{noted:?}");
        assert!(noted.iter().all(|record| record.node.as_str() == "press"));
    }
}
