//! Audit of the server: who commanded what, and who was refused, in the log as nodes have it.

use std::sync::{Mutex, PoisonError};

use coaxle_clock::Instant;
use coaxle_host::node::audit::LOG;
use coaxle_node::audit::{AuditDoor, AuditEntry, AuditOutcome, AuditTime, AuditTrail};
use coaxle_node::keys::NodeName;
use coaxle_os::machine::{self, Machine};

use crate::rights::OpcuaClient;

/// Numbered records of the calls of clients.
pub(super) struct CallAudit {
    trail: Mutex<AuditTrail>,
    started: Instant<Machine>,
}

impl CallAudit {
    pub(super) fn new(server: &NodeName) -> Self {
        let run = wall_us().unsigned_abs();
        Self {
            trail: Mutex::new(AuditTrail::new(server.clone(), run)),
            started: machine::now(),
        }
    }

    /// Writes the record of a call.
    pub(super) fn note(
        &self,
        client: &OpcuaClient,
        command: &str,
        object: &str,
        outcome: AuditOutcome,
        reason: &str,
    ) {
        let actor = client.to_string();
        let mut entry =
            AuditEntry::new(AuditDoor::Order, Some(&actor), command, outcome).on(object);
        if !reason.is_empty() {
            entry = entry.because(reason);
        }
        let at = AuditTime {
            wall_us: wall_us(),
            since_start: machine::now() - self.started,
        };
        // Each call leaves the trail whole: a panic elsewhere does not spoil it.
        let mut trail = self.trail.lock().unwrap_or_else(PoisonError::into_inner);
        trail.note(at, entry, &mut |record| {
            tracing::info!(target: LOG, node = %record.node, "audit {record}");
        });
    }
}

fn wall_us() -> i64 {
    let now = machine::now().as_nanos();
    now.saturating_add(machine::wall_clock_offset_ns()) / 1_000
}
