//! The receiver node: far axes made local and smooth, driving slaves.
//!
//! ```text
//! per far node: inbox ─▶ which run, newest fresh frame ─▶ far clock ─▶ correction
//!     ─▶ each of its axes: extrapolate ─▶ a master
//! per virtual axis: source ─▶ a master
//!     ─▶ each slave: program ─▶ command ─▶ coupling, life cycle, limits ─▶ drive ─▶ frame, signals
//! ```
//!
//! [`Receiver`] is the node, without any I/O; `pipeline.rs` reads like the picture. `run` (with the
//! feature `host`) runs it in the real world.
//!
//! The set values of a slave go to a simulated drive, to another process on this machine (`drive =
//! { kind = "shared-memory", … }`, docs/DRIVE.md), or to custom drive code: implement
//! [`Drive`](coaxle_axis::drive::Drive), and pass it to [`Receiver::with_drives`].
//! `examples/own_drive.rs` is such a node, from its config to its last cycle: `cargo run -p
//! coaxle-receiver --no-default-features --example own_drive`.

mod arrivals;
mod axes_frame;
mod cam_source;
pub mod config;
mod drives;
mod far;
mod far_axes;
mod health;
mod hold_back;
mod marks;
mod node;
mod own_cycle;
mod pipeline;
mod program;
mod promised;
mod reports;
#[cfg(feature = "host")]
pub mod run;
pub mod signals;
mod slaves;
mod snapshot;
mod virtual_axes;

// The states in its signals are defined where they are calculated.
pub use coaxle_axis::TravelDirection;
pub use coaxle_axis::drive::{DriveKind, DriveState};
pub use coaxle_axis::set_value_guard::GuardState;
pub use coaxle_clock::far_clock::DelaySource;
pub use coaxle_remote::{ContinuityState, FilterMode, FilterState};
pub use config::{DriveConfig, FarChannel, FarConfig, MasterRef, ReceiverConfig, SlaveConfig};
pub use drives::Drives;
pub use health::{Health, HealthName};
pub use node::Receiver;
pub use program::{
    AwaitedPlace, BlockedProgram, InTurn, MasterReaches, Otherwise, Outcome, ProgramSnapshot,
    ProgramState, StepCommand, StepConfig, Trouble, WaitsFor, When,
};
pub use slaves::SlaveNumber;
pub use snapshot::{ReceiverSnapshot, RefusedCommand, SignalRow, SlaveFaults};
