//! The slave's own axis structure, so that others can follow it.

use coaxle_motion::axis::{AxisState, CoupleState, NcToPlcAxis, StateWord};
use coaxle_motion::drive::DriveState;
use coaxle_motion::profile::Kinematics;

use crate::snapshot::{DriveSnapshot, MasterSnapshot};

/// NC error of a following error that lasted too long.
pub(crate) const FOLLOWING_ERROR: u32 = 0x4550;

/// The axis structure of a coupled slave.
pub(crate) fn axis_of(
    id: u32,
    slave: &Kinematics,
    master: Option<&MasterSnapshot>,
    drive: &DriveSnapshot,
) -> NcToPlcAxis {
    let error_code = match (drive.state, master.and_then(|master| master.error)) {
        (DriveState::Tripped, _) => FOLLOWING_ERROR,
        (_, Some(error)) => u32::from(error.code()),
        _ => 0,
    };
    NcToPlcAxis {
        state_word: state_word(slave, error_code),
        error_code,
        axis_state: AxisState::SlaveSynchronous,
        couple_state: CoupleState::Slave,
        axis_id: id,
        actual_position: drive.position,
        modulo_actual_position: drive.position,
        actual_velocity: drive.velocity,
        following_error: drive.following_error,
        set_position: slave.position,
        set_velocity: slave.velocity,
        set_acceleration: slave.acceleration,
        target_position: slave.position,
        modulo_set_position: slave.position,
        ..NcToPlcAxis::default()
    }
}

fn state_word(slave: &Kinematics, error_code: u32) -> StateWord {
    let mut word = StateWord::HOMED | StateWord::HAS_JOB | StateWord::CONTROL_LOOP_CLOSED;
    word.set(StateWord::OPERATIONAL, error_code == 0);
    word.set(StateWord::ERROR, error_code != 0);
    word.set(StateWord::NOT_MOVING, slave.velocity == 0.0);
    word.set(StateWord::POSITIVE_DIRECTION, slave.velocity > 0.0);
    word.set(StateWord::NEGATIVE_DIRECTION, slave.velocity < 0.0);
    word
}
