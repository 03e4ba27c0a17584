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
//! waits for the network, a disk or a log, and what does not fit is counted. Only [`coaxle_os`] knows the operating system.
//! Only the module behind [`OverZenoh`] knows Zenoh.
//!
//! The set values of a slave reach drive code in another process by [`shared_memory`];
//! `examples/drive_reader.rs` is such a process: `cargo run -p coaxle-host --example drive_reader`.

mod announcements;
mod circles;
pub mod cli;
mod commander;
mod commands;
mod counters;
pub mod credentials;
mod cycle;
#[cfg(test)]
mod example;
mod faults;
pub mod fitness;
mod health;
mod inputs;
pub mod mailbox;
mod network;
mod new_file;
mod node_args;
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
pub mod transport;
mod unseen;
mod waiting;
mod watcher;

pub use commander::Commander;
pub use health::Health;
pub use inputs::InputRecord;
pub use network::NetworkArgs;
pub use new_file::{create_new, create_next};
pub use node_args::NodeArgs;
pub use recording::{Attached, Recording};
pub use rows::Rows;
pub use run::{BuildNode, Outcome, Setup, TransportService, run, run_over};
pub use shared_memory::SharedMemoryDrive;
pub use synced_file::SyncedFile;
pub use telemetry::{ArrivalRecord, Record, Recorder};
pub use transport::{Exposure, InProcess, OverZenoh, Transport, ZENOH_RUNTIME, zenoh_config};
pub use watcher::{SeenNode, Watcher};
