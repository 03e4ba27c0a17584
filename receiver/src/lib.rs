//! The receiver node: a far axis made local and smooth, driving slaves.
//!
//! ```text
//! inbox ─▶ newest fresh sample ─▶ AxisSync ─▶ the far axis
//!     ─▶ each slave: program ─▶ command ─▶ coupling, life cycle, limits ─▶ drive ─▶ frame, snapshot
//! ```
//!
//! [`Receiver`] is the node, without any I/O; `pipeline.rs` reads like the picture. `run` (with the
//! feature `host`) is its life in the real world.

mod arrivals;
pub mod config;
mod delay;
mod far_clock;
mod inbox;
mod node;
mod pipeline;
mod program;
mod record;
#[cfg(feature = "host")]
pub mod run;
mod slaves;
mod snapshot;

pub use config::{DelayConfig, MasterConfig, Mode, ReceiverConfig, SlaveConfig};
pub use node::{Receiver, ReceiverError};
pub use program::{ProgramSnapshot, ProgramState, StepConfig, When, WrongStep};
pub use record::{DriveStateName, HealthName, ReceiverRecord, SlaveRecord, StateName};
pub use slaves::{SlaveNumber, WrongSlave};
pub use snapshot::{
    Counters, DriveSnapshot, Health, MasterSnapshot, ReceiverSnapshot, SlaveSnapshot,
};
