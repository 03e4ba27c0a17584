//! The drive of an axis, and what it said last as far as that can be believed.

use alloc::boxed::Box;

use coaxle_axis::drive::{Actual, Drive, DriveFault, DriveState};
use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

/// Asks the drive once after each call: everything else looks at the copy.
#[derive(Debug)]
pub(crate) struct DrivePort {
    drive: Box<dyn Drive>,
    actual: Actual,
}

impl DrivePort {
    pub(crate) fn new(drive: Box<dyn Drive>) -> Self {
        let actual = believed(drive.actual(), &Actual::default());
        Self { drive, actual }
    }

    pub(crate) const fn actual(&self) -> &Actual {
        &self.actual
    }

    pub(crate) fn drive(&self) -> &dyn Drive {
        &*self.drive
    }

    pub(crate) fn power_on(&mut self, position: f64, velocity: f64) {
        self.drive.power_on(position, velocity);
        self.look();
    }

    pub(crate) fn reset(&mut self) {
        self.drive.reset();
        self.look();
    }

    pub(crate) fn step(&mut self, set: &Kinematics, elapsed: Seconds) {
        self.drive.step(set, elapsed);
        self.look();
    }

    /// Why it is tripped.
    pub(crate) fn fault(&self) -> DriveFault {
        self.actual.fault.unwrap_or(DriveFault::FollowingError {
            following_error: self.actual.following_error,
        })
    }

    fn look(&mut self) {
        self.actual = believed(self.drive.actual(), &self.actual);
    }
}

/// What cannot be is what was before, and the drive has failed if it has power.
fn believed(now: Actual, before: &Actual) -> Actual {
    let Some((field, received)) = now.implausible() else {
        return now;
    };
    Actual {
        state: match now.state {
            DriveState::Off => DriveState::Off,
            _ => DriveState::Tripped,
        },
        fault: Some(DriveFault::Implausible { field, received }),
        attachment: now.attachment,
        ..*before
    }
}
