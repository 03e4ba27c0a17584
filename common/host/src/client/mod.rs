//! Access to running nodes from outside: their presence, their statuses, commands to them.

mod commander;
mod session;
mod watcher;

pub use commander::{Commander, PAGE};
pub use watcher::{SeenNode, Watcher};
