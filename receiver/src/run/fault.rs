//! What is wrong, as code and text, for status and log.

use std::fmt;

use coaxle_clock::time_sync::{SyncError, SyncWarning};
use coaxle_motion::drive::DriveState;
use serde::Serialize;

use crate::slave::FOLLOWING_ERROR;
use crate::snapshot::{Health, ReceiverSnapshot};

/// An error or a warning.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Fault {
    /// The manual's code, hexadecimal.
    code: String,
    text: String,
}

impl Fault {
    /// What keeps a receiver from doing its work: the drive's trip before all else, for it does not
    /// go away.
    pub(super) fn of(snapshot: &ReceiverSnapshot) -> Option<Self> {
        if snapshot.drive.state == DriveState::Tripped {
            return Some(Self::new(
                FOLLOWING_ERROR,
                "the drive tripped: its following error was too large for too long",
            ));
        }
        if snapshot.health == Health::CycleTimesDoNotFit {
            return Some(Self::cycle_times(snapshot));
        }
        let error = snapshot.master.as_ref()?.error?;
        Some(error.into())
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
