//! The words of states, as traces, status and reports spell them.

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
            /// The name, as traces and reports spell it.
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
    /// The mode that makes set values.
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
    /// The drive's state.
    DriveStateName {
        /// No power.
        #[default]
        Off = "off",
        /// Told to have power, and not following yet.
        SwitchingOn = "switching-on",
        /// It follows.
        Following = "following",
        /// It tripped.
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
        /// Code of whoever built the node.
        Own = "own",
    }
}

named! {
    /// Whether the set values of a far axis are its master's.
    ContinuityName {
        /// They are.
        #[default]
        Following = "following",
        /// Nothing has come for too long: it is braked, or at rest.
        Braking = "braking",
        /// It is brought back to its master.
        Rejoining = "rejoining",
    }
}

named! {
    /// Whether the set values of a slave are what is asked for.
    GuardStateName {
        /// They are, to the bit.
        #[default]
        Tracking = "tracking",
        /// For a cycle it goes on with its acceleration, after something that its limits do not admit; or it comes
        /// to a stop, after something that is no number.
        Coasting = "coasting",
        /// Its limits have left it behind, and it is on its way.
        CatchingUp = "catching-up",
        /// What is asked for is faster than it can be, or beyond a software limit.
        Cannot = "cannot",
    }
}

named! {
    /// Where an axis goes that is measured in increments.
    TravelName {
        /// To larger positions.
        #[default]
        Forward = "forward",
        /// To smaller ones.
        Backward = "backward",
    }
}

named! {
    /// The node's own opinion of itself.
    HealthName {
        /// Nothing heard of the master.
        #[default]
        WaitingForMaster = "waiting-for-master",
        /// The far clock is not known yet.
        StartingUp = "starting-up",
        /// A far node is disabled, by an order.
        Disabled = "disabled",
        /// All is well.
        Ok = "ok",
        /// All is well, but none of the standbys could take over.
        NoStandby = "no-standby",
        /// A standby is followed, and all is well with it.
        OnStandby = "on-standby",
        /// Nothing new for too long.
        MasterSilent = "master-silent",
        /// A second node has the name of one that is followed.
        TwoSenders = "two-senders",
        /// An error is latched.
        Error = "error",
        /// The cycle times do not fit.
        CycleTimesDoNotFit = "cycle-times-do-not-fit",
        /// The master's cycles last otherwise than it says.
        PaceOutOfRange = "pace-out-of-range",
        /// A drive tripped.
        DriveTripped = "drive-tripped",
        /// A slave is in error stop.
        SlaveFailed = "slave-failed",
        /// An axis follows itself over other nodes.
        Circle = "circle",
        /// What its config has a slave do was refused.
        CommandRefused = "command-refused",
        /// A slave's program waits for what cannot come, or has waited for too long.
        ProgramBlocked = "program-blocked",
        /// The limits of a slave have left it away from where its coupling has it.
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
