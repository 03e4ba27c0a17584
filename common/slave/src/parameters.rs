//! Parameters of a slave axis.

use coaxle_axis::guard::{EXPECTED_LIMIT, Guard, is_limit};
use coaxle_axis::set_value_guard::{DistancePolicy, SetValueGuard};
use coaxle_axis::{CouplingPhase, WindowMonitor};
use coaxle_clock::{CycleTime, Seconds};
use coaxle_curve::profile::{InvalidLimit, Kinematics, Limits};
use coaxle_saw::{Saw, SawTolerances};

/// Limits of a slave axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct SlaveParameters {
    /// Highest speed, u/s.
    pub velocity: f64,
    /// Highest acceleration, u/s².
    pub acceleration: f64,
    /// Highest deceleration, u/s². Equal to the acceleration by default.
    #[cfg_attr(feature = "serde", serde(default))]
    pub deceleration: Option<f64>,
    /// Highest jerk, u/s³. Unlimited by default: the acceleration then changes within a cycle.
    #[cfg_attr(feature = "serde", serde(default = "no_jerk_limit"))]
    pub jerk: f64,
    /// Lower software limit, u.
    #[cfg_attr(feature = "serde", serde(default))]
    pub min_position: Option<f64>,
    /// Upper software limit, u.
    #[cfg_attr(feature = "serde", serde(default))]
    pub max_position: Option<f64>,
    /// Reaction of a coupled slave to a master that is lost or in error.
    #[cfg_attr(feature = "serde", serde(default))]
    pub on_master_loss: OnMasterLoss,
    /// Handling of the distance that the limits leave between the axis and the position of its coupling.
    #[cfg_attr(feature = "serde", serde(default))]
    pub distance: DistanceParameters,
    /// Greatest return of its master behind the coupling position of a flying saw that does not
    /// count as running back, u of the master. 0.001 by default.
    #[cfg_attr(feature = "serde", serde(default))]
    pub master_noise: Option<f64>,
    /// Given if its master is an encoder: u of the master per increment. Accelerations of less than
    /// two increments per cycle and cycle then count as zero, for a flying saw (TS5055 7).
    #[cfg_attr(feature = "serde", serde(default))]
    pub master_increment: Option<f64>,
}

/// The largest of all limits: a jerk within it is not limited in effect.
#[cfg(feature = "serde")]
const fn no_jerk_limit() -> f64 {
    // No limit may be larger: see `is_limit`.
    1e15
}

/// Reaction of a coupled slave to a master that is lost or in error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum OnMasterLoss {
    /// Stop within its limits of deceleration and jerk, and error stop.
    #[default]
    Stop,
    /// Stop with its full deceleration from the next cycle on, without a jerk limit, and error stop.
    QuickStop,
    /// Continued following: a lost far axis is braked, and returned when it is back. The slave is
    /// coupled from the start as soon as there is a master, even before its clock is known.
    Follow,
}

/// Handling of the distance that the limits leave between the axis and the position of its
/// coupling, and the bounds from which it is a fault.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct DistanceParameters {
    /// Catching up of the distance, or keeping it.
    pub policy: DistancePolicy,
    /// Greatest distance that the axis may be left behind, u; 0: not monitored. By default the
    /// distance moved in 0.1 s at its highest velocity. A distance that the policy keeps is not
    /// monitored.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub window: Option<f64>,
    /// Time for which that distance may be exceeded, s. 0.1 by default.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub time_s: Option<f64>,
    /// Greatest distance of the set position from the position of the coupling in sync, u. By
    /// default the effect of the jerk limit within a cycle (at most the jerk that reverses the
    /// acceleration in a cycle), plus the distance of a microsecond at the highest velocity, which
    /// is the precision of a master's time: j·T³ + v·1 µs. A distance that the policy keeps does
    /// not count.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub in_sync_window: Option<f64>,
}

/// Default window, as a time at the highest velocity, s,
const WINDOW: f64 = 0.1;
/// and default time for which it may be exceeded, s.
const WINDOW_TIME: f64 = 0.1;

impl SlaveParameters {
    /// Creates parameters of the dynamics, without software limits and with defaults for the rest.
    /// In u/s, u/s² (for acceleration and deceleration) and u/s³.
    #[must_use]
    pub const fn new(velocity: f64, acceleration: f64, jerk: f64) -> Self {
        Self {
            velocity,
            acceleration,
            deceleration: None,
            jerk,
            min_position: None,
            max_position: None,
            on_master_loss: OnMasterLoss::Stop,
            distance: DistanceParameters {
                policy: DistancePolicy::PosSync1,
                window: None,
                time_s: None,
                in_sync_window: None,
            },
            master_noise: None,
            master_increment: None,
        }
    }

    /// The guard that keeps the set values within them, for every motion, from `here` on.
    pub(super) fn set_value_guard(
        &self,
        cycle_time: CycleTime,
        here: &Kinematics,
    ) -> Result<SetValueGuard, WrongSlaveParameter> {
        let (min, max) = self.range()?;
        let cycle = Seconds(cycle_time.as_secs_f64());
        let guard = SetValueGuard::new(&self.limits()?, min, max, cycle, here);
        let mut guard =
            guard.map_err(|InvalidLimit { field, received }| wrong_limit(field, received))?;
        guard.set_distance_policy(self.distance.policy);
        Ok(guard)
    }

    /// The monitor of the distance of the axis.
    pub(super) fn window_monitor(&self) -> Result<WindowMonitor, WrongSlaveParameter> {
        let DistanceParameters {
            window,
            time_s,
            in_sync_window,
            ..
        } = self.distance;
        for (parameter, received) in [
            ("distance.window", window),
            ("distance.time-s", time_s),
            ("distance.in-sync-window", in_sync_window),
        ] {
            // NaN fails the comparison, and is refused with the negative ones.
            if let Some(received) = received.filter(|given| !(*given >= 0.0 && given.is_finite())) {
                return Err(WrongSlaveParameter {
                    parameter,
                    received,
                    expected: "a finite number of at least 0",
                });
            }
        }
        Ok(WindowMonitor::new(
            // In time rather than in length, so that the default suits axes of any speed.
            window.unwrap_or(WINDOW * self.velocity),
            time_s.unwrap_or(WINDOW_TIME),
        ))
    }

    /// Greatest distance of the axis from the position of its coupling in sync, u: as configured,
    /// or [derived from its limits](CouplingPhase::in_sync_window).
    ///
    /// # Errors
    /// The invalid limit.
    pub fn in_sync_window(&self, cycle_time: CycleTime) -> Result<f64, WrongSlaveParameter> {
        let by_limits =
            CouplingPhase::in_sync_window(&self.limits()?, Seconds(cycle_time.as_secs_f64()));
        Ok(self.distance.in_sync_window.unwrap_or(by_limits))
    }

    /// The guard that checks motions before they begin.
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
            // Within this range no square or quotient of limits overflows.
            if !is_limit(received) {
                return Err(wrong_limit(parameter, received));
            }
        }
        Limits::new(self.velocity, self.acceleration, deceleration, self.jerk)
            .map_err(|InvalidLimit { field, received }| wrong_limit(field, received))
    }

    /// A flying saw with these parameters of its master.
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

    /// The software limits, infinite if there is none.
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
        // Infinities need no branch in a comparison, unlike an absent limit.
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

/// An invalid parameter of a slave axis.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{parameter}: received {received}, expected {expected}")]
pub struct WrongSlaveParameter {
    /// The parameter.
    pub parameter: &'static str,
    /// Value received.
    pub received: f64,
    /// Value expected.
    pub expected: &'static str,
}
