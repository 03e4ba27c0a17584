//! Health of a receiver and of the far nodes that it follows.

use coaxle_clock::time_sync::SyncError;
use serde::{Deserialize, Serialize};

/// Health of a receiver or of a far node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Health {
    /// No data received from the master yet.
    WaitingForMaster,
    /// The far clock is not known yet.
    StartingUp,
    /// Far node disabled by an order.
    Disabled,
    /// In order.
    Ok,
    /// In order, but no standby could take over.
    NoStandby,
    /// In order, with a standby followed.
    OnStandby,
    /// In order, but the time that the node has in common with the own one contradicts what the ways between them leave open.
    ClocksDisagree,
    /// No new data from the master for too long.
    MasterSilent,
    /// Duplicate sender: a second node of the same name publishes the same axes; the first one is
    /// followed.
    TwoSenders,
    /// Latched synchronisation error.
    Error(SyncError),
    /// Cycle time of the master that does not fit the own one: 0x4b56.
    CycleTimesDoNotFit,
    /// Actual cycle time of the master too different from the stated one to be followed: 0x4b56.
    PaceOutOfRange,
    /// Drive tripped.
    DriveTripped,
    /// Slave in error stop.
    SlaveFailed {
        /// Place of the slave in the config.
        slave: usize,
    },
    /// Axis that follows itself across nodes, or would if all axes between were coupled: 0x816f.
    Circle,
    /// Refused coupling or command from a slave's config.
    CommandRefused {
        /// Place of the slave in the config.
        slave: usize,
    },
    /// Slave program that waits for an impossible event, or has waited for too long.
    ProgramBlocked {
        /// Place of the slave in the config.
        slave: usize,
    },
    /// Slave held by its limits away from the position of its coupling.
    SlaveBehind {
        /// Place of the slave in the config.
        slave: usize,
    },
}

impl Health {
    /// Name in status, traces and reports: `ok`, or the fault.
    #[must_use]
    pub const fn name(self) -> HealthName {
        match self {
            Self::WaitingForMaster => HealthName::WaitingForMaster,
            Self::StartingUp => HealthName::StartingUp,
            Self::Disabled => HealthName::Disabled,
            Self::Ok => HealthName::Ok,
            Self::NoStandby => HealthName::NoStandby,
            Self::OnStandby => HealthName::OnStandby,
            Self::ClocksDisagree => HealthName::ClocksDisagree,
            Self::MasterSilent => HealthName::MasterSilent,
            Self::TwoSenders => HealthName::TwoSenders,
            Self::Error(_) => HealthName::Error,
            Self::CycleTimesDoNotFit => HealthName::CycleTimesDoNotFit,
            Self::PaceOutOfRange => HealthName::PaceOutOfRange,
            Self::DriveTripped => HealthName::DriveTripped,
            Self::SlaveFailed { .. } => HealthName::SlaveFailed,
            Self::Circle => HealthName::Circle,
            Self::CommandRefused { .. } => HealthName::CommandRefused,
            Self::ProgramBlocked { .. } => HealthName::ProgramBlocked,
            Self::SlaveBehind { .. } => HealthName::SlaveBehind,
        }
    }

    /// Severity; 0 is in order.
    pub(crate) const fn severity(&self) -> u8 {
        match self {
            Self::Ok => 0,
            // Both states of standbys leave the set values in order.
            Self::NoStandby => 1,
            Self::OnStandby => 2,
            Self::ClocksDisagree => 3,
            Self::StartingUp => 4,
            Self::Disabled => 5,
            Self::WaitingForMaster => 6,
            Self::MasterSilent => 7,
            Self::TwoSenders => 8,
            Self::Error(_) => 9,
            // The worst of a far node: what its frames state cannot be followed at all.
            Self::CycleTimesDoNotFit | Self::PaceOutOfRange => 10,
            Self::SlaveBehind { .. }
            | Self::ProgramBlocked { .. }
            | Self::CommandRefused { .. }
            | Self::Circle
            | Self::SlaveFailed { .. }
            | Self::DriveTripped => 11,
        }
    }
}

/// Kind of a [`Health`], as in the signals: without the details.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HealthName {
    /// No data received from the master.
    #[default]
    WaitingForMaster,
    /// The far clock is not known yet.
    StartingUp,
    /// Far node disabled by an order.
    Disabled,
    /// In order.
    Ok,
    /// In order, but no standby could take over.
    NoStandby,
    /// In order, with a standby followed.
    OnStandby,
    /// In order, but a common time contradicts the ways of messages.
    ClocksDisagree,
    /// No new data for too long.
    MasterSilent,
    /// Duplicate sender: a second node has the name of a followed one.
    TwoSenders,
    /// An error is latched.
    Error,
    /// Cycle times that do not fit.
    CycleTimesDoNotFit,
    /// Actual cycle time of the master different from the stated one.
    PaceOutOfRange,
    /// Drive tripped.
    DriveTripped,
    /// Slave in error stop.
    SlaveFailed,
    /// Axis that follows itself across nodes.
    Circle,
    /// Refused coupling or command from a slave's config.
    CommandRefused,
    /// Slave program that waits for an impossible event, or has waited for too long.
    ProgramBlocked,
    /// Slave held by its limits away from the position of its coupling.
    SlaveBehind,
}

impl HealthName {
    /// Name in status, traces and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::WaitingForMaster => "waiting-for-master",
            Self::StartingUp => "starting-up",
            Self::Disabled => "disabled",
            Self::Ok => "ok",
            Self::NoStandby => "no-standby",
            Self::OnStandby => "on-standby",
            Self::ClocksDisagree => "clocks-disagree",
            Self::MasterSilent => "master-silent",
            Self::TwoSenders => "two-senders",
            Self::Error => "error",
            Self::CycleTimesDoNotFit => "cycle-times-do-not-fit",
            Self::PaceOutOfRange => "pace-out-of-range",
            Self::DriveTripped => "drive-tripped",
            Self::SlaveFailed => "slave-failed",
            Self::Circle => "circle",
            Self::CommandRefused => "command-refused",
            Self::ProgramBlocked => "program-blocked",
            Self::SlaveBehind => "slave-behind",
        }
    }
}
