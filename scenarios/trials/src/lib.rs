//! The real path tried: real nodes, real processes, real Zenoh.
//!
//! From the top down:
//!
//! * [`processes`] plays a scenario as processes of this machine: a [`Stage`](coaxle_lab::stage::Stage) of the lab;
//! * [`recording`] records how messages between such processes arrive;
//! * [`mod@bench`] measures the lateness of cycles and the latency of samples;
//! * [`scale`] measures the cost of more receivers, senders and axes;
//! * [`conform`] judges another implementation's sender or receiver by docs/WIRE.md;
//! * [`Bar`] shows progress, and reacts to Ctrl-C.
//!
//! Results depend on the machine: tests check only that it works.

mod bar;
pub mod bench;
pub mod conform;
pub mod processes;
pub mod recording;
pub mod scale;

pub use bar::Bar;
