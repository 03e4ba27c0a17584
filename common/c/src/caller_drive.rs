//! The drive of an axis as the caller has it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use ::coaxle_axis::drive::{Actual, Drive, DriveState};
use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

use crate::failure::Failure;
use crate::memory::growing;

/// The axis has a drive that is where it should be, without a caller's doing.
pub const COAXLE_DRIVE_IDEAL: u32 = 0;
/// The caller has a drive, and reports its actual values.
pub const COAXLE_DRIVE_OF_CALLER: u32 = 1;

/// No power.
pub const COAXLE_DRIVE_OFF: u32 = 0;
/// Power commanded, but not following yet.
pub const COAXLE_DRIVE_SWITCHING_ON: u32 = 1;
/// Following its set position.
pub const COAXLE_DRIVE_FOLLOWING: u32 = 2;
/// Failed; it stays so until its power is switched off.
pub const COAXLE_DRIVE_TRIPPED: u32 = 3;

/// Actual values of a drive.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_actual {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// `COAXLE_DRIVE_OFF` to `COAXLE_DRIVE_TRIPPED`.
    pub state: u32,
    /// Actual position, u.
    pub position: f64,
    /// Actual velocity, u/s.
    pub velocity: f64,
    /// Set minus actual position, u.
    pub following_error: f64,
}

growing! {
    coaxle_actual, 32;
}

/// State of a drive between its caller and its axis. Both are in one thread: the atomics make it `Send`, and cost what plain cells do.
#[derive(Debug)]
pub(crate) struct DriveCells {
    is_of_caller: bool,
    state: AtomicU32,
    position: AtomicU64,
    velocity: AtomicU64,
    following_error: AtomicU64,
    /// True if the axis wants its drive to have power.
    wants_power: AtomicBool,
}

impl DriveCells {
    pub(crate) fn new(kind: u32) -> Result<Arc<Self>, Failure> {
        let is_of_caller = match kind {
            COAXLE_DRIVE_IDEAL => false,
            COAXLE_DRIVE_OF_CALLER => true,
            other => return Err(Failure::range("drive", other, "0 or 1")),
        };
        Ok(Arc::new(Self {
            is_of_caller,
            state: AtomicU32::new(COAXLE_DRIVE_OFF),
            position: AtomicU64::new(0.0_f64.to_bits()),
            velocity: AtomicU64::new(0.0_f64.to_bits()),
            following_error: AtomicU64::new(0.0_f64.to_bits()),
            wants_power: AtomicBool::new(false),
        }))
    }

    /// Takes the actual values of the caller's drive. Implausible ones are left to the axis, which stops.
    pub(crate) fn report(&self, actual: &coaxle_actual) -> Result<(), Failure> {
        if !self.is_of_caller {
            let expected = "one that was made with COAXLE_DRIVE_OF_CALLER";
            return Err(Failure::range(
                "drive",
                "actual values of an ideal one",
                expected,
            ));
        }
        if actual.state > COAXLE_DRIVE_TRIPPED {
            return Err(Failure::range("state", actual.state, "0 to 3"));
        }
        self.state.store(actual.state, Ordering::Relaxed);
        self.store(actual.position, actual.velocity);
        let error = actual.following_error.to_bits();
        self.following_error.store(error, Ordering::Relaxed);
        Ok(())
    }

    pub(crate) fn wants_power(&self) -> bool {
        self.wants_power.load(Ordering::Relaxed)
    }

    fn store(&self, position: f64, velocity: f64) {
        self.position.store(position.to_bits(), Ordering::Relaxed);
        self.velocity.store(velocity.to_bits(), Ordering::Relaxed);
    }
}

/// Drive of an axis, as the axis has it.
#[derive(Debug)]
pub(crate) struct CallerDrive(pub(crate) Arc<DriveCells>);

impl Drive for CallerDrive {
    fn power_on(&mut self, position: f64, velocity: f64) {
        self.0.wants_power.store(true, Ordering::Relaxed);
        if !self.0.is_of_caller {
            self.0
                .state
                .store(COAXLE_DRIVE_FOLLOWING, Ordering::Relaxed);
            self.0.store(position, velocity);
        }
    }

    fn reset(&mut self) {
        self.0.wants_power.store(false, Ordering::Relaxed);
        if !self.0.is_of_caller {
            self.0.state.store(COAXLE_DRIVE_OFF, Ordering::Relaxed);
        }
    }

    fn step(&mut self, set: &Kinematics, _elapsed: Seconds) {
        let follows = self.0.state.load(Ordering::Relaxed) == COAXLE_DRIVE_FOLLOWING;
        if follows && !self.0.is_of_caller {
            self.0.store(set.position, set.velocity);
        }
    }

    fn actual(&self) -> Actual {
        let number = |cell: &AtomicU64| f64::from_bits(cell.load(Ordering::Relaxed));
        Actual {
            state: match self.0.state.load(Ordering::Relaxed) {
                COAXLE_DRIVE_OFF => DriveState::Off,
                COAXLE_DRIVE_SWITCHING_ON => DriveState::SwitchingOn,
                COAXLE_DRIVE_FOLLOWING => DriveState::Following,
                _ => DriveState::Tripped,
            },
            position: number(&self.0.position),
            velocity: number(&self.0.velocity),
            following_error: number(&self.0.following_error),
            ..Actual::default()
        }
    }
}
