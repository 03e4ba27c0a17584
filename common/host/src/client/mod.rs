//! Access to running nodes from outside: their presence, their statuses, their audit, their promises, commands to them.

mod auditor;
mod commander;
mod promise;
mod search;
mod session;
mod watcher;

pub use auditor::AuditReader;
pub use commander::{Commander, PAGE};
pub use promise::{PromiseReader, PromisedArrival, PromisedAxes};
pub use watcher::{SeenNode, Watcher};
