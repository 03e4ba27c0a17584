//! The slave's axis structure, so that others can follow it.

use coaxle_axis::drive::DriveState;
use coaxle_axis::{AxisState, AxisStatus, CoupleState, CouplingPhase, NcToPlcAxis, StateWord};
use coaxle_cam::Tables;

use super::axis::SlaveAxis;

impl SlaveAxis {
    /// The published structure of the axis, with this id. Its role as a master is set elsewhere.
    #[must_use]
    pub fn axis_struct(&self, plates: &Tables, id: u32) -> NcToPlcAxis {
        let mut axis = NcToPlcAxis::default();
        self.write_axis_struct(plates, id, &mut axis);
        axis
    }

    /// Writes the published structure with all fields in place: it takes more than 200 bytes, which
    /// are then not moved.
    pub fn write_axis_struct(&self, plates: &Tables, id: u32, axis: &mut NcToPlcAxis) {
        let set = self.set();
        *axis = NcToPlcAxis {
            state_word: self.state_word(plates),
            error_code: self.error().map_or(0, |error| error.code()),
            axis_state: self.axis_state(),
            calibration_state: u32::from(self.is_homed()),
            couple_state: if self.coupling_phase().is_some() {
                CoupleState::Slave
            } else {
                CoupleState::Single
            },
            axis_id: id,
            actual_position: self.actual_position(),
            actual_velocity: self.actual().velocity,
            following_error: self.actual().following_error,
            set_position: set.position,
            set_velocity: set.velocity,
            set_acceleration: set.acceleration,
            target_position: self.target_position(),
            // The field has 16 bits: later numbers wrap.
            command_number: self.job().0.map_or(0, |job| job.number as u16),
            ..NcToPlcAxis::default()
        };
        axis.count_turns(self.modulo());
    }

    fn axis_state(&self) -> AxisState {
        let set = self.set();
        match self.coupling_phase() {
            Some(CouplingPhase::Waiting | CouplingPhase::Released) => AxisState::SlavePrephase,
            // A slave that is behind is not in sync, and so is synchronising.
            Some(phase) if phase.is_in_sync() => AxisState::SlaveSynchronous,
            Some(_) => AxisState::SlaveSynchronizing,
            None => AxisState::of_motion(set.velocity, set.acceleration),
        }
    }

    fn state_word(&self, plates: &Tables) -> StateWord {
        let (status, set) = (self.status(), self.set());
        let drive = self.actual().state;
        let failed = status == AxisStatus::ErrorStop;
        // By the drive and not by the command: a drive may have power in an error stop.
        let powered = drive == DriveState::Following;
        let constant = set.velocity != 0.0 && set.acceleration == 0.0;
        let mut word = self.queued(plates) | StateWord::of_velocity(set.velocity);
        word.set(StateWord::OPERATIONAL, self.is_operational());
        word.set(StateWord::HOMED, self.is_homed());
        word.set(
            StateWord::IN_TARGET_POSITION,
            // Only there a motion has come to its end: at rest in an error stop it has not.
            status == AxisStatus::Standstill,
        );
        word.set(StateWord::HAS_JOB, self.has_job());
        word.set(StateWord::HOMING_BUSY, status == AxisStatus::Homing);
        word.set(StateWord::CONSTANT_VELOCITY, constant);
        word.set(
            StateWord::CONTINUOUS_MOTION,
            status == AxisStatus::ContinuousMotion,
        );
        word.set(StateWord::CONTROL_LOOP_CLOSED, powered);
        word.set(
            StateWord::SOFT_LIMIT_MIN_EXCEEDED,
            self.guard().is_below(set.position),
        );
        word.set(
            StateWord::SOFT_LIMIT_MAX_EXCEEDED,
            self.guard().is_above(set.position),
        );
        word.set(StateWord::DRIVE_DEVICE_ERROR, drive == DriveState::Tripped);
        word.set(
            StateWord::MOTION_COMMANDS_LOCKED,
            status == AxisStatus::Stopping,
        );
        word.set(StateWord::ERROR, failed);
        word
    }
}
