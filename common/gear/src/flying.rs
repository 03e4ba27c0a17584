//! `MC_FlyingGear`: a gear that is engaged and released on the fly.

use coaxle_axis::{CouplingPhase, SyncPositions};
use coaxle_curve::profile::Kinematics;

mod coupling;
mod demands;
mod error;
mod range;
mod window;

pub use coupling::{FlyingGearChange, FlyingGearCoupling};
use demands::SlaveDynamics;
pub use error::FlyingGearError;
pub use range::FlyingGearRange;
use window::{GearWindow, WindowCourse};

/// Parameters of a flying gear.
///
/// `MC_FlyingGear_BkPlcMc`. The *working direction* of the slave leads from its standstill position to
/// `slave_sync_position`; the master's is equal, or opposite if the ratio is negative.
///
/// Positions are numbers when it is enabled; `P` is for other ways to state them.
#[doc(alias = "MC_FlyingGear")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(rename = "FlyingGearAt{P}")
)]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct FlyingGearParameters<P = f64> {
    /// Slave units per master unit while fully coupled, not 0.
    #[doc(alias = "Ratio")]
    pub ratio: f64,
    /// Position of the master at which the gear is fully engaged, master u.
    #[doc(alias = "MasterSyncPosition")]
    pub master_sync_position: P,
    /// Position of the slave at which the gear is fully engaged, u.
    #[doc(alias = "SlaveSyncPosition")]
    pub slave_sync_position: P,
    /// Position at which the release of the slave begins, u.
    #[doc(alias = "SlaveDesyncPosition")]
    pub slave_desync_position: P,
    /// Position at which the slave is fully released and stands, u. If it lies beyond the desync position
    /// in the working direction, the slave is released on the way out; if it lies before it, on the way
    /// back.
    #[doc(alias = "SlaveStopPosition")]
    pub slave_stop_position: P,
    /// The working direction of a slave that already stands at its sync position, and thus has no other:
    /// towards smaller positions.
    #[doc(alias = "DefaultSlaveNegative")]
    #[cfg_attr(feature = "serde", serde(default))]
    pub default_slave_negative: bool,
}

/// Phase of a flying gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum FlyingGearPhase {
    /// Enabled; the master has not reached the window yet and the slave stands at its start.
    Waiting,
    /// The gear is being engaged (`StartSync`).
    Engaging,
    /// Fully coupled (`InSync`).
    Engaged,
    /// The gear is being released.
    Releasing,
    /// The slave stands at its stop position.
    Released,
}

impl From<FlyingGearPhase> for CouplingPhase {
    fn from(phase: FlyingGearPhase) -> Self {
        match phase {
            FlyingGearPhase::Waiting => Self::Waiting,
            FlyingGearPhase::Engaging => Self::Synchronizing,
            FlyingGearPhase::Engaged => Self::InSync,
            FlyingGearPhase::Releasing => Self::Releasing,
            FlyingGearPhase::Released => Self::Released,
        }
    }
}

/// A flying gear, enabled.
///
/// The slave follows the master's position at any velocity and direction of the master:
///
/// * The gear is engaged over a master distance of 2·|slave distance|/|ratio| that ends at the sync
///   positions. Over it the slope leads from 0 to the ratio along `3x² − 2x³`, a symmetric ramp.
/// * Then the gear is rigid.
/// * It is released over the corresponding distance from the desync to the stop position.
///
/// A master that reverses inside a window leads the slave back the way it came. A slave that is released
/// at its start position is engaged again by the master's next stroke.
#[doc(alias = "MC_FlyingGear")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlyingGear {
    /// Reference of the progress of both: their sync positions.
    master_sync: f64,
    slave_sync: f64,
    /// Working directions, ±1.
    master_direction: f64,
    slave_direction: f64,
    engaging: GearWindow,
    releasing: GearWindow,
    /// True if the release leads back against the working direction.
    returns: bool,
    /// True if the slave is released at its start position.
    stops_at_start: bool,
    phase: FlyingGearPhase,
    /// True if the master has been beyond the begin of a release on the way back.
    armed: bool,
}

impl FlyingGear {
    /// Enables the gear for a slave that stands at `slave_position`.
    ///
    /// # Errors
    /// [`FlyingGearError`] with the invalid parameter, or the position at which the gear should have
    /// begun.
    pub fn enable(
        parameters: &FlyingGearParameters,
        master: &Kinematics,
        slave_position: f64,
    ) -> Result<Self, FlyingGearError> {
        // First of all: the direction comes from signs, and NaN has none.
        check_finite(parameters)?;
        let gear = Self::new(parameters, slave_position);
        gear.check_release(parameters)?;
        gear.check_master(master)?;
        Ok(gear)
    }

    fn new(parameters: &FlyingGearParameters, slave_start: f64) -> Self {
        let slave_sync = parameters.slave_sync_position;
        // Any distance gives a direction, however small. Zero is a case of its own: `signum` of 0.0 is 1.
        let slave_direction = if slave_sync == slave_start {
            if parameters.default_slave_negative {
                -1.0
            } else {
                1.0
            }
        } else {
            (slave_sync - slave_start).signum()
        };
        // Progress counts in the working direction of each axis, so the slope is
        // positive and one set of formulas serves all four combinations of directions.
        let slope = parameters.ratio.abs();
        let progress = |position: f64| (position - slave_sync) * slave_direction;
        let desync = progress(parameters.slave_desync_position);
        let stop = progress(parameters.slave_stop_position);
        Self {
            master_sync: parameters.master_sync_position,
            slave_sync,
            master_direction: slave_direction * parameters.ratio.signum(),
            slave_direction,
            engaging: GearWindow::between(0.0, progress(slave_start), slope),
            releasing: GearWindow::between(desync, stop, slope),
            // Progress grows in the working direction, so a smaller stop is on the way back.
            returns: stop < desync,
            // Only the very position: from any other one the
            // next stroke would begin with a jump to the start.
            stops_at_start: parameters.slave_stop_position == slave_start,
            phase: FlyingGearPhase::Waiting,
            armed: false,
        }
    }

    fn check_release(&self, parameters: &FlyingGearParameters) -> Result<(), FlyingGearError> {
        let FlyingGearParameters {
            slave_desync_position,
            slave_stop_position,
            ..
        } = *parameters;
        // A release over no distance would be a step of the velocity, on the way out or back.
        if slave_stop_position == slave_desync_position {
            return Err(FlyingGearError::WrongParameter {
                parameter: "slave-stop-position",
                received: slave_stop_position,
                expected: "a way from the desync position to it",
            });
        }
        // Released on the way out from before the sync position, the slave would never be coupled.
        if !self.returns && self.releasing.coupled_master < 0.0 {
            return Err(FlyingGearError::WrongParameter {
                parameter: "slave-desync-position",
                received: slave_desync_position,
                expected: "one that is not before the sync position, to be released on the way out",
            });
        }
        Ok(())
    }

    fn check_master(&self, master: &Kinematics) -> Result<(), FlyingGearError> {
        let past = self.master_progress(master) - self.engaging.free_master();
        // Written so that a position that is NaN is refused too.
        if past <= 0.0 {
            Ok(())
        } else {
            Err(FlyingGearError::MasterPastStart {
                master: master.position,
                start: self.start_position(),
            })
        }
    }

    /// Checks whether a slave can follow while its master keeps this speed, u/s.
    fn check_demands(
        &self,
        dynamics: &SlaveDynamics,
        speed: f64,
        cycle: f64,
    ) -> Result<(), FlyingGearError> {
        dynamics.check(&self.engaging, speed, cycle)?;
        dynamics.check(&self.releasing, speed, cycle)
    }

    /// Returns the position of the master at which engaging begins, master u.
    #[must_use]
    pub fn start_position(&self) -> f64 {
        self.master_sync + self.master_direction * self.engaging.free_master()
    }

    /// Returns the positions of master and slave at which it is fully engaged.
    #[must_use]
    pub const fn sync_positions(&self) -> SyncPositions {
        SyncPositions {
            master: self.master_sync,
            slave: self.slave_sync,
        }
    }

    /// Returns the slave units per master unit while fully coupled.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.slave_direction * self.master_direction * self.engaging.slope
    }

    /// Returns the phase of the gear.
    #[must_use]
    pub const fn phase(&self) -> FlyingGearPhase {
        self.phase
    }

    /// Returns the slave's set values for those of the master.
    pub fn update(&mut self, master: &Kinematics) -> Kinematics {
        let progress = self.master_progress(master);
        self.phase = self.next_phase(progress);
        let course = match self.phase {
            FlyingGearPhase::Waiting => self.engaging.freed(),
            FlyingGearPhase::Engaging => self.engaging.at(progress),
            FlyingGearPhase::Engaged => self.engaging.rigid(progress),
            FlyingGearPhase::Releasing => self.releasing.at(progress),
            FlyingGearPhase::Released => self.releasing.freed(),
        };
        self.slave_of(&course, master)
    }

    fn master_progress(&self, master: &Kinematics) -> f64 {
        (master.position - self.master_sync) * self.master_direction
    }

    fn next_phase(&mut self, progress: f64) -> FlyingGearPhase {
        // A new stroke needs both at their start: the slave
        // by its stop position, the master by its way back.
        let rests_again = self.stops_at_start && progress <= self.engaging.free_master();
        match self.phase {
            FlyingGearPhase::Released if !rests_again => FlyingGearPhase::Released,
            // A coupled slave is released first. On the way back, the window of the
            // release may be that of engaging, as in samples 1 and 2 of the manual.
            FlyingGearPhase::Engaged | FlyingGearPhase::Releasing => self.release(progress),
            _ => {
                self.armed = false;
                self.engage(progress)
            }
        }
    }

    fn engage(&mut self, progress: f64) -> FlyingGearPhase {
        // A window of no length has both ends at 0, where the master still has to pass.
        if progress >= 0.0 && progress > self.engaging.free_master() {
            self.release(progress)
        } else if progress > self.engaging.free_master() {
            // Below 0 only, so `release` calling back does not lead here again.
            FlyingGearPhase::Engaging
        } else {
            FlyingGearPhase::Waiting
        }
    }

    fn release(&mut self, progress: f64) -> FlyingGearPhase {
        let begin = self.releasing.coupled_master;
        let way = if self.returns {
            // A release on the way back begins only after the master has been beyond its begin. Otherwise
            // a slave just engaged, which is still before that place, would be released at once.
            self.armed |= progress > begin;
            begin - progress
        } else {
            self.armed = true;
            progress - begin
        };
        // The end of the window is checked before its begin: a fast master passes both within a cycle.
        if self.armed && way >= self.releasing.master_length {
            FlyingGearPhase::Released
        } else if self.armed && way >= 0.0 {
            FlyingGearPhase::Releasing
        } else if progress < 0.0 && !(self.returns && self.armed) {
            // The master reversed before the release began.
            self.armed = false;
            self.engage(progress)
        } else {
            FlyingGearPhase::Engaged
        }
    }

    fn slave_of(&self, course: &WindowCourse, master: &Kinematics) -> Kinematics {
        let v = master.velocity;
        let direction = self.slave_direction;
        // With s = f(m): v = f'·V and a = f''·V² + f'·A. In f''
        // the master's direction is squared, hence missing.
        let slope = direction * self.master_direction * course.slope;
        Kinematics {
            position: self.slave_sync + direction * course.progress,
            velocity: slope * v,
            acceleration: direction * course.curvature * v * v + slope * master.acceleration,
        }
    }
}

fn check_finite(parameters: &FlyingGearParameters) -> Result<(), FlyingGearError> {
    let FlyingGearParameters {
        ratio,
        master_sync_position,
        slave_sync_position,
        slave_desync_position,
        slave_stop_position,
        default_slave_negative: _,
    } = *parameters;
    // 0x421B is the NC's code for a coupling factor of 0; a NaN couples as little.
    if !(ratio.is_finite() && ratio != 0.0) {
        return Err(FlyingGearError::Ratio { received: ratio });
    }
    let positions = [
        ("master-sync-position", master_sync_position),
        ("slave-sync-position", slave_sync_position),
        ("slave-desync-position", slave_desync_position),
        ("slave-stop-position", slave_stop_position),
    ];
    for (parameter, received) in positions {
        if !received.is_finite() {
            return Err(FlyingGearError::WrongParameter {
                parameter,
                received,
                expected: "a finite number",
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
