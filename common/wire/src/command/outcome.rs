//! What becomes of an order, as the cycle says it: plain data.

use coaxle_axis::{Awaits, AxisStatus, SyncPositions};
use coaxle_cam::CamInfo;
use coaxle_slave::{CouplingPhase, Refusal};
use serde::{Deserialize, Serialize};

use super::far::{FarRefusal, FarView};
use super::name::{FarName, SlaveName};
use super::saw::{SawAttempt, SawView};

/// How many of its slaves, or of the nodes it follows, a node names to somebody who asked for another.
pub const MAX_KNOWN: usize = 8;

/// What becomes of an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CommandOutcome {
    /// The slave does as it is told; in a dry run, it would.
    Accepted {
        /// The number of the job; none for what is done already, and in a dry run.
        job: Option<u32>,
        /// What is checked again when the command is due, if it waits.
        awaits: Awaits,
        /// The slave, which has the command.
        slave: SlaveView,
        /// Where master and slave are synchronous, if the command leads to such a pair of positions.
        sync_positions: Option<SyncPositions>,
        /// Its flying saw, if the command is about one.
        saw: Option<SawView>,
    },
    /// The slave does not take the command.
    Refused {
        /// Why.
        refusal: Refusal,
        /// The slave, which goes on with what it was doing.
        slave: SlaveView,
        /// What was tried, if it was to be a flying saw.
        saw: Option<SawAttempt>,
    },
    /// What couples the slave by a cam plate, or did so before an error.
    CamInfo {
        /// What it is like.
        info: CamInfo,
        /// The slave.
        slave: SlaveView,
    },
    /// The far node is as it is told; in a dry run, it would be.
    FarAccepted {
        /// The far node, after that; in a dry run, as it is.
        far: FarView,
    },
    /// The far node does not take the command.
    FarRefused {
        /// Why.
        refusal: FarRefusal,
        /// The far node, which goes on as before.
        far: FarView,
    },
    /// The order did not get as far as a slave or a far node.
    NotTaken(NotTaken),
}

/// Why an order does not get as far as a slave or a far node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotTaken {
    /// The node has no slaves.
    #[error("the node has no slaves")]
    NoSlaves,
    /// It has no slave of that name.
    #[error("slave: received {:?}, expected {}", .received.as_str(), Listed(.known))]
    UnknownSlave {
        /// Who was asked for.
        received: SlaveName,
        /// Who there is.
        known: [Option<SlaveName>; MAX_KNOWN],
    },
    /// It follows no nodes.
    #[error("the node follows no other")]
    NoFarNodes,
    /// It follows no node of that name.
    #[error("far: received {:?}, expected {}", .received.as_str(), Listed(.known))]
    UnknownFarNode {
        /// Who was asked for.
        received: FarName,
        /// Who there is.
        known: [Option<FarName>; MAX_KNOWN],
    },
    /// Too many other orders wait.
    #[error("too many orders wait for the node's next cycle")]
    Busy,
    /// The node's cycles stand still, and it will not be executed any more.
    #[error("the node's cycle did not take the order in time; it will not be executed")]
    NoAnswer,
    /// The node ends.
    #[error("the node ends; the order may have been executed")]
    Stopped,
}

impl NotTaken {
    /// The reason's name on the wire.
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

/// A slave as an answer shows it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct SlaveView {
    /// Its state.
    pub status: AxisStatus,
    /// How far its coupling is; none without one.
    pub coupling: Option<CouplingPhase>,
    /// Its set position, u.
    pub position: f64,
    /// Its set velocity, u/s.
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
