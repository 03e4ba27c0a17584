//! Audit of a node: who was refused what, and who did what, as numbered records.
//!
//! An [`AuditEntry`] is what a part of the node reports. [`AuditTrail`] numbers it, dates it, keeps the newest
//! ones, and sums up floods of refusals. [`AuditQuery`] and [`AuditExcerpt`] travel under
//! `coaxle/<node>/audit`, and so does each [`AuditRecord`] when it is made: `docs/WIRE.md`.

mod excerpt;
mod invalid;
mod record;
mod trail;

pub use excerpt::{AuditExcerpt, AuditQuery, MAX_EXCERPT_BYTES};
pub use invalid::{AUDIT_VERSION, InvalidAudit};
pub use record::{AuditDoor, AuditEntry, AuditOutcome, AuditRecord};
pub use trail::{AuditTime, AuditTrail, KEPT_RECORDS, REFUSALS_PER_SECOND};
