//! Outcome of an order in the cycle: plain data.

use coaxle_axis::{Awaits, AxisStatus, SyncPositions};
use coaxle_cam::CamInfo;
use coaxle_slave::{CouplingPhase, Refusal};
use serde::{Deserialize, Serialize};

use super::far::{FarRefusal, FarView};
use super::name::{FarName, SlaveName};
use super::saw::{SawAttempt, SawView};

/// Greatest number of slaves or far nodes that a node lists when an order names an unknown one.
pub const MAX_KNOWN: usize = 8;

/// Outcome of an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CommandOutcome {
    /// The slave accepts the command; in a dry run: would accept it.
    Accepted {
        /// Number of the job; none for a command that is done already, and in a dry run.
        job: Option<u32>,
        /// Conditions checked again when a waiting command is due.
        awaits: Awaits,
        /// Slave, which has the command.
        slave: SlaveView,
        /// Positions at which master and slave are synchronous, if the command leads to such a pair.
        sync_positions: Option<SyncPositions>,
        /// Flying saw, if the command is about one.
        saw: Option<SawView>,
    },
    /// The slave refuses the command.
    Refused {
        /// Reason of the refusal.
        refusal: Refusal,
        /// Slave, which continues unchanged.
        slave: SlaveView,
        /// Attempted plan, if the command was for a flying saw.
        saw: Option<SawAttempt>,
    },
    /// Coupling of the slave by a cam plate, or the last one before an error.
    CamInfo {
        /// State of the coupling.
        info: CamInfo,
        /// The slave.
        slave: SlaveView,
    },
    /// The far node accepts the command; in a dry run: would accept it.
    FarAccepted {
        /// Far node after the command; in a dry run, before it.
        far: FarView,
    },
    /// The far node refuses the command.
    FarRefused {
        /// Reason of the refusal.
        refusal: FarRefusal,
        /// Far node, which continues unchanged.
        far: FarView,
    },
    /// The order did not reach a slave or a far node.
    NotTaken(NotTaken),
}

/// Reason why an order does not reach a slave or a far node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotTaken {
    /// The node has no slaves.
    #[error("the node has no slaves")]
    NoSlaves,
    /// The node has no slave of that name.
    #[error("slave: received {:?}, expected {}", .received.as_str(), Listed(.known))]
    UnknownSlave {
        /// Name in the order.
        received: SlaveName,
        /// Names of its slaves.
        known: [Option<SlaveName>; MAX_KNOWN],
    },
    /// The node follows no other nodes.
    #[error("the node follows no other")]
    NoFarNodes,
    /// The node follows no node of that name.
    #[error("far: received {:?}, expected {}", .received.as_str(), Listed(.known))]
    UnknownFarNode {
        /// Name in the order.
        received: FarName,
        /// Names of its far nodes.
        known: [Option<FarName>; MAX_KNOWN],
    },
    /// Too many other orders wait.
    #[error("too many orders wait for the node's next cycle")]
    Busy,
    /// The node's cycles stand still, and the order will not be executed any more.
    #[error("the node's cycle did not take the order in time; it will not be executed")]
    NoAnswer,
    /// The node ends.
    #[error("the node ends; the order may have been executed")]
    Stopped,
}

impl NotTaken {
    /// Returns the name of the reason on the wire.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::NoSlaves => "no-slaves",
            Self::UnknownSlave { .. } => "unknown-slave",
            Self::NoFarNodes => "no-far-nodes",
            Self::UnknownFarNode { .. } => "unknown-far-node",
            Self::Busy => "busy",
            Self::NoAnswer => "no-answer",
            Self::Stopped => "stopped",
        }
    }
}

/// State of a slave in a response.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct SlaveView {
    /// PLCopen state of the slave.
    pub status: AxisStatus,
    /// Phase of its coupling; none without one.
    pub coupling: Option<CouplingPhase>,
    /// Set position, u.
    pub position: f64,
    /// Set velocity, u/s.
    pub velocity: f64,
}

/// Names with commas between.
struct Listed<'a, T>(&'a [Option<T>]);

impl<T: std::fmt::Display> std::fmt::Display for Listed<'_, T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (k, name) in self.0.iter().flatten().enumerate() {
            write!(f, "{}{name}", if k == 0 { "" } else { ", " })?;
        }
        Ok(())
    }
}
