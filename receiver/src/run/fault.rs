//! What is wrong, as code and text, for status and log.

use std::fmt;

use coaxle_clock::time_sync::{SyncError, SyncWarning};
use coaxle_motion::slave::SlaveError;
use serde::Serialize;

use crate::snapshot::{Health, ReceiverSnapshot, SlaveSnapshot};

/// An error or a warning.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Fault {
    /// The manual's code, hexadecimal.
    code: String,
    text: String,
}

impl Fault {
    /// What keeps a receiver from doing its work: a slave's error before all else, for it does not
    /// go away.
    pub(super) fn of(snapshot: &ReceiverSnapshot) -> Option<Self> {
        let slave = |n: usize| snapshot.slaves.get(n)?.as_ref();
        match snapshot.health {
            Health::DriveTripped => Self::tripped(snapshot),
            Health::SlaveFailed { slave: n } => Self::of_slave(slave(n)?),
            Health::CommandRefused { slave: n } => Self::of_refusal(slave(n)?),
            Health::CycleTimesDoNotFit => Some(Self::cycle_times(snapshot)),
            _ => Some(snapshot.master.as_ref()?.error?.into()),
        }
    }

    fn tripped(snapshot: &ReceiverSnapshot) -> Option<Self> {
        let is_trip = |error: &SlaveError| matches!(error, SlaveError::FollowingError { .. });
        let error = snapshot.slaves().filter_map(|slave| slave.error);
        let text = "the drive tripped: its following error was too large for too long";
        let tripped = error.into_iter().find(is_trip)?;
        Some(Self::new(tripped.code(), text))
    }

    /// Why a slave is in error stop.
    pub(super) fn of_slave(slave: &SlaveSnapshot) -> Option<Self> {
        let error = slave.error?;
        Some(Self::named(error.code(), &error.to_string()))
    }

    /// Why a slave refused a command last.
    pub(super) fn of_refusal(slave: &SlaveSnapshot) -> Option<Self> {
        let refusal = slave.refusal?;
        Some(Self::named(refusal.code(), &refusal.to_string()))
    }

    /// A text that begins with its code.
    fn named(code: u32, text: &str) -> Self {
        let after = text.strip_prefix(&format!("{code:#06x}: "));
        Self::new(code, after.unwrap_or(text))
    }

    fn cycle_times(snapshot: &ReceiverSnapshot) -> Self {
        let received = match snapshot.data_cycle_time {
            Some(time) => format!("{} µs", time.span().as_micros_f64()),
            None => "none".to_owned(),
        };
        let text = format!(
            "received frames with a cycle time of {received}, expected a whole multiple or a whole \
             part (up to 1000) of the own one, and the configured data-cycle-time-s, if there is one"
        );
        Self::new(SyncError::WrongParameter.code().into(), &text)
    }

    fn new(code: u32, text: &str) -> Self {
        Self {
            code: format!("0x{code:04x}"),
            text: text.to_owned(),
        }
    }
}

impl From<SyncError> for Fault {
    fn from(error: SyncError) -> Self {
        Self::new(error.code().into(), error.reason())
    }
}

impl From<SyncWarning> for Fault {
    fn from(warning: SyncWarning) -> Self {
        Self::new(warning.code().into(), warning.reason())
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.code, self.text)
    }
}
