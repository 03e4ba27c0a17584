//! Parameters, masters and state of a slave axis.

use std::sync::Arc;

use ::coaxle_axis::set_value_guard::GuardState;
use ::coaxle_axis::{AxisStatus, CouplingPhase, Modulo};
use ::coaxle_slave::{OnMasterLoss, SlaveAxis, SlaveParameters};
use coaxle_curve::profile::Kinematics;

use crate::caller_drive::{CallerDrive, DriveCells};
use crate::command::{COAXLE_HAS_MAX_POSITION, COAXLE_HAS_MIN_POSITION};
use crate::failure::Failure;
use crate::memory::growing;
use crate::phase::cycle_time;

/// Without power.
pub const COAXLE_DISABLED: u32 = 0;
/// Powered, at rest, without a job.
pub const COAXLE_STANDSTILL: u32 = 1;
/// Finding its position.
pub const COAXLE_HOMING: u32 = 2;
/// On its way to a standstill: at a position, or by a halt.
pub const COAXLE_DISCRETE_MOTION: u32 = 3;
/// At a velocity, without an end.
pub const COAXLE_CONTINUOUS_MOTION: u32 = 4;
/// Coupled to a master.
pub const COAXLE_SYNCHRONIZED_MOTION: u32 = 5;
/// Stopping; only a harder stop or the loss of power can interrupt it.
pub const COAXLE_STOPPING: u32 = 6;
/// In error, until reset.
pub const COAXLE_ERROR_STOP: u32 = 7;

/// Parameters of a slave axis.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_slave_parameters {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// `COAXLE_HAS_MIN_POSITION`, `COAXLE_HAS_MAX_POSITION`: its software limits.
    pub flags: u32,
    /// Cycle time, ns: 100 000 to 100 000 000.
    pub cycle_time_ns: i64,
    /// Highest speed, u/s.
    pub velocity: f64,
    /// Highest acceleration, u/s².
    pub acceleration: f64,
    /// Highest deceleration, u/s²; 0: that of the acceleration.
    pub deceleration: f64,
    /// Highest jerk, u/s³; 0: unlimited.
    pub jerk: f64,
    /// Lower software limit, u.
    pub min_position: f64,
    /// Upper software limit, u.
    pub max_position: f64,
    /// Modulo period of the axis, u; 0: none.
    pub modulo: f64,
    /// Modulo period of its first master, u; 0: none.
    pub master_modulo: f64,
    /// Axis id in cam plates and saw tables, 1 to 255; 0: neither plates nor saw tables.
    pub axis_id: u32,
    /// Id of its first master.
    pub master_axis_id: u32,
    /// Reaction to the loss of a master. 0: stop within the limits; 1: stop with full deceleration; 2: continued following.
    pub on_master_loss: u32,
    /// `COAXLE_DRIVE_IDEAL` or `COAXLE_DRIVE_OF_CALLER`.
    pub drive: u32,
}

/// A master in one cycle. It does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_master {
    /// Position, u of the master.
    pub position: f64,
    /// Velocity, u/s.
    pub velocity: f64,
    /// Acceleration, u/s².
    pub acceleration: f64,
    /// Other than 0 if it is there; 0 if it is lost or in error.
    pub is_there: u32,
    /// 0.
    pub reserved: u32,
}

/// Set values of a slave axis, and its state.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_slave_state {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// `COAXLE_DISABLED` to `COAXLE_ERROR_STOP`.
    pub status: u32,
    /// Set position, u.
    pub position: f64,
    /// Set velocity, u/s.
    pub velocity: f64,
    /// Set acceleration, u/s².
    pub acceleration: f64,
    /// Distance that its limits leave between it and its coupling, u.
    pub distance: f64,
    /// NC error code, 0: none.
    pub error: u32,
    /// Other than 0 if it wants its drive to have power.
    pub wants_power: u32,
    /// Other than 0 if it is coupled and in sync.
    pub is_in_sync: u32,
    /// 0: its set values are those of its motion; 1: coasting; 2: catching up; 3: its target is beyond its limits.
    pub tracking: u32,
    /// Number of presets of its position, by homing or power: its set position may have stepped by one.
    pub presets: u32,
    /// 0.
    pub reserved: u32,
}

growing! {
    coaxle_slave_parameters, 96;
    coaxle_slave_state, 64;
}

impl coaxle_slave_parameters {
    pub(crate) fn axis(&self) -> Result<(SlaveAxis, Arc<DriveCells>), Failure> {
        let limits = SlaveParameters {
            deceleration: (self.deceleration != 0.0).then_some(self.deceleration),
            min_position: self.limit(COAXLE_HAS_MIN_POSITION, self.min_position),
            max_position: self.limit(COAXLE_HAS_MAX_POSITION, self.max_position),
            on_master_loss: match self.on_master_loss {
                0 => OnMasterLoss::Stop,
                1 => OnMasterLoss::QuickStop,
                2 => OnMasterLoss::Follow,
                other => return Err(Failure::range("on_master_loss", other, "0, 1 or 2")),
            },
            ..SlaveParameters::new(self.velocity, self.acceleration, self.jerk())
        };
        let drive = DriveCells::new(self.drive)?;
        let cycle_time = cycle_time(self.cycle_time_ns)?;
        let own_end = Box::new(CallerDrive(Arc::clone(&drive)));
        let mut axis = SlaveAxis::new(&limits, own_end, cycle_time)
            .map_err(|wrong| Failure::range(wrong.parameter, wrong.received, wrong.expected))?;
        axis.set_modulo(
            modulo("modulo", self.modulo)?,
            modulo("master_modulo", self.master_modulo)?,
        );
        if self.axis_id != 0 {
            (axis.prepare_cams(self.master_axis_id, self.axis_id))
                .map_err(|wrong| Failure::of_nc(wrong.code(), wrong))?;
        }
        Ok((axis, drive))
    }

    fn limit(&self, flag: u32, position: f64) -> Option<f64> {
        (self.flags & flag != 0).then_some(position)
    }

    fn jerk(&self) -> f64 {
        // The largest of all limits is none in effect.
        if self.jerk == 0.0 { 1e15 } else { self.jerk }
    }
}

fn modulo(field: &str, length: f64) -> Result<Option<Modulo>, Failure> {
    if length == 0.0 {
        return Ok(None);
    }
    let wrong = |_| Failure::range(field, length, "0, or a finite number above 0");
    Modulo::new(length).map(Some).map_err(wrong)
}

impl coaxle_master {
    pub(crate) fn set_values(&self) -> Option<Kinematics> {
        let set = Kinematics {
            position: self.position,
            velocity: self.velocity,
            acceleration: self.acceleration,
        };
        // One that is not a number is no master.
        let is_finite = [set.position, set.velocity, set.acceleration]
            .iter()
            .all(|of| of.is_finite());
        (self.is_there != 0 && is_finite).then_some(set)
    }
}

impl coaxle_slave_state {
    pub(crate) fn of(axis: &SlaveAxis, wants_power: bool) -> Self {
        let set = axis.set();
        Self {
            struct_size: 0,
            status: status(axis.status()),
            position: set.position,
            velocity: set.velocity,
            acceleration: set.acceleration,
            distance: axis.distance(),
            error: axis.error().map_or(0, |error| error.code()),
            wants_power: wants_power.into(),
            is_in_sync: axis
                .coupling_phase()
                .is_some_and(CouplingPhase::is_in_sync)
                .into(),
            tracking: tracking(axis.tracking()),
            presets: axis.preset_count(),
            reserved: 0,
        }
    }
}

/// The number of a state in C.
pub(crate) const fn status(status: AxisStatus) -> u32 {
    match status {
        AxisStatus::Disabled => COAXLE_DISABLED,
        AxisStatus::Standstill => COAXLE_STANDSTILL,
        AxisStatus::Homing => COAXLE_HOMING,
        AxisStatus::DiscreteMotion => COAXLE_DISCRETE_MOTION,
        AxisStatus::ContinuousMotion => COAXLE_CONTINUOUS_MOTION,
        AxisStatus::SynchronizedMotion => COAXLE_SYNCHRONIZED_MOTION,
        AxisStatus::Stopping => COAXLE_STOPPING,
        AxisStatus::ErrorStop => COAXLE_ERROR_STOP,
    }
}

/// The number of a last stage's state in C.
pub(crate) const fn tracking(state: GuardState) -> u32 {
    match state {
        GuardState::Tracking => 0,
        GuardState::Coasting => 1,
        GuardState::CatchingUp => 2,
        GuardState::Cannot => 3,
    }
}
