//! The drive of a slave: it is where it should be.

use coaxle_axis::drive::{Actual, Drive, DriveState};
use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

/// A drive without lag, which begins at the position of its axis.
#[derive(Debug)]
pub(super) struct FollowingDrive(Actual);

impl FollowingDrive {
    pub(super) fn at(position: f64) -> Self {
        Self(Actual {
            position,
            ..Actual::default()
        })
    }
}

impl Drive for FollowingDrive {
    fn power_on(&mut self, position: f64, velocity: f64) {
        self.0.state = DriveState::Following;
        (self.0.position, self.0.velocity) = (position, velocity);
    }

    fn reset(&mut self) {
        self.0.state = DriveState::Off;
        self.0.velocity = 0.0;
    }

    fn step(&mut self, set: &Kinematics, _elapsed: Seconds) {
        if self.0.state == DriveState::Following {
            (self.0.position, self.0.velocity) = (set.position, set.velocity);
        }
    }

    fn actual(&self) -> Actual {
        self.0
    }
}
