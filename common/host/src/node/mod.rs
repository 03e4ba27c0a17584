//! A node in real time: [`run()`] and the threads behind it.
//!
//! ```text
//! transport ─▶ stamp, check ─▶ mailboxes ─▶ cycle thread ─▶ outbox ─▶ publish thread ─▶ transport
//!                                       ▲   │    └────▶ records, arrivals ─▶ telemetry thread ─▶ recorder, status
//! transport ─▶ requests ─▶ command thread ─┘ └─▶ command thread ─▶ replies
//! ```
//!
//! Each arrow into or out of the cycle thread is a bounded, wait-free ring: the cycle thread never
//! waits for the network, a disk or a log, and what does not fit is counted.
//!
//! Refusals and actions are noted in the [audit], from any thread but that of the cycle.

mod about;
pub mod audit;
mod circles;
mod commands;
mod counters;
mod cycle;
mod described;
mod faults;
mod mailbox;
mod outbox;
mod panics;
mod publisher;
mod reception;
mod run;
mod service;
mod session;
mod status;
mod telemetry;
#[cfg(test)]
mod tests;
mod threads;
mod timing;
#[cfg(test)]
mod toy;

pub use run::{BuildNode, Outcome, Setup, StartService, TransportService, run, run_over};
pub use status::Health;
pub use telemetry::{ArrivalRecord, Record, Recorder};
