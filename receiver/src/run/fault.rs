//! Faults as code and text, for status and log.

use std::fmt;

use coaxle_axis::drive::DriveFault;
use coaxle_clock::CycleTime;
use coaxle_clock::time_sync::{SyncError, SyncWarning};
use coaxle_slave::{CIRCLE_CODE, SlaveError};
use serde::Serialize;

use crate::far::LARGEST_PPM;
use crate::health::Health;
use crate::program::BlockedProgram;
use crate::snapshot::{ReceiverSnapshot, RefusedCommand, SlaveFaults};

/// An error or a warning.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Fault {
    /// The manual's code, hexadecimal.
    code: String,
    text: String,
}

impl Fault {
    /// Fault that keeps a receiver from its work: a slave's error first, because it stays.
    pub(super) fn of(snapshot: &ReceiverSnapshot) -> Option<Self> {
        match snapshot.health {
            // In the order of the health, so that status and log name one cause.
            Health::DriveTripped => Self::tripped(snapshot),
            Health::SlaveFailed { slave } => Self::of_slave(&snapshot.faults[slave]),
            Health::Circle => Some(Self::circle()),
            Health::CommandRefused { slave } => Self::of_refusal(&snapshot.faults[slave]),
            Health::ProgramBlocked { slave } => Self::of_program(&snapshot.faults[slave]),
            worst => {
                let far = snapshot
                    .far_health
                    .iter()
                    .position(|health| *health == worst)?;
                Self::of_far(snapshot, far)
            }
        }
    }

    /// Fault of a far node.
    pub(super) fn of_far(snapshot: &ReceiverSnapshot, far: usize) -> Option<Self> {
        match snapshot.far_health[far] {
            Health::CycleTimesDoNotFit => Some(Self::cycle_times(snapshot.data_cycle_times[far])),
            Health::PaceOutOfRange => Some(Self::pace(snapshot, far)),
            Health::Error(error) => Some(error.into()),
            _ => None,
        }
    }

    /// Warning of a far node.
    pub(super) fn of_warning(snapshot: &ReceiverSnapshot, far: usize) -> Option<Self> {
        let code = snapshot.signals.far[far].warning;
        let warning = SyncWarning::DriftChangedSignificantly;
        (warning.code() == code).then(|| warning.into())
    }

    /// Fault of a circle. The host knows its axes and adds them to the status.
    fn circle() -> Self {
        let text = "an axis of this node follows itself over other nodes, or would if each axis between were coupled: \
                    the status names the circle";
        Self::new(CIRCLE_CODE, text)
    }

    fn tripped(snapshot: &ReceiverSnapshot) -> Option<Self> {
        let mut errors = snapshot.faults.iter().filter_map(|faults| faults.error);
        // The first slave that tripped: the health names none.
        let fault = errors.find_map(|error| match error {
            SlaveError::Drive(fault) => Some(fault),
            _ => None,
        })?;
        let text = match fault {
            // Without its value, which would change each time.
            DriveFault::FollowingError { .. } => {
                "the drive tripped: its following error was too large for too long".to_owned()
            }
            fault => fault.to_string(),
        };
        Some(Self::new(fault.code(), &text))
    }

    /// Fault of a virtual axis, by its code; 0: none.
    pub(super) fn of_virtual_axis(code: u32) -> Option<Self> {
        let text = "its source gives set values that no axis can have: it stands where it was last";
        (code != 0).then(|| Self::new(code, text))
    }

    /// Fault of a slave in error stop.
    pub(super) fn of_slave(faults: &SlaveFaults) -> Option<Self> {
        let error = faults.error?;
        Some(Self::named(error.code(), &error.to_string()))
    }

    /// Refusal of a slave's last refused command, with its job if refused only when it was due.
    pub(super) fn of_refusal(faults: &SlaveFaults) -> Option<Self> {
        let RefusedCommand { refusal, job } = faults.refusal?;
        let fault = Self::named(refusal.code(), &refusal.to_string());
        Some(match job {
            None => fault,
            Some(job) => Self {
                text: format!("{job}, refused when it was due: {}", fault.text),
                ..fault
            },
        })
    }

    /// Reason why the program of a slave is blocked.
    pub(super) fn of_program(faults: &SlaveFaults) -> Option<Self> {
        let blocked = faults.blocked?;
        Some(Self::new(BlockedProgram::CODE, &blocked.to_string()))
    }

    /// A text that begins with its code.
    fn named(code: u32, text: &str) -> Self {
        // Texts of the slave begin with their code, which has a field of its own here.
        let after = text.strip_prefix(&format!("{code:#06x}: "));
        Self::new(code, after.unwrap_or(text))
    }

    fn cycle_times(received: Option<CycleTime>) -> Self {
        let received = match received {
            Some(time) => format!("{} µs", time.span().as_micros_f64()),
            None => "none".to_owned(),
        };
        let text = format!(
            "received frames with a cycle time of {received}, expected a whole multiple or a whole \
             part (up to 1000) of the own one, and the configured data-cycle-time-s, if there is one"
        );
        Self::new(SyncError::WrongParameter.code().into(), &text)
    }

    /// Without the last digits of its value, which would change each time.
    fn pace(snapshot: &ReceiverSnapshot, far: usize) -> Self {
        let ppm = snapshot.signals.far[far].pace_ppm.unwrap_or(0.0);
        // Fine enough for a bound of 2 500 ppm, and coarse enough for a steady pace to keep its text.
        let hundreds = (ppm / 100.0).round() * 100.0;
        let stated = snapshot.data_cycle_times[far];
        let stated = stated.map_or(0.0, |time| time.span().as_micros_f64());
        let text = format!(
            "received frames at a pace of {hundreds:+} ppm off their cycle-time-us of {stated}, expected at \
             most {LARGEST_PPM} ppm either way: the node's cycles do not last what it says, and it is not followed"
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
