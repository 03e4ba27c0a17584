//! A slave that nothing watches: it follows its gear, beats and all.

use coaxle_axis::drive::{Actual, Drive, DriveState, SimulatedDrive};
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
    drive: SimulatedDrive,
    /// What it said last.
    actual: Actual,
    /// None until it is coupled.
    set: Option<Kinematics>,
    error_of_master: u32,
}

impl Follower {
    pub(super) fn new(gear: LinearGear, drive: SimulatedDrive) -> Self {
        Self {
            gear,
            actual: drive.actual(),
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
        if self.actual.state == DriveState::Off {
            self.drive.power_on(set.position, set.velocity);
        } else {
            self.drive.step(&set, elapsed);
        }
        self.actual = self.drive.actual();
        self.set = Some(set);
        self.error_of_master = master.error_code;
    }

    pub(super) const fn set(&self) -> Option<Kinematics> {
        self.set
    }

    pub(super) const fn actual(&self) -> &Actual {
        &self.actual
    }

    pub(super) const fn status(&self) -> AxisStatus {
        match (self.actual.state, self.set) {
            (DriveState::Tripped, _) => AxisStatus::ErrorStop,
            (_, Some(_)) => AxisStatus::SynchronizedMotion,
            (_, None) => AxisStatus::Disabled,
        }
    }

    pub(super) fn error(&self) -> Option<SlaveError> {
        self.actual.fault.map(SlaveError::Drive)
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
            actual_position: self.actual.position,
            modulo_actual_position: self.actual.position,
            actual_velocity: self.actual.velocity,
            following_error: self.actual.following_error,
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
