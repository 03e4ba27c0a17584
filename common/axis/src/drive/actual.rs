//! Actual values of a drive.

use super::DriveFault;

/// Actual values and state of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Actual {
    /// State of the drive.
    pub state: DriveState,
    /// Actual position, u.
    pub position: f64,
    /// Actual velocity, u/s.
    pub velocity: f64,
    /// Set minus actual position, u; 0 without power.
    pub following_error: f64,
    /// Fault that tripped it; none without a trip.
    pub fault: Option<DriveFault>,
    /// Attachment of its process; none unless it is in another process.
    pub attachment: Option<Attachment>,
}

impl Actual {
    /// Largest actual value, in u or u/s.
    // As the largest set value of an axis: neighbouring doubles are 1.2e-4 apart there.
    pub const LARGEST: f64 = 1e12;

    /// The first value that is not a number between ∓[`LARGEST`](Self::LARGEST), with its name.
    #[must_use]
    pub fn implausible(&self) -> Option<(&'static str, f64)> {
        let plausible = -Self::LARGEST..=Self::LARGEST;
        [
            ("actual position", self.position),
            ("actual velocity", self.velocity),
            ("following error", self.following_error),
        ]
        .into_iter()
        // NaN is in no range.
        .find(|(_, value)| !plausible.contains(value))
    }
}

/// State of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum DriveState {
    /// No power: the drive stands still.
    #[default]
    Off,
    /// Power commanded, but not following yet.
    SwitchingOn,
    /// Following its set position.
    Following,
    /// Failed, for example because the following error was too large for too long. The drive comes
    /// to rest and stays, until reset.
    Tripped,
}

/// Kind of drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum DriveKind {
    /// Calculated.
    #[default]
    Simulated,
    /// In a process that shares memory with this one.
    SharedMemory,
    /// Custom code of the node's builder.
    Own,
}

/// Attachment of a drive's process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attachment {
    /// True if the process is present and alive.
    pub attached: bool,
    /// Cycles since its heartbeat changed; none before the first change.
    pub heartbeat_age: Option<u32>,
}
