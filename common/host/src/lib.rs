//! The real world: the only crate that knows Zenoh, threads and the operating system's clock.
//!
//! [`run()`] drives a [`Node`](coaxle_node::Node) from a [`Setup`]:
//!
//! ```text
//! Zenoh ─▶ stamp, check ─▶ mailboxes ─▶ cycle thread ─▶ outbox ─▶ publish thread ─▶ Zenoh
//!                                   ▲   │    └────▶ records, arrivals ─▶ telemetry thread ─▶ recorder, status
//! Zenoh ─▶ queries ─▶ clerk thread ─┘   └─▶ clerk thread ─▶ replies
//! ```
//!
//! Each arrow into or out of the cycle thread is a bounded, wait-free ring: the cycle thread never
//! waits for the network, a disk or a log, and what does not fit is counted. The crate needs Linux.

mod arrivals;
mod channels;
pub mod cli;
mod commander;
mod commands;
mod counters;
mod cycle;
mod faults;
mod health;
mod link;
pub mod machine;
pub mod mailbox;
mod node_args;
mod outbox;
mod publisher;
pub mod real_time;
mod run;
mod status;
mod telemetry;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod toy;
mod trace;
mod transport;

pub use arrivals::{ArrivalsTrace, arrivals_beside, exchanges_beside};
pub use channels::{Publication, Subscription};
pub use commander::Commander;
pub use health::Health;
pub use machine::Machine;
pub use node_args::NodeArgs;
pub use run::{BuildNode, Ended, Outcome, Setup, run};
pub use telemetry::{ArrivalRecord, Record, Recorder, fields_of};
pub use trace::Trace;
pub use transport::{ZENOH_RUNTIME, zenoh_config};
