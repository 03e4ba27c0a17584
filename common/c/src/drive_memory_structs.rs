//! Structs of the memory of a drive.

use ::coaxle_axis::drive::{Actual, DriveState};

use crate::caller_drive::{
    COAXLE_DRIVE_FOLLOWING, COAXLE_DRIVE_OFF, COAXLE_DRIVE_SWITCHING_ON, COAXLE_DRIVE_TRIPPED,
    coaxle_actual,
};
use crate::memory::growing;

/// No power, or not yet.
pub const COAXLE_PROCESS_OFF: u32 = 0;
/// The drive follows its set position.
pub const COAXLE_PROCESS_FOLLOWING: u32 = 1;
/// The drive has an error, until `resets` of the set values changes.
pub const COAXLE_PROCESS_ERROR: u32 = 2;

/// Set values of a cycle of the node, for the process of a drive.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_drive_set_values {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// 1: switch power on and follow; 0: no power, and the other set values are undefined.
    pub is_enabled: u32,
    /// Incremented in each cycle of the node.
    pub counter: u64,
    /// Ideal start of that cycle, ns of `CLOCK_MONOTONIC`: the instant of the set values.
    pub ideal_start_ns: i64,
    /// Set position, u.
    pub position: f64,
    /// Set velocity, u/s.
    pub velocity: f64,
    /// Set acceleration, u/s².
    pub acceleration: f64,
    /// A changed number: acknowledge errors.
    pub resets: u64,
}

/// Actual values of a drive, as its process reports them.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_drive_values {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// `COAXLE_PROCESS_OFF` to `COAXLE_PROCESS_ERROR`.
    pub state: u32,
    /// Error code of the drive, 0 without an error.
    pub error: u32,
    /// 0.
    pub reserved: u32,
    /// Counter of the set values that were read.
    pub counter: u64,
    /// Number of `resets` that was executed.
    pub resets: u64,
    /// Actual position, u.
    pub position: f64,
    /// Actual velocity, u/s.
    pub velocity: f64,
}

/// Parameters of the node's end.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_drive_memory_parameters {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// Axis id of the slave.
    pub axis_id: u32,
    /// Number of this run of the node, any other than the one before.
    pub run: u64,
    /// Nominal cycle time of the node, ns.
    pub cycle_time_ns: i64,
    /// Cycles without a heartbeat of the process, 1 to 100 000.
    pub max_silent_cycles: u32,
    /// Cycles from the request for power until the drive must follow.
    pub switch_on_cycles: u32,
    /// Largest following error, u; above 0.
    pub following_error_window: f64,
    /// Time for which it may be exceeded, s.
    pub following_error_time_s: f64,
}

/// A cycle of the node.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_drive_memory_command {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// Other than 0: switch power on and follow.
    pub wants_power: u32,
    /// Ideal start of the cycle, ns of `CLOCK_MONOTONIC`.
    pub ideal_start_ns: i64,
    /// Time since the cycle before, s.
    pub elapsed_s: f64,
    /// Set position, u.
    pub position: f64,
    /// Set velocity, u/s.
    pub velocity: f64,
    /// Set acceleration, u/s².
    pub acceleration: f64,
}

growing! {
    coaxle_drive_set_values, 56;
    coaxle_drive_values, 48;
    coaxle_drive_memory_parameters, 48;
    coaxle_drive_memory_command, 48;
}

impl coaxle_actual {
    pub(crate) const fn of(actual: &Actual) -> Self {
        Self {
            struct_size: 0,
            state: match actual.state {
                DriveState::Off => COAXLE_DRIVE_OFF,
                DriveState::SwitchingOn => COAXLE_DRIVE_SWITCHING_ON,
                DriveState::Following => COAXLE_DRIVE_FOLLOWING,
                DriveState::Tripped => COAXLE_DRIVE_TRIPPED,
            },
            position: actual.position,
            velocity: actual.velocity,
            following_error: actual.following_error,
        }
    }
}
