//! What follows the set values of an axis.
//!
//! A [`Drive`] takes set values once per cycle and says where it is and whether it follows. The axis that
//! it belongs to knows nothing more of it: a drive of your own is a type that implements the trait.
//!
//! | kind | what it is |
//! |--|--|
//! | [`SimulatedDrive`] | position controller and lag, calculated |
//! | [`ProcessDrive`] | drive code in another process: who is attached, whether it lives, when it has failed. What carries the values is a [`DriveLink`]; `coaxle_host::SharedMemoryDrive` has one |
//! | your own | say a fieldbus, or the set values of a drive library |
//!
//! ```
//! use coaxle_axis::drive::{Actual, Drive, DriveState};
//! use coaxle_clock::Seconds;
//! use coaxle_curve::profile::Kinematics;
//!
//! /// Is at once where it is told to be.
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

/// What follows the set values of an axis.
///
/// It is called in the cycle: nothing here may allocate, lock, log, wait, or make a system call that may
/// wait. What takes longer belongs in a thread or a process of its own, with wait-free memory between.
///
/// Its life: [`Off`](DriveState::Off); by [`power_on`](Self::power_on)
/// [`Following`](DriveState::Following), at once or by way of [`SwitchingOn`](DriveState::SwitchingOn);
/// [`Tripped`](DriveState::Tripped) when it has failed; by [`reset`](Self::reset) `Off`, from wherever it
/// is. It leaves `Following` by `Tripped` and `reset` only.
///
/// What it answers is not trusted: an axis takes a drive whose values are no finite numbers, or beyond
/// [`Actual::LARGEST`], for tripped, and one that is no longer following for failed.
pub trait Drive: fmt::Debug + Send {
    /// Power on. The axis stands at `position`, in u, and moves at `velocity`, in u/s, as far as it knows.
    /// A simulated drive takes that over; a real one is where it is, and its axis looks where that is. A
    /// tripped drive stays tripped.
    fn power_on(&mut self, position: f64, velocity: f64);

    /// Power off. A trip is acknowledged by that.
    fn reset(&mut self);

    /// One cycle, `elapsed` after the one before: position in u, velocity in u/s, acceleration in u/s². It
    /// is called in every cycle, with power or without. Without, the set values mean nothing.
    fn step(&mut self, set: &Kinematics, elapsed: Seconds);

    /// Where it is and how it does, after the last call of any of the others.
    fn actual(&self) -> Actual;

    /// What kind it is, for status and traces.
    fn kind(&self) -> DriveKind {
        DriveKind::Own
    }
}
