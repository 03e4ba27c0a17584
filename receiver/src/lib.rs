//! The receiver node: a far axis made local and smooth, driving a slave.
//!
//! ```text
//! inbox ─▶ newest fresh sample ─▶ AxisSync ─▶ gear ─▶ drive ─▶ slave axis, snapshot
//! ```
//!
//! [`Receiver`] is the node, without any I/O; `pipeline.rs` reads like the picture. `run` (with the
//! feature `host`) is its life in the real world.

pub mod config;
mod delay;
mod far_clock;
mod inbox;
mod node;
mod pipeline;
mod record;
#[cfg(feature = "host")]
pub mod run;
mod slave;
mod snapshot;

pub use config::{DelayConfig, MasterConfig, Mode, ReceiverConfig};
pub use node::{Receiver, ReceiverError};
pub use record::{DriveStateName, HealthName, ReceiverRecord, StateName};
pub use snapshot::{Counters, DriveSnapshot, Health, MasterSnapshot, ReceiverSnapshot};
