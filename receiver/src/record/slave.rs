//! One slave in one cycle.

use coaxle_motion::axis::AxisStatus;
use coaxle_motion::slave::CouplingPhase;
use serde::{Deserialize, Serialize};

use super::DriveStateName;
use crate::program::ProgramState;
use crate::snapshot::SlaveSnapshot;

/// A slave's part of a row. Positions are in its units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SlaveRecord {
    /// Set position, u; none until it is coupled, if it only follows its gear.
    pub position: Option<f64>,
    /// Set velocity, u/s.
    pub velocity: Option<f64>,
    /// Set acceleration, u/s².
    pub acceleration: Option<f64>,
    /// Its state in the PLCopen diagram.
    pub state: AxisStatus,
    /// How far its coupling is; none without one.
    pub phase: Option<CouplingPhase>,
    /// Why it is in error stop, by the NC's code; 0: it is not.
    pub error: u32,
    /// Why a command was refused last, by the NC's code; 0: none was.
    pub refusal: u32,
    /// Whether its program goes on; none without one.
    pub program: Option<ProgramState>,
    /// The step that its program waits for, or ended with, from 1.
    pub step: Option<u16>,
    /// Cuts done so far, by its tool or by steps of its program.
    pub cuts: u64,
    /// The drive's state.
    pub drive_state: DriveStateName,
    /// Actual position, u.
    pub drive_position: f64,
    /// Actual velocity, u/s.
    pub drive_velocity: f64,
    /// Following error, u.
    pub following_error: f64,
}

impl SlaveRecord {
    /// The columns of all fields, in their order.
    pub(super) const COLUMNS: [&'static str; 14] = [
        "slave_position",
        "slave_velocity",
        "slave_acceleration",
        "slave_state",
        "slave_phase",
        "slave_error",
        "slave_refusal",
        "program_state",
        "program_step",
        "cuts",
        "drive_state",
        "drive_position",
        "drive_velocity",
        "following_error",
    ];

    pub(super) fn new(slave: &SlaveSnapshot) -> Self {
        let set = slave.set;
        Self {
            position: set.map(|set| set.position),
            velocity: set.map(|set| set.velocity),
            acceleration: set.map(|set| set.acceleration),
            state: slave.status,
            phase: slave.phase,
            error: slave.error.map_or(0, |error| error.code()),
            refusal: slave.refusal.map_or(0, |refusal| refusal.code()),
            program: slave.program.map(|program| program.state),
            step: slave.program.map(|program| program.step),
            cuts: slave.cuts,
            drive_state: slave.drive.state.into(),
            drive_position: slave.drive.position,
            drive_velocity: slave.drive.velocity,
            following_error: slave.drive.following_error,
        }
    }
}
