//! A slave that nothing watches: it follows its gear, beats and all.

use coaxle_axis::drive::{Drive, DriveState};
use coaxle_axis::{AxisState, AxisStatus, CoupleState, NcToPlcAxis, StateWord};
use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;
use coaxle_gear::LinearGear;
use coaxle_slave::SlaveError;

use super::Master;

/// A gear and a drive.
#[derive(Debug)]
pub(super) struct Follower {
    gear: LinearGear,
    drive: Drive,
    /// None until it is coupled.
    set: Option<Kinematics>,
    error_of_master: u32,
}

impl Follower {
    pub(super) const fn new(gear: LinearGear, drive: Drive) -> Self {
        Self {
            gear,
            drive,
            set: None,
            error_of_master: 0,
        }
    }

    pub(super) fn update(&mut self, master: Option<&Master>, elapsed: Seconds) {
        let Some(master) = master else {
            return;
        };
        let set = self.gear.slave_of(&master.set);
        if self.drive.state() == DriveState::Off {
            self.drive.power_on(set.position, set.velocity);
        } else {
            self.drive.step(set.position, elapsed.0);
        }
        self.set = Some(set);
        self.error_of_master = master.error_code;
    }

    pub(super) const fn set(&self) -> Option<Kinematics> {
        self.set
    }

    pub(super) const fn drive(&self) -> &Drive {
        &self.drive
    }

    pub(super) const fn status(&self) -> AxisStatus {
        match (self.drive.state(), self.set) {
            (DriveState::Tripped, _) => AxisStatus::ErrorStop,
            (_, Some(_)) => AxisStatus::SynchronizedMotion,
            (_, None) => AxisStatus::Disabled,
        }
    }

    pub(super) fn error(&self) -> Option<SlaveError> {
        (self.drive.state() == DriveState::Tripped).then(|| SlaveError::FollowingError {
            following_error: self.drive.following_error(),
        })
    }

    /// One that was never coupled has nothing to say.
    pub(super) fn axis_struct(&self, id: u32) -> Option<NcToPlcAxis> {
        let set = self.set?;
        let error_code = self
            .error()
            .map_or(self.error_of_master, |error| error.code());
        Some(NcToPlcAxis {
            state_word: state_word(&set, error_code),
            error_code,
            axis_state: AxisState::SlaveSynchronous,
            couple_state: CoupleState::Slave,
            axis_id: id,
            actual_position: self.drive.position(),
            modulo_actual_position: self.drive.position(),
            actual_velocity: self.drive.velocity(),
            following_error: self.drive.following_error(),
            set_position: set.position,
            set_velocity: set.velocity,
            set_acceleration: set.acceleration,
            target_position: set.position,
            modulo_set_position: set.position,
            ..NcToPlcAxis::default()
        })
    }
}

fn state_word(set: &Kinematics, error_code: u32) -> StateWord {
    let mut word = StateWord::HOMED | StateWord::HAS_JOB | StateWord::CONTROL_LOOP_CLOSED;
    word.set(StateWord::OPERATIONAL, error_code == 0);
    word.set(StateWord::ERROR, error_code != 0);
    word | StateWord::of_velocity(set.velocity)
}
