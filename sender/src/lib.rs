//! The sender node: axes published in the cycles of its own clock.
//!
//! [`Sender`] is the node, [`config::SenderConfig`] its config file, and `run` (with the feature
//! `host`) runs it in the real world. The sources of its axes, and the PLC names of motions, are in
//! [`coaxle_source`].

pub mod config;
mod followers;
mod node;
mod plans;
#[cfg(feature = "host")]
pub mod run;
pub mod signals;
mod snapshot;
mod stated_delay;

pub use followers::FollowerCondition;
pub use node::Sender;
pub use snapshot::{SenderRow, SenderSnapshot};
