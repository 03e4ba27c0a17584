//! The names of states in traces, status and reports.

use coaxle_axis::TravelDirection;
use coaxle_axis::drive::{DriveKind, DriveState};
use coaxle_axis::set_value_guard::GuardState;
use coaxle_remote::{ContinuityState, FilterState};
use serde::{Deserialize, Serialize};

use crate::config::Mode;

macro_rules! named {
    ($(#[$meta:meta])* $name:ident { $($(#[$doc:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
        pub enum $name {
            $($(#[$doc])* #[serde(rename = $text)] $variant,)*
        }

        impl $name {
            /// The name in traces and reports.
            #[must_use]
            pub const fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)*
                }
            }
        }
    };
}

named! {
    /// Mode that calculates the set values.
    StateName {
        /// As received.
        #[default]
        Bypass = "bypass",
        /// Through the PT1 filter.
        Pt1 = "pt1",
        /// Extrapolated in sync mode.
        Sync = "sync",
        /// Extrapolated in time mode.
        Time = "time",
        /// Extrapolated by the phase observer.
        Observer = "observer",
    }
}

named! {
    /// State of the drive.
    DriveStateName {
        /// No power.
        #[default]
        Off = "off",
        /// Power commanded, but not following yet.
        SwitchingOn = "switching-on",
        /// Following the set values.
        Following = "following",
        /// Tripped.
        Tripped = "tripped",
    }
}

named! {
    /// The kind of a drive.
    DriveKindName {
        /// Calculated.
        #[default]
        Simulated = "simulated",
        /// In another process, over shared memory.
        SharedMemory = "shared-memory",
        /// Custom code of the node's builder.
        Own = "own",
    }
}

named! {
    /// Continuity of a far axis's set values with its master.
    ContinuityName {
        /// Equal to the master's.
        #[default]
        Following = "following",
        /// Braked or at rest because no data came for too long.
        Braking = "braking",
        /// Returning to the master.
        Rejoining = "rejoining",
    }
}

named! {
    /// State of a slave's guard, which keeps the limits.
    GuardStateName {
        /// Set values exactly as requested.
        #[default]
        Tracking = "tracking",
        /// Coasting for a cycle with the last acceleration after a request outside the limits, or
        /// stopping after a non-finite one.
        Coasting = "coasting",
        /// On the way back after the limits left it behind.
        CatchingUp = "catching-up",
        /// Request faster than the limits allow, or beyond a software limit.
        Cannot = "cannot",
    }
}

named! {
    /// Direction of travel of an axis measured in increments.
    TravelName {
        /// To larger positions.
        #[default]
        Forward = "forward",
        /// To smaller positions.
        Backward = "backward",
    }
}

named! {
    /// The node's own judgement of its health.
    HealthName {
        /// No data received from the master.
        #[default]
        WaitingForMaster = "waiting-for-master",
        /// The far clock is not known yet.
        StartingUp = "starting-up",
        /// Far node disabled by an order.
        Disabled = "disabled",
        /// In order.
        Ok = "ok",
        /// In order, but no standby could take over.
        NoStandby = "no-standby",
        /// In order, with a standby followed.
        OnStandby = "on-standby",
        /// No new data for too long.
        MasterSilent = "master-silent",
        /// Duplicate sender: a second node has the name of a followed one.
        TwoSenders = "two-senders",
        /// An error is latched.
        Error = "error",
        /// Cycle times that do not fit.
        CycleTimesDoNotFit = "cycle-times-do-not-fit",
        /// Actual cycle time of the master different from the stated one.
        PaceOutOfRange = "pace-out-of-range",
        /// Drive tripped.
        DriveTripped = "drive-tripped",
        /// Slave in error stop.
        SlaveFailed = "slave-failed",
        /// Axis that follows itself across nodes.
        Circle = "circle",
        /// Refused coupling or command from a slave's config.
        CommandRefused = "command-refused",
        /// Slave program that waits for an impossible event, or has waited for too long.
        ProgramBlocked = "program-blocked",
        /// Slave held by its limits away from the position of its coupling.
        SlaveBehind = "slave-behind",
    }
}

impl From<Mode> for StateName {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Bypass => Self::Bypass,
            Mode::Pt1 => Self::Pt1,
            Mode::Sync => Self::Sync,
            Mode::Time => Self::Time,
            Mode::Observer => Self::Observer,
        }
    }
}

impl From<FilterState> for StateName {
    fn from(state: FilterState) -> Self {
        match state {
            FilterState::Bypass => Self::Bypass,
            FilterState::Pt1 => Self::Pt1,
            FilterState::Sync => Self::Sync,
            FilterState::Time => Self::Time,
            FilterState::Observer => Self::Observer,
        }
    }
}

impl From<ContinuityState> for ContinuityName {
    fn from(state: ContinuityState) -> Self {
        match state {
            ContinuityState::Following => Self::Following,
            ContinuityState::Braking => Self::Braking,
            ContinuityState::Rejoining => Self::Rejoining,
        }
    }
}

impl From<GuardState> for GuardStateName {
    fn from(state: GuardState) -> Self {
        match state {
            GuardState::Tracking => Self::Tracking,
            GuardState::Coasting => Self::Coasting,
            GuardState::CatchingUp => Self::CatchingUp,
            GuardState::Cannot => Self::Cannot,
        }
    }
}

impl From<TravelDirection> for TravelName {
    fn from(travel: TravelDirection) -> Self {
        match travel {
            TravelDirection::Forward => Self::Forward,
            TravelDirection::Backward => Self::Backward,
        }
    }
}

impl From<DriveState> for DriveStateName {
    fn from(state: DriveState) -> Self {
        match state {
            DriveState::Off => Self::Off,
            DriveState::SwitchingOn => Self::SwitchingOn,
            DriveState::Following => Self::Following,
            DriveState::Tripped => Self::Tripped,
        }
    }
}

impl From<DriveKind> for DriveKindName {
    fn from(kind: DriveKind) -> Self {
        match kind {
            DriveKind::Simulated => Self::Simulated,
            DriveKind::SharedMemory => Self::SharedMemory,
            DriveKind::Own => Self::Own,
        }
    }
}
