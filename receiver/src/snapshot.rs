//! What a receiver shows of itself after each cycle: plain data.

use coaxle_clock::delay::DelayOutput;
use coaxle_clock::observer::ObserverOutput;
use coaxle_clock::time_sync::{SyncError, SyncWarning};
use coaxle_clock::{CycleIndex, CycleTime, Instant, Local, Remote, Seconds};
use coaxle_motion::axis::AxisStatus;
use coaxle_motion::drive::DriveState;
use coaxle_motion::profile::Kinematics;
use coaxle_motion::remote::FilterState;
use coaxle_motion::slave::{CouplingPhase, Refusal, SlaveError};
use coaxle_node::{AnsweringCounters, RejectionCounters};

use crate::config::MOST_SLAVES;
use crate::program::ProgramSnapshot;
use crate::record::HealthName;

/// A receiver after a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverSnapshot {
    /// Cycles since the start, skipped ones counted.
    pub cycle: u64,
    /// When the cycle ideally started.
    pub ideal_start: Instant<Local>,
    /// When it really did.
    pub woke: Instant<Local>,
    /// Cycles skipped so far.
    pub overruns: u64,
    /// Whether all is well.
    pub health: Health,
    /// What became of the messages.
    pub counters: Counters,
    /// The sender's nominal cycle time, as its frames say; none before the first message.
    pub data_cycle_time: Option<CycleTime>,
    /// The far axis; none before the first message.
    pub master: Option<MasterSnapshot>,
    /// The phase observer; none in other modes, and before the first message.
    pub observer: Option<ObserverOutput>,
    /// The constant part of the delay; likewise.
    pub delay: Option<DelayOutput>,
    /// What became of questions about the node's own clock.
    pub questions: AnsweringCounters,
    /// The slaves, in the order of the config.
    pub slaves: [Option<SlaveSnapshot>; MOST_SLAVES],
}

impl ReceiverSnapshot {
    /// The slaves there are.
    pub fn slaves(&self) -> impl Iterator<Item = &SlaveSnapshot> {
        self.slaves.iter().flatten()
    }

    /// The first slave's set values, as given to the drive; none until it is coupled.
    #[must_use]
    pub fn slave(&self) -> Option<Kinematics> {
        self.slaves().next()?.set
    }

    /// The first slave's drive.
    #[must_use]
    pub fn drive(&self) -> DriveSnapshot {
        self.slaves()
            .next()
            .map_or_else(DriveSnapshot::default, |slave| slave.drive)
    }
}

/// A slave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlaveSnapshot {
    /// Its axis id.
    pub id: u32,
    /// Its state in the PLCopen diagram.
    pub status: AxisStatus,
    /// How far its coupling is; none without one.
    pub phase: Option<CouplingPhase>,
    /// Why it is in error stop.
    pub error: Option<SlaveError>,
    /// Why a command was refused last.
    pub refusal: Option<Refusal>,
    /// Its set values, as given to the drive; none until it is coupled, if it only follows its gear.
    pub set: Option<Kinematics>,
    /// Its drive.
    pub drive: DriveSnapshot,
    /// Its program.
    pub program: Option<ProgramSnapshot>,
    /// Cuts done by its tool, or by steps of its program.
    pub cuts: u64,
}

/// The far axis, received and corrected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MasterSnapshot {
    /// The sender's run.
    pub epoch: u64,
    /// The cycle index in the input image.
    pub index: CycleIndex,
    /// The sender's cycle count in the input image.
    pub count: u64,
    /// Own cycles since the input image was renewed.
    pub age_cycles: u32,
    /// As received.
    pub received: Kinematics,
    /// As corrected.
    pub corrected: Kinematics,
    /// The instant of the sender's ideal time that the corrected values stand for; none where a
    /// filter smears it.
    pub far_time: Option<Instant<Remote>>,
    /// The mode that made the set values.
    pub state: FilterState,
    /// Whether the far clock is known.
    pub synced: bool,
    /// The error that is latched.
    pub error: Option<SyncError>,
    /// The warning.
    pub warning: Option<SyncWarning>,
    /// Beats since the start.
    pub beats: u32,
    /// The correction that moved the set values.
    pub correction_time: Option<Seconds>,
    /// Estimated drift of the sender's clock against the own one, ppm.
    pub drift_ppm: f64,
}

/// A drive, in the positions of its axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveSnapshot {
    /// Off, following or tripped.
    pub state: DriveState,
    /// Actual position, u.
    pub position: f64,
    /// Actual velocity, u/s.
    pub velocity: f64,
    /// Set minus actual position, u.
    pub following_error: f64,
}

/// What became of the messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Accepted frames, whatever became of them afterwards.
    pub received: u64,
    /// Missing by the sender's count (skipped by the sender, or lost on the way).
    pub lost: u64,
    /// Came a second time.
    pub duplicates: u64,
    /// Overtaken by a newer one.
    pub late: u64,
    /// Too old to use.
    pub stale: u64,
    /// Dropped because more came in one cycle than the inbox holds.
    pub overflow: u64,
    /// Times the sender started anew.
    pub restarts: u64,
    /// Refused frames, by reason.
    pub rejected: RejectionCounters,
}

/// Whether all is well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Health {
    /// Nothing has been heard of the master yet.
    WaitingForMaster,
    /// The far clock is not known yet.
    StartingUp,
    /// All is well.
    Ok,
    /// Nothing new from the master for too long.
    MasterSilent,
    /// A synchronisation error is latched.
    Error(SyncError),
    /// The master's cycle time does not fit the own one: 0x4b56.
    CycleTimesDoNotFit,
    /// A drive tripped.
    DriveTripped,
    /// A slave is in error stop.
    SlaveFailed {
        /// Its place in the config.
        slave: usize,
    },
    /// What its config has a slave do was refused.
    CommandRefused {
        /// Its place in the config.
        slave: usize,
    },
}

impl Health {
    /// As status, traces and reports spell it: `ok`, or what is wrong.
    #[must_use]
    pub const fn name(self) -> HealthName {
        match self {
            Self::WaitingForMaster => HealthName::WaitingForMaster,
            Self::StartingUp => HealthName::StartingUp,
            Self::Ok => HealthName::Ok,
            Self::MasterSilent => HealthName::MasterSilent,
            Self::Error(_) => HealthName::Error,
            Self::CycleTimesDoNotFit => HealthName::CycleTimesDoNotFit,
            Self::DriveTripped => HealthName::DriveTripped,
            Self::SlaveFailed { .. } => HealthName::SlaveFailed,
            Self::CommandRefused { .. } => HealthName::CommandRefused,
        }
    }
}
