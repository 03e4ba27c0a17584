//! Commands to a slave axis as a struct of numbers.

use coaxle_cam::StartMode;

use crate::handle::plain;
use crate::memory::{Growing, growing, writable, write};

/// `MC_Power`: switches power on.
pub const COAXLE_POWER_ON: u32 = 1;
/// `MC_Power`: switches power off after stopping the axis.
pub const COAXLE_POWER_OFF: u32 = 2;
/// `MC_Reset`: acknowledges the error of an axis that has come to rest.
pub const COAXLE_RESET: u32 = 3;
/// `MC_Home`, `MC_SetPosition`: sets the position of the axis at rest to `position`.
pub const COAXLE_HOME: u32 = 4;
/// `MC_MoveAbsolute`: moves to `position`, at up to `velocity`.
pub const COAXLE_MOVE_ABSOLUTE: u32 = 5;
/// `MC_MoveRelative`: moves by `distance`, at up to `velocity`.
pub const COAXLE_MOVE_RELATIVE: u32 = 6;
/// `MC_MoveVelocity`: ramps to `velocity`, whose sign is the direction, and keeps it.
pub const COAXLE_MOVE_VELOCITY: u32 = 7;
/// `MC_Halt`: brings the axis to rest; other commands can take over.
pub const COAXLE_HALT: u32 = 8;
/// `MC_Stop`: brings the axis to rest; only a stop that ends earlier can take over.
pub const COAXLE_STOP: u32 = 9;
/// `MC_GearIn`: couples to the master by `ratio`, on a ramp.
pub const COAXLE_GEAR_IN: u32 = 10;
/// `MC_GearInMultiMaster`, `MC_GearInDyn`, `MC_CombineAxes`: couples to the sum of masters by `ratios`.
pub const COAXLE_GEAR_IN_MULTI_MASTER: u32 = 11;
/// `MC_PhasingAbsolute`: shifts the master as the slave sees it to a lead of `distance`.
pub const COAXLE_PHASING_ABSOLUTE: u32 = 12;
/// `MC_PhasingRelative`: shifts the master by a further `distance`.
pub const COAXLE_PHASING_RELATIVE: u32 = 13;
/// `MC_MoveSuperImposed`: adds `distance` to the current motion.
pub const COAXLE_MOVE_SUPERIMPOSED: u32 = 14;
/// `MC_GearOut`: uncouples; the velocity is kept.
pub const COAXLE_GEAR_OUT: u32 = 15;
/// `MC_FlyingGear`: waits for the master, couples and releases on the fly.
pub const COAXLE_FLYING_GEAR: u32 = 16;
/// `MC_GearInPos`: the flying saw to a pair of positions.
pub const COAXLE_GEAR_IN_POS: u32 = 17;
/// `MC_GearInVelo`: the flying saw to the gear's velocity.
pub const COAXLE_GEAR_IN_VELO: u32 = 18;
/// `MC_CamIn`: couples by the plate `table`.
pub const COAXLE_CAM_IN: u32 = 19;
/// `MC_CamOut`: uncouples; the velocity is kept.
pub const COAXLE_CAM_OUT: u32 = 20;
/// `MC_CamScaling`: scales the plate.
pub const COAXLE_CAM_SCALING: u32 = 21;
/// `MC_CamIn_V2`: couples by one of several plates, or adds, exchanges, removes one: `operation`.
pub const COAXLE_CAM_IN_V2: u32 = 22;
/// `MC_CamAdd`: superposes the plate `table`.
pub const COAXLE_CAM_ADD: u32 = 23;
/// `MC_CamExchange`: replaces the plate `reference_table` by `table`.
pub const COAXLE_CAM_EXCHANGE: u32 = 24;
/// `MC_CamRemove`: removes the plate `table`.
pub const COAXLE_CAM_REMOVE: u32 = 25;
/// `MC_CamScaling_V2`: scales the plate `table`.
pub const COAXLE_CAM_SCALING_V2: u32 = 26;
/// `MC_SetCamOnlineChangeMode`: sets the activation of points of `table` that are written from now on.
pub const COAXLE_SET_CAM_ONLINE_CHANGE_MODE: u32 = 27;
/// `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint`: replaces points of `table`.
pub const COAXLE_WRITE_MOTION_FUNCTION: u32 = 28;

/// A synchronisation position is absolute.
pub const COAXLE_AT: u32 = 0;
/// A synchronisation position is a distance ahead of the axis.
pub const COAXLE_AHEAD: u32 = 1;
/// A synchronisation position is the next passage within the modulo period.
pub const COAXLE_IN_TURN: u32 = 2;

/// `TF5055` profiles over the whole distance.
pub const COAXLE_STRATEGY_NONE: u32 = 0;
/// `mcSyncStrategyLate`.
pub const COAXLE_STRATEGY_LATE: u32 = 1;
/// `mcSyncStrategySlow`.
pub const COAXLE_STRATEGY_SLOW: u32 = 2;
/// `mcSyncStrategyEarly`.
pub const COAXLE_STRATEGY_EARLY: u32 = 3;

/// A jump of the slave is refused.
pub const COAXLE_JUMP_REFUSE: u32 = 0;
/// The slave jumps, as in the original.
pub const COAXLE_JUMP_ALLOW: u32 = 1;
/// The slave is led to its new course over `ramp_length` of the master.
pub const COAXLE_JUMP_RAMP_IN: u32 = 2;

/// `min_position` is a limit.
pub const COAXLE_HAS_MIN_POSITION: u32 = 1;
/// `max_position` is a limit.
pub const COAXLE_HAS_MAX_POSITION: u32 = 2;
/// `master_start_distance` is given.
pub const COAXLE_HAS_MASTER_START_DISTANCE: u32 = 4;
/// `DefaultSlaveNegative` of a flying gear.
pub const COAXLE_DEFAULT_SLAVE_NEGATIVE: u32 = 8;
/// `activation_position` is one within the modulo period of the master.
pub const COAXLE_ACTIVATION_IN_TURN: u32 = 16;
/// `MasterRelative` of a plate.
pub const COAXLE_MASTER_RELATIVE: u32 = 32;
/// `SlaveRelative` of a plate.
pub const COAXLE_SLAVE_RELATIVE: u32 = 64;
/// The saw's profile is one over time (`GEARINSYNCMODE_TIMEBASED`) and not over the master's position.
pub const COAXLE_TIME_BASED: u32 = 128;
/// A sum of masters makes up what a change of the ratios left behind (`POSSYNC2`).
pub const COAXLE_POSSYNC2: u32 = 256;

/// A point of a motion function (`MC_MotionFunctionPoint`, TF5050). It does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_motion_point {
    /// Number of the point, from 1.
    pub index: u32,
    /// Motion law to the next point (`FunctionType`), by its number in TF5050.
    pub function: u32,
    /// Type of the point (`PointType`), by its number in TF5050.
    pub point_type: u32,
    /// Number of rows to the next point, 1 unless points are skipped.
    pub relative_next: i32,
    /// Position of the master, x.
    pub master: f64,
    /// Position of the slave, u.
    pub slave: f64,
    /// Velocity of the slave, u/x.
    pub velocity: f64,
    /// Acceleration of the slave, u/x².
    pub acceleration: f64,
    /// Jerk of the slave, u/x³.
    pub jerk: f64,
}

/// A command. `coaxle_command_init` sets all fields to what they are unless stated; a command looks at its own alone.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_command {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// `COAXLE_POWER_ON` to `COAXLE_WRITE_MOTION_FUNCTION`.
    pub kind: u32,
    /// `COAXLE_HAS_MIN_POSITION` to `COAXLE_POSSYNC2`, added up.
    pub flags: u32,
    /// Number of `ratios` that are given, 1 to 4.
    pub number_of_ratios: u32,
    /// Target position, u.
    pub position: f64,
    /// Distance or shift, u.
    pub distance: f64,
    /// Velocity, u/s; 0: the limit of the axis.
    pub velocity: f64,
    /// Acceleration, u/s²; 0: the limit of the axis.
    pub acceleration: f64,
    /// Deceleration, u/s²; 0: the limit of the axis.
    pub deceleration: f64,
    /// Jerk, u/s³; 0: the limit of the axis.
    pub jerk: f64,
    /// Lowest position of a synchronisation, u, with `COAXLE_HAS_MIN_POSITION`.
    pub min_position: f64,
    /// Highest position of a synchronisation, u, with `COAXLE_HAS_MAX_POSITION`.
    pub max_position: f64,
    /// Slave units per master unit (`RatioNumerator`).
    pub ratio: f64,
    /// Slave units per unit of each master.
    pub ratios: [f64; 4],
    /// Denominator of the ratio of a saw, 1 to 65535.
    pub ratio_denominator: u32,
    /// `GearInSync_CheckMask_…` and `GearInSync_OpMask_…`, TF5055.
    pub sync_mask: u32,
    /// `COAXLE_STRATEGY_NONE` to `COAXLE_STRATEGY_EARLY`.
    pub strategy: u32,
    /// `COAXLE_AT`, `COAXLE_AHEAD` or `COAXLE_IN_TURN`, of `master_sync_position`.
    pub master_sync_kind: u32,
    /// `COAXLE_AT`, `COAXLE_AHEAD` or `COAXLE_IN_TURN`, of the positions of the slave.
    pub slave_sync_kind: u32,
    /// 0.
    pub reserved: u32,
    /// Synchronisation position of the master, u of the master.
    pub master_sync_position: f64,
    /// Synchronisation position of the slave, u.
    pub slave_sync_position: f64,
    /// Distance of the master before its position at which the synchronisation begins, u, with `COAXLE_HAS_MASTER_START_DISTANCE`.
    pub master_start_distance: f64,
    /// Expected velocity of a master that stands, u/s; 0: none.
    pub master_velocity: f64,
    /// Position at which the release of a flying gear begins, u.
    pub slave_desync_position: f64,
    /// Position at which it stands, u.
    pub slave_stop_position: f64,
    /// Plate, 1 to 255; 0: the only one.
    pub table: u32,
    /// Plate that it refers to.
    pub reference_table: u32,
    /// `CAMOPERATIONMODE_…`, 0 to 3.
    pub operation: u32,
    /// `MC_STARTMODE_…`, 1 to 4.
    pub start_mode: u32,
    /// `MC_CAMACTIVATION_…`, 0 to 9.
    pub activation_mode: u32,
    /// `COAXLE_JUMP_REFUSE` to `COAXLE_JUMP_RAMP_IN`.
    pub jump: u32,
    /// Position of the master at the activation.
    pub activation_position: f64,
    /// Distance of the master on which the slave is led to a new course, u.
    pub ramp_length: f64,
    /// `MC_CAMSCALING_…` of the master, 0 to 2.
    pub master_scaling_mode: u32,
    /// `MC_CAMSCALING_…` of the slave, 0 to 2.
    pub slave_scaling_mode: u32,
    /// Offset of the master, u.
    pub master_offset: f64,
    /// Offset of the slave, u.
    pub slave_offset: f64,
    /// Scaling of the master, not 0.
    pub master_scaling: f64,
    /// Scaling of the slave.
    pub slave_scaling: f64,
    /// Number of `points`, 1 to 4.
    pub number_of_points: u32,
    /// 0.
    pub reserved_too: u32,
    /// Points to write.
    pub points: [coaxle_motion_point; 4],
}

growing! {
    coaxle_command, 504;
}

const _: () = assert!(size_of::<coaxle_command>() == 504);

/// Sets all fields of a command to what they are unless stated, but for its `struct_size`, which the caller has set.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_command_init(command: *mut coaxle_command, kind: u32) -> i32 {
    // SAFETY: as for this function.
    plain(|| unsafe {
        // Reads nothing but the size.
        let _ = writable(command, "command")?;
        let defaults = coaxle_command {
            kind,
            ratio: 1.0,
            ratios: [1.0, 0.0, 0.0, 0.0],
            number_of_ratios: 1,
            ratio_denominator: 1,
            start_mode: u32::from(StartMode::default() as u8),
            master_scaling: 1.0,
            slave_scaling: 1.0,
            ..coaxle_command::ZERO
        };
        write(command, &defaults)
    })
}
