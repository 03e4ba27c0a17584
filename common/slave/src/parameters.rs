//! What a slave axis can do and may do.

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
    /// Highest deceleration, u/s². The same as the acceleration by default.
    #[cfg_attr(feature = "serde", serde(default))]
    pub deceleration: Option<f64>,
    /// Highest jerk, u/s³. None if it is not given: the acceleration changes within a cycle.
    #[cfg_attr(feature = "serde", serde(default = "no_jerk_limit"))]
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
    /// What becomes of a distance that the limits have left between the axis and where its coupling has it.
    #[cfg_attr(feature = "serde", serde(default))]
    pub distance: DistanceParameters,
    /// How far its master may be back behind the coupling position of a flying saw before that
    /// counts as running back, u of the master. 0.001 by default.
    #[cfg_attr(feature = "serde", serde(default))]
    pub master_noise: Option<f64>,
    /// Given if its master is an encoder: u of the master per increment. Accelerations of less than
    /// two increments per cycle and cycle count as none then, for a flying saw (TS5055 7).
    #[cfg_attr(feature = "serde", serde(default))]
    pub master_increment: Option<f64>,
}

/// The largest of all limits: a jerk within it is whatever the acceleration needs.
#[cfg(feature = "serde")]
const fn no_jerk_limit() -> f64 {
    1e15
}

/// What a coupled slave does when its master is lost or in error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum OnMasterLoss {
    /// It stops within its limits of deceleration and jerk, and is in error stop.
    #[default]
    Stop,
    /// It stops with its full deceleration from the next cycle on, whatever the jerk, and is in error stop.
    QuickStop,
    /// It goes on following: a far axis that is lost is braked, and brought back when it returns. It is
    /// coupled from the start as soon as there is a master, even before its clock is known.
    Follow,
}

/// What becomes of a distance that the limits have left between the axis and where its coupling has it, and
/// from when on it is a fault.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct DistanceParameters {
    /// Whether it is caught up, or stays.
    pub policy: DistancePolicy,
    /// How far the axis may be left behind, u; 0: not watched. By default as far as it goes in 0.1 s at its
    /// highest velocity. A distance that the policy lets stay is not watched.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub window: Option<f64>,
    /// How long it may be farther than that, s. 0.1 by default.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub time_s: Option<f64>,
    /// How far the set position may be from where the coupling has it while the axis is in sync, u. By default what
    /// the jerk limit comes to within a cycle (with no more jerk than turns the acceleration round in a cycle), and the way
    /// of a microsecond at the highest velocity, which is what the time of a master is known to: j·T³ + v·1 µs.
    /// A distance that the policy lets stay does not count.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub in_sync_window: Option<f64>,
}

/// The default window is the way of so many seconds at the highest velocity,
const WINDOW: f64 = 0.1;
/// and may be left for so many.
const WINDOW_TIME: f64 = 0.1;

impl SlaveParameters {
    /// What they say of the dynamics, and nothing else: no software limits, the defaults for the rest.
    /// In u/s, u/s² (up and down alike) and u/s³.
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

    /// What keeps the set values within them, whatever moves the axis, from `here` on.
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

    /// What watches how far the axis is left behind.
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
            if let Some(received) = received.filter(|given| !(*given >= 0.0 && given.is_finite())) {
                return Err(WrongSlaveParameter {
                    parameter,
                    received,
                    expected: "a finite number of at least 0",
                });
            }
        }
        Ok(WindowMonitor::new(
            window.unwrap_or(WINDOW * self.velocity),
            time_s.unwrap_or(WINDOW_TIME),
        ))
    }

    /// How far the axis may be from where its coupling has it and be in sync, u: what is given, or
    /// [what its limits need](CouplingPhase::in_sync_window).
    ///
    /// # Errors
    /// The limit that is none.
    pub fn in_sync_window(&self, cycle_time: CycleTime) -> Result<f64, WrongSlaveParameter> {
        let by_limits =
            CouplingPhase::in_sync_window(&self.limits()?, Seconds(cycle_time.as_secs_f64()));
        Ok(self.distance.in_sync_window.unwrap_or(by_limits))
    }

    /// What motions are checked against before they begin.
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
