//! Access to running nodes from outside: their presence, their statuses, their audit, commands to them.

mod auditor;
mod commander;
mod search;
mod session;
mod watcher;

pub use auditor::AuditReader;
pub use commander::{Commander, PAGE};
pub use watcher::{SeenNode, Watcher};
