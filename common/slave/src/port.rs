//! The drive of an axis, and its last plausible values.

use alloc::boxed::Box;

use coaxle_axis::drive::{Actual, Drive, DriveFault, DriveState};
use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

/// Reads the drive once after each call: all other code uses the copy.
#[derive(Debug)]
pub(crate) struct DrivePort {
    drive: Box<dyn Drive>,
    actual: Actual,
}

impl DrivePort {
    pub(crate) fn new(drive: Box<dyn Drive>) -> Self {
        // The first values may be implausible, too: the axis then begins at 0.
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

    /// Fault of its trip.
    pub(crate) fn fault(&self) -> DriveFault {
        // Without a stated fault the following error is the one that the axis can see itself.
        self.actual.fault.unwrap_or(DriveFault::FollowingError {
            following_error: self.actual.following_error,
        })
    }

    fn look(&mut self) {
        self.actual = believed(self.drive.actual(), &self.actual);
    }
}

/// Replaces implausible values by the last ones, and marks a powered drive as tripped.
fn believed(now: Actual, before: &Actual) -> Actual {
    let Some((field, received)) = now.implausible() else {
        return now;
    };
    Actual {
        state: match now.state {
            // Without power a drive follows nothing, and cannot trip.
            DriveState::Off => DriveState::Off,
            _ => DriveState::Tripped,
        },
        fault: Some(DriveFault::Implausible { field, received }),
        // States whether a process is there at all, which does not depend on its values.
        attachment: now.attachment,
        ..*before
    }
}
