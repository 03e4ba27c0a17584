//! The sender node: axes published at the pace of its own clock.
//!
//! [`Sender`] is the node, [`config::SenderConfig`] its config file, `run` (with the feature `host`)
//! its life in the real world. What moves its axes, and what moves are called in a PLC, is in
//! [`coaxle_source`].

pub mod config;
mod node;
#[cfg(feature = "host")]
pub mod run;
pub mod signals;
mod snapshot;

pub use node::{Sender, SenderError};
pub use snapshot::{SenderRow, SenderSnapshot};
