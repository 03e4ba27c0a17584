//! The axis structure as it is in frames.

use ::coaxle_axis::{AxisState, CoupleState, NcToPlcAxis, StateWord};

use crate::failure::Failure;

/// The NC-to-PLC axis structure (`NCTOPLC_AXLESTRUCT`) as it is in frames, in user units (u). It does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct coaxle_axis {
    /// The state word (`nStateDWord`).
    pub state_word: u32,
    /// NC error code (`nErrorCode`), 0: none.
    pub error_code: u32,
    /// State of the motion (`nAxisState`).
    pub axis_state: u32,
    /// Confirmed axis mode (`nAxisModeCon`).
    pub axis_mode: u32,
    /// State of the reference run (`nCalibrationState`).
    pub calibration_state: u32,
    /// Role in couplings (`nCoupleState`).
    pub couple_state: u32,
    /// Commands waiting in the preparation table (`nSvbEntries`).
    pub svb_entries: u32,
    /// Commands waiting in the execution table (`nSafEntries`).
    pub saf_entries: u32,
    /// Axis id on its controller (`nAxisId`).
    pub axis_id: u32,
    /// Operation mode word (`nOpModeDWord`).
    pub op_mode: u32,
    /// Control loop in use (`nActiveControlLoopIndex`).
    pub active_control_loop: u16,
    /// Requested control loop (`nControlLoopIndex`).
    pub control_loop: u16,
    /// Whole modulo periods of the actual position (`nModuloTurns`).
    pub modulo_actual_turns: i32,
    /// Actual position (`fPosIst`), u.
    pub actual_position: f64,
    /// Actual position within one modulo period (`fModuloPosIst`), u.
    pub modulo_actual_position: f64,
    /// Actual velocity (`fVeloIst`), u/s.
    pub actual_velocity: f64,
    /// Following error (`fPosDiff`), u.
    pub following_error: f64,
    /// Set position (`fPosSoll`), u.
    pub set_position: f64,
    /// Set velocity (`fVeloSoll`), u/s.
    pub set_velocity: f64,
    /// Set acceleration (`fAccSoll`), u/s².
    pub set_acceleration: f64,
    /// Target position of the current command (`TargetPos`), u.
    pub target_position: f64,
    /// Set position within one modulo period (`ModuloSetPos`), u.
    pub modulo_set_position: f64,
    /// Whole modulo periods of the set position (`ModuloSetTurns`).
    pub modulo_set_turns: i32,
    /// Number of the current command (`CmdNo`).
    pub command_number: u16,
    /// State of the current command (`CmdState`).
    pub command_state: u16,
}

impl coaxle_axis {
    /// Makes it of an axis.
    pub(crate) fn of(axis: &NcToPlcAxis) -> Self {
        Self {
            state_word: axis.state_word.bits(),
            error_code: axis.error_code,
            axis_state: axis.axis_state.into(),
            axis_mode: axis.axis_mode,
            calibration_state: axis.calibration_state,
            couple_state: axis.couple_state.into(),
            svb_entries: axis.svb_entries,
            saf_entries: axis.saf_entries,
            axis_id: axis.axis_id,
            op_mode: axis.op_mode,
            active_control_loop: axis.active_control_loop,
            control_loop: axis.control_loop,
            modulo_actual_turns: axis.modulo_actual_turns,
            actual_position: axis.actual_position,
            modulo_actual_position: axis.modulo_actual_position,
            actual_velocity: axis.actual_velocity,
            following_error: axis.following_error,
            set_position: axis.set_position,
            set_velocity: axis.set_velocity,
            set_acceleration: axis.set_acceleration,
            target_position: axis.target_position,
            modulo_set_position: axis.modulo_set_position,
            modulo_set_turns: axis.modulo_set_turns,
            command_number: axis.command_number,
            command_state: axis.command_state,
        }
    }

    pub(crate) fn checked(&self) -> Result<NcToPlcAxis, Failure> {
        let axis = NcToPlcAxis {
            state_word: StateWord::from_bits_retain(self.state_word),
            error_code: self.error_code,
            axis_state: AxisState::from(self.axis_state),
            axis_mode: self.axis_mode,
            calibration_state: self.calibration_state,
            couple_state: CoupleState::from(self.couple_state),
            svb_entries: self.svb_entries,
            saf_entries: self.saf_entries,
            axis_id: self.axis_id,
            op_mode: self.op_mode,
            active_control_loop: self.active_control_loop,
            control_loop: self.control_loop,
            actual_position: self.actual_position,
            modulo_actual_position: self.modulo_actual_position,
            modulo_actual_turns: self.modulo_actual_turns,
            actual_velocity: self.actual_velocity,
            following_error: self.following_error,
            set_position: self.set_position,
            set_velocity: self.set_velocity,
            set_acceleration: self.set_acceleration,
            target_position: self.target_position,
            modulo_set_position: self.modulo_set_position,
            modulo_set_turns: self.modulo_set_turns,
            command_number: self.command_number,
            command_state: self.command_state,
        };
        match axis.implausible_field() {
            None => Ok(axis),
            Some(field) => {
                let expected = "a number between -1e15 and 1e15";
                let received = format_args!("one that is not, of axis {}", self.axis_id);
                Err(Failure::range(field, received, expected))
            }
        }
    }
}
