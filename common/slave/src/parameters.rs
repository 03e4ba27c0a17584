//! What a slave axis can do and may do.

use coaxle_axis::guard::{EXPECTED_LIMIT, Guard, is_limit};
use coaxle_curve::profile::{InvalidLimit, Limits};
use coaxle_saw::{Saw, SawTolerances};

/// Limits of a slave axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct SlaveParameters {
    /// Highest speed, u/s.
    pub velocity: f64,
    /// Highest acceleration, u/s².
    pub acceleration: f64,
    /// Highest deceleration, u/s². The same as the acceleration by default.
    #[cfg_attr(feature = "serde", serde(default))]
    pub deceleration: Option<f64>,
    /// Highest jerk of its own motions, u/s³.
    pub jerk: f64,
    /// Lower software limit, u.
    #[cfg_attr(feature = "serde", serde(default))]
    pub min_position: Option<f64>,
    /// Upper software limit, u.
    #[cfg_attr(feature = "serde", serde(default))]
    pub max_position: Option<f64>,
    /// What it does when it is coupled and its master is lost or in error.
    #[cfg_attr(feature = "serde", serde(default))]
    pub on_master_loss: OnMasterLoss,
    /// How far its master may be back behind the coupling position of a flying saw before that
    /// counts as running back, u of the master. 0.001 by default.
    #[cfg_attr(feature = "serde", serde(default))]
    pub master_noise: Option<f64>,
    /// Given if its master is an encoder: u of the master per increment. Accelerations of less than
    /// two increments per cycle and cycle count as none then, for a flying saw (TS5055 7).
    #[cfg_attr(feature = "serde", serde(default))]
    pub master_increment: Option<f64>,
}

/// How a coupled slave stops when its master is lost or in error. It is in error stop afterwards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum OnMasterLoss {
    /// Within its limits of deceleration and jerk.
    #[default]
    Stop,
    /// With its full deceleration from the next cycle on, whatever the jerk.
    QuickStop,
}

impl SlaveParameters {
    /// What keeps the axis within them.
    pub(super) fn guard(&self) -> Result<Guard, WrongSlaveParameter> {
        let (min, max) = self.range()?;
        Ok(Guard::new(self.limits()?, min, max))
    }

    fn limits(&self) -> Result<Limits, WrongSlaveParameter> {
        let deceleration = self.deceleration.unwrap_or(self.acceleration);
        for (parameter, received) in [
            ("velocity", self.velocity),
            ("acceleration", self.acceleration),
            ("deceleration", deceleration),
            ("jerk", self.jerk),
        ] {
            if !is_limit(received) {
                return Err(wrong_limit(parameter, received));
            }
        }
        Limits::new(self.velocity, self.acceleration, deceleration, self.jerk)
            .map_err(|InvalidLimit { field, received }| wrong_limit(field, received))
    }

    /// A flying saw that takes its master so.
    pub(super) fn saw(&self) -> Result<Saw, WrongSlaveParameter> {
        let noise = self
            .master_noise
            .unwrap_or(SawTolerances::default().master_noise);
        if !(noise >= 0.0 && noise.is_finite()) {
            return Err(WrongSlaveParameter {
                parameter: "master-noise",
                received: noise,
                expected: "a finite number of at least 0",
            });
        }
        if let Some(received) = self.master_increment.filter(|given| !is_limit(*given)) {
            return Err(wrong_limit("master-increment", received));
        }
        Ok(Saw::new(noise, self.master_increment))
    }

    /// The software limits, infinite where there is none.
    fn range(&self) -> Result<(f64, f64), WrongSlaveParameter> {
        for (parameter, limit) in [
            ("min-position", self.min_position),
            ("max-position", self.max_position),
        ] {
            if let Some(received) = limit.filter(|limit| !limit.is_finite()) {
                return Err(WrongSlaveParameter {
                    parameter,
                    received,
                    expected: "a finite number",
                });
            }
        }
        let min = self.min_position.unwrap_or(f64::NEG_INFINITY);
        let max = self.max_position.unwrap_or(f64::INFINITY);
        if min < max {
            Ok((min, max))
        } else {
            Err(WrongSlaveParameter {
                parameter: "max-position",
                received: max,
                expected: "a number above min-position",
            })
        }
    }
}

const fn wrong_limit(parameter: &'static str, received: f64) -> WrongSlaveParameter {
    WrongSlaveParameter {
        parameter,
        received,
        expected: EXPECTED_LIMIT,
    }
}

/// A parameter that no slave axis can have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{parameter}: received {received}, expected {expected}")]
pub struct WrongSlaveParameter {
    /// The parameter.
    pub parameter: &'static str,
    /// Its value.
    pub received: f64,
    /// What it may be.
    pub expected: &'static str,
}
