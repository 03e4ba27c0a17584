//! The real world: threads, the operating system's clock, and a [`Transport`] to other nodes.
//!
//! [`run()`] drives a [`Node`](coaxle_node::Node) from a [`Setup`], over Zenoh; [`run_over()`] does it
//! over any other transport, such as [`InProcess`]:
//!
//! ```text
//! transport ─▶ stamp, check ─▶ mailboxes ─▶ cycle thread ─▶ outbox ─▶ publish thread ─▶ transport
//!                                       ▲   │    └────▶ records, arrivals ─▶ telemetry thread ─▶ recorder, status
//! transport ─▶ requests ─▶ command thread ─┘ └─▶ command thread ─▶ replies
//! ```
//!
//! Each arrow into or out of the cycle thread is a bounded, wait-free ring: the cycle thread never
//! waits for the network, a disk or a log, and what does not fit is counted. Only [`os`] knows the operating system.
//! Only the module behind [`OverZenoh`] knows Zenoh.
//!
//! The set values of a slave reach drive code in another process by [`shared_memory`];
//! `examples/drive_reader.rs` is such a process: `cargo run -p coaxle-host --example drive_reader`.

mod arrivals;
mod circles;
pub mod cli;
mod commander;
mod commands;
mod counters;
pub mod credentials;
mod cycle;
mod ended;
#[cfg(test)]
mod example;
mod faults;
pub mod fitness;
mod health;
mod hearing;
mod inputs;
mod interrupt;
pub mod machine;
pub mod mailbox;
mod new_file;
mod node_args;
pub mod os;
mod outbox;
mod panics;
mod publisher;
pub mod real_time;
mod reception;
mod recording;
mod row_stream;
mod rows;
mod run;
mod service;
mod session;
pub mod shared_memory;
mod status;
mod synced_file;
mod telemetry;
#[cfg(test)]
mod tests;
mod threads;
mod timing;
#[cfg(test)]
mod toy;
mod trace;
pub mod transport;
mod unseen;
mod waiting;
mod watcher;

pub use arrivals::{ArrivalsTrace, arrivals_beside, exchanges_beside};
pub use commander::Commander;
pub use ended::Ended;
pub use health::Health;
pub use inputs::InputRecord;
pub use interrupt::Interrupt;
pub use machine::Machine;
pub use new_file::{create_new, create_next};
pub use node_args::NodeArgs;
pub use recording::{Attached, Recording};
pub use rows::Rows;
pub use run::{Beside, BuildNode, Outcome, Setup, run, run_over};
pub use shared_memory::SharedMemoryDrive;
pub use synced_file::SyncedFile;
pub use telemetry::{ArrivalRecord, Record, Recorder, fields_of};
pub use trace::Trace;
pub use transport::{Exposure, InProcess, OverZenoh, Transport, ZENOH_RUNTIME, zenoh_config};
pub use watcher::{SeenNode, Watcher};
