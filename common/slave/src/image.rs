//! The slave's axis structure, so that others can follow it.

use coaxle_axis::drive::DriveState;
use coaxle_axis::{AxisState, AxisStatus, CoupleState, CouplingPhase, NcToPlcAxis, StateWord};

use super::axis::SlaveAxis;

impl SlaveAxis {
    /// What the axis tells the world as the axis with this id. Whether it is a master too, others know.
    #[must_use]
    pub fn axis_struct(&self, id: u32) -> NcToPlcAxis {
        let set = self.set();
        let actual = self.actual_position();
        NcToPlcAxis {
            state_word: self.state_word(),
            error_code: self.error().map_or(0, |error| error.code()),
            axis_state: self.axis_state(),
            calibration_state: u32::from(self.is_homed()),
            couple_state: if self.coupling_phase().is_some() {
                CoupleState::Slave
            } else {
                CoupleState::Single
            },
            axis_id: id,
            actual_position: actual,
            actual_velocity: self.actual().velocity,
            following_error: self.actual().following_error,
            set_position: set.position,
            set_velocity: set.velocity,
            set_acceleration: set.acceleration,
            target_position: self.target_position(),
            command_number: self.job().0.map_or(0, |job| job.number as u16),
            ..NcToPlcAxis::default()
        }
        .by_turns(self.modulo())
    }

    fn axis_state(&self) -> AxisState {
        let set = self.set();
        match self.coupling_phase() {
            Some(CouplingPhase::Waiting | CouplingPhase::Released) => AxisState::SlavePrephase,
            Some(phase) if phase.is_in_sync() => AxisState::SlaveSynchronous,
            Some(_) => AxisState::SlaveSynchronizing,
            None => AxisState::of_motion(set.velocity, set.acceleration),
        }
    }

    fn state_word(&self) -> StateWord {
        let (status, set) = (self.status(), self.set());
        let drive = self.actual().state;
        let failed = status == AxisStatus::ErrorStop;
        let powered = drive == DriveState::Following;
        let constant = set.velocity != 0.0 && set.acceleration == 0.0;
        [
            (StateWord::OPERATIONAL, self.is_operational()),
            (StateWord::HOMED, self.is_homed()),
            (
                StateWord::IN_TARGET_POSITION,
                status == AxisStatus::Standstill,
            ),
            (StateWord::HAS_JOB, self.has_job()),
            (StateWord::HOMING_BUSY, status == AxisStatus::Homing),
            (StateWord::CONSTANT_VELOCITY, constant),
            (
                StateWord::CONTINUOUS_MOTION,
                status == AxisStatus::ContinuousMotion,
            ),
            (StateWord::CONTROL_LOOP_CLOSED, powered),
            (
                StateWord::SOFT_LIMIT_MIN_EXCEEDED,
                self.guard().is_below(set.position),
            ),
            (
                StateWord::SOFT_LIMIT_MAX_EXCEEDED,
                self.guard().is_above(set.position),
            ),
            (StateWord::DRIVE_DEVICE_ERROR, drive == DriveState::Tripped),
            (
                StateWord::MOTION_COMMANDS_LOCKED,
                status == AxisStatus::Stopping,
            ),
            (StateWord::ERROR, failed),
        ]
        .into_iter()
        .filter_map(|(bit, is_set)| is_set.then_some(bit))
        .collect::<StateWord>()
            | StateWord::of_velocity(set.velocity)
            | self.queued()
    }
}
