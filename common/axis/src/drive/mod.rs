//! Drives that follow the set values of an axis.
//!
//! A [`Drive`] takes set values once per cycle and reports its position and state. Its axis knows
//! nothing else about it: a custom drive is a type that implements the trait.
//!
//! | kind | what it is |
//! |--|--|
//! | [`SimulatedDrive`] | position controller and lag, calculated |
//! | [`ProcessDrive`] | drive code in another process: its attachment, heartbeat and faults. A [`DriveLink`] carries the values; `coaxle_drive_memory::SharedMemoryDrive` has one |
//! | custom | for example a fieldbus, or a drive library |
//!
//! ```
//! use coaxle_axis::drive::{Actual, Drive, DriveState};
//! use coaxle_clock::Seconds;
//! use coaxle_curve::profile::Kinematics;
//!
//! /// Reaches its set position at once.
//! #[derive(Debug, Default)]
//! struct Ideal(Actual);
//!
//! impl Drive for Ideal {
//!     fn power_on(&mut self, position: f64, velocity: f64) {
//!         self.0 = Actual { state: DriveState::Following, position, velocity, ..self.0 };
//!     }
//!     fn reset(&mut self) {
//!         self.0 = Actual { state: DriveState::Off, velocity: 0.0, ..self.0 };
//!     }
//!     fn step(&mut self, set: &Kinematics, _elapsed: Seconds) {
//!         if self.0.state == DriveState::Following {
//!             (self.0.position, self.0.velocity) = (set.position, set.velocity);
//!         }
//!     }
//!     fn actual(&self) -> Actual {
//!         self.0
//!     }
//! }
//!
//! let mut drive = Ideal::default();
//! drive.power_on(0.0, 0.0);
//! drive.step(&Kinematics { position: 2.0, velocity: 5.0, acceleration: 0.0 }, Seconds(0.001));
//! assert_eq!(drive.actual().position, 2.0);
//! ```

mod actual;
mod fault;
mod process;
mod simulated;

use core::fmt;

use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

pub use actual::{Actual, Attachment, DriveKind, DriveState};
pub use fault::DriveFault;
pub use process::{
    DriveCommand, DriveLink, DriveReply, ProcessDrive, ProcessDriveParameters, ProcessState,
};
pub use simulated::{DriveParameters, SimulatedDrive, WrongDriveParameter};

/// A drive that follows the set values of an axis.
///
/// It is called in the cycle: no method may allocate, lock, log, wait, or make a system call that
/// may wait. Longer work belongs in a separate thread or process, connected by wait-free memory.
///
/// Its life: [`Off`](DriveState::Off); by [`power_on`](Self::power_on)
/// [`Following`](DriveState::Following), at once or by way of
/// [`SwitchingOn`](DriveState::SwitchingOn); [`Tripped`](DriveState::Tripped) when it has failed;
/// by [`reset`](Self::reset) `Off`, from every state. It leaves `Following` by `Tripped` and
/// `reset` only.
///
/// Its actual values are not trusted: an axis treats a drive with non-finite values, or values
/// beyond [`Actual::LARGEST`], as tripped, and one that is no longer following as failed.
pub trait Drive: fmt::Debug + Send {
    /// Switches power on. `position`, in u, and `velocity`, in u/s, are the axis's knowledge. A
    /// simulated drive adopts them; a real one keeps its own position, which its axis then reads. A
    /// tripped drive stays tripped.
    fn power_on(&mut self, position: f64, velocity: f64);

    /// Switches power off, which acknowledges a trip.
    fn reset(&mut self);

    /// Runs one cycle, `elapsed` after the one before: position in u, velocity in u/s, acceleration
    /// in u/s². Called in every cycle, with or without power. Without power, the set values are
    /// meaningless.
    fn step(&mut self, set: &Kinematics, elapsed: Seconds);

    /// Actual values and state, after the last call of any other method.
    fn actual(&self) -> Actual;

    /// Kind of drive, for status and traces.
    fn kind(&self) -> DriveKind {
        DriveKind::Own
    }
}
