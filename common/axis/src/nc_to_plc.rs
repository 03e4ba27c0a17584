//! `NCTOPLC_AXLESTRUCT`: the values that an axis publishes, once per cycle.

use super::{AxisState, CoupleState, Modulo, ModuloPosition, StateWord};

/// The NC-to-PLC axis structure, with every field, in user units (`u`, for example mm or degrees).
///
/// TS5066 (`NCTOPLC_AXLESTRUCT`), and the later `AXIS_REF.NcToPlc`, which names the reserved bytes
/// of the former. Kinematic values are finite in every accepted frame.
#[doc(alias = "NCTOPLC_AXLESTRUCT")]
#[doc(alias = "NCTOPLC_AXIS_REF")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NcToPlcAxis {
    /// The state word, bit by bit.
    #[doc(alias = "nStateDWord")]
    pub state_word: StateWord,
    /// NC error code, 0 = none.
    #[doc(alias = "nErrorCode")]
    pub error_code: u32,
    /// State of the axis's motion.
    #[doc(alias = "nAxisState")]
    pub axis_state: AxisState,
    /// Confirmed axis mode.
    #[doc(alias = "nAxisModeCon")]
    pub axis_mode: u32,
    /// State of the reference run.
    #[doc(alias = "nCalibrationState")]
    pub calibration_state: u32,
    /// Role in couplings: master, slave, or both.
    #[doc(alias = "nCoupleState")]
    pub couple_state: CoupleState,
    /// Commands waiting in the preparation table.
    #[doc(alias = "nSvbEntries")]
    pub svb_entries: u32,
    /// Commands waiting in the execution table.
    #[doc(alias = "nSafEntries")]
    pub saf_entries: u32,
    /// The axis id on its controller.
    #[doc(alias = "nAxisId")]
    pub axis_id: u32,
    /// Operation mode word.
    #[doc(alias = "nOpModeDWord")]
    pub op_mode: u32,
    /// Control loop in use.
    #[doc(alias = "nActiveControlLoopIndex")]
    pub active_control_loop: u16,
    /// Requested control loop.
    #[doc(alias = "nControlLoopIndex")]
    pub control_loop: u16,
    /// Actual position, u.
    #[doc(alias = "fPosIst")]
    pub actual_position: f64,
    /// Actual position within one modulo period, u.
    #[doc(alias = "fModuloPosIst")]
    pub modulo_actual_position: f64,
    /// Whole modulo periods of the actual position.
    #[doc(alias = "nModuloTurns")]
    pub modulo_actual_turns: i32,
    /// Actual velocity, u/s.
    #[doc(alias = "fVeloIst")]
    pub actual_velocity: f64,
    /// Following error, u.
    #[doc(alias = "fPosDiff")]
    pub following_error: f64,
    /// Set position, u.
    #[doc(alias = "fPosSoll")]
    pub set_position: f64,
    /// Set velocity, u/s.
    #[doc(alias = "fVeloSoll")]
    pub set_velocity: f64,
    /// Set acceleration, u/s².
    #[doc(alias = "fAccSoll")]
    pub set_acceleration: f64,
    /// Target position of the current command, u (reserved in `NCTOPLC_AXLESTRUCT`).
    #[doc(alias = "TargetPos")]
    pub target_position: f64,
    /// Set position within one modulo period, u (reserved in `NCTOPLC_AXLESTRUCT`).
    #[doc(alias = "ModuloSetPos")]
    pub modulo_set_position: f64,
    /// Whole modulo periods of the set position (reserved in `NCTOPLC_AXLESTRUCT`).
    #[doc(alias = "ModuloSetTurns")]
    pub modulo_set_turns: i32,
    /// Number of the current command (reserved in `NCTOPLC_AXLESTRUCT`).
    #[doc(alias = "CmdNo")]
    pub command_number: u16,
    /// State of the current command (reserved in `NCTOPLC_AXLESTRUCT`).
    #[doc(alias = "CmdState")]
    pub command_state: u16,
}

impl NcToPlcAxis {
    /// Largest plausible position, velocity or acceleration, in u, u/s or u/s²: an f64 of this size
    /// counts in steps of an eighth, and sums and products of larger ones could overflow.
    pub const LARGEST: f64 = 1e15;

    /// Fills in its modulo positions; without a period, they are the plain positions.
    #[inline]
    pub fn count_turns(&mut self, modulo: Option<Modulo>) {
        let actual = ModuloPosition::of(self.actual_position, modulo);
        self.modulo_actual_position = actual.within;
        self.modulo_actual_turns = actual.turns;
        let set = ModuloPosition::of(self.set_position, modulo);
        self.modulo_set_position = set.within;
        self.modulo_set_turns = set.turns;
    }

    /// The first kinematic field that is not a number between ∓[`LARGEST`](Self::LARGEST), by its PLC
    /// name.
    #[must_use]
    pub fn implausible_field(&self) -> Option<&'static str> {
        let plausible = -Self::LARGEST..=Self::LARGEST;
        [
            ("fPosIst", self.actual_position),
            ("fModuloPosIst", self.modulo_actual_position),
            ("fVeloIst", self.actual_velocity),
            ("fPosDiff", self.following_error),
            ("fPosSoll", self.set_position),
            ("fVeloSoll", self.set_velocity),
            ("fAccSoll", self.set_acceleration),
            ("TargetPos", self.target_position),
            ("ModuloSetPos", self.modulo_set_position),
        ]
        .into_iter()
        // NaN is in no range, so this refuses it, too.
        .find_map(|(name, value)| (!plausible.contains(&value)).then_some(name))
    }
}
