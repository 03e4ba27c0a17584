//! What a drive says of itself.

use super::DriveFault;

/// Where a drive is, and how it does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Actual {
    /// Whether it moves.
    pub state: DriveState,
    /// Actual position, u.
    pub position: f64,
    /// Actual velocity, u/s.
    pub velocity: f64,
    /// Set minus actual position, u; 0 without power.
    pub following_error: f64,
    /// Why it tripped; none if it has not.
    pub fault: Option<DriveFault>,
    /// How it does with the process that it is in; none if it is in none but this.
    pub attachment: Option<Attachment>,
}

impl Actual {
    /// No actual value is larger than that, in u or u/s.
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
        .find(|(_, value)| !plausible.contains(value))
    }
}

/// Whether a drive moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DriveState {
    /// No power: it stands where it stands.
    #[default]
    Off,
    /// It was told to have power, and does not follow yet.
    SwitchingOn,
    /// It follows its set position.
    Following,
    /// It has failed, say because the following error was too large for too long. It comes to rest and
    /// stays, until reset.
    Tripped,
}

/// What kind of drive it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DriveKind {
    /// Calculated.
    #[default]
    Simulated,
    /// In a process that shares memory with this one.
    SharedMemory,
    /// Code of whoever built the node.
    Own,
}

/// How a drive does with the process that it is in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attachment {
    /// The process is there, and lives.
    pub attached: bool,
    /// Cycles since its heartbeat changed; none before it did.
    pub heartbeat_age: Option<u32>,
}
