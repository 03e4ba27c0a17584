//! The sender node: axes published at the pace of its own clock.
//!
//! [`Sender`] is the node, [`config::SenderConfig`] its config file, [`source`] what moves its
//! axes, and `run` (with the feature `host`) its life in the real world.
//!
//! | PLC name | here |
//! |--|--|
//! | `MC_Power` | [`StepConfig::Enable`](config::StepConfig::Enable) |
//! | `MC_MoveAbsolute` | [`StepConfig::MoveAbsolute`](config::StepConfig::MoveAbsolute) |
//! | `MC_MoveRelative` | [`StepConfig::MoveRelative`](config::StepConfig::MoveRelative) |
//! | `MC_MoveVelocity` | [`StepConfig::Velocity`](config::StepConfig::Velocity) |
//! | `MC_Halt` | [`StepConfig::Halt`](config::StepConfig::Halt) |

pub mod config;
mod node;
mod record;
#[cfg(feature = "host")]
pub mod run;
mod show;
pub mod source;

pub use node::{AxisKinematics, Sender, SenderError, SenderSnapshot, TimeRequestCounters};
pub use record::SenderRecord;
