//! Access to running nodes from outside: their presence, their statuses, their audit, commands to them.

mod auditor;
mod commander;
mod watcher;

pub use auditor::AuditReader;
pub use commander::Commander;
pub use watcher::{SeenNode, Watcher};
