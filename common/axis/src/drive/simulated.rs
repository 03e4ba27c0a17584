//! A simulated servo drive with a following-error monitor.
//!
//! Position interface: each cycle provides a set position. The drive differentiates it for its
//! velocity feed-forward, adds a proportional position controller, and follows that command with
//! first-order lag. A beat in the set position is visible as a jerk in the actual velocity.

use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

use super::{Actual, Drive, DriveFault, DriveKind, DriveState};
use crate::window_monitor::WindowMonitor;

/// The drive.
#[derive(Clone, Copy, Debug)]
pub struct SimulatedDrive {
    parameters: DriveParameters,
    monitor: WindowMonitor,
    state: DriveState,
    position: f64,
    velocity: f64,
    last_set: f64,
    lag: Lag,
}

/// Remainder of a deviation after a cycle of a first-order lag, kept because cycles have equal
/// lengths, except skipped ones.
#[derive(Clone, Copy, Debug)]
struct Lag {
    dt: f64,
    left: f64,
}

impl Lag {
    fn left_after(&mut self, dt: f64, lag: f64) -> f64 {
        // Equal cycles need no exponential, which is the costly part of a step.
        if dt.to_bits() != self.dt.to_bits() {
            // Without a lag nothing is left, and 0/0 would be NaN.
            let left = if lag > 0.0 { libm::exp(-dt / lag) } else { 0.0 };
            *self = Self { dt, left };
        }
        self.left
    }
}

/// The drive's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct DriveParameters {
    /// Gain of the position controller, 1/s.
    pub position_gain: f64,
    /// Lag of the velocity controller, s.
    #[cfg_attr(feature = "serde", serde(rename = "velocity-lag-s"))]
    pub velocity_lag: f64,
    /// Highest velocity, u/s; 0: no limit.
    pub max_velocity: f64,
    /// Largest following error, u; 0: not monitored.
    pub following_error_window: f64,
    /// Time for which the following error may exceed its window, s.
    #[cfg_attr(feature = "serde", serde(rename = "following-error-time-s"))]
    pub following_error_time: f64,
}

impl Default for DriveParameters {
    fn default() -> Self {
        Self {
            position_gain: 50.0,
            velocity_lag: 0.001,
            max_velocity: 0.0,
            following_error_window: 0.0,
            following_error_time: 0.02,
        }
    }
}

/// An invalid constant of a drive.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{parameter} is {received}, expected {expected}")]
pub struct WrongDriveParameter {
    /// The parameter.
    pub parameter: &'static str,
    /// Value received.
    pub received: f64,
    /// Value expected.
    pub expected: &'static str,
}

impl SimulatedDrive {
    /// Creates a drive without power, at position 0.
    ///
    /// # Errors
    /// [`WrongDriveParameter`] names the constant that is not a finite number of at least 0.
    pub fn new(parameters: DriveParameters) -> Result<Self, WrongDriveParameter> {
        let checks = [
            ("position-gain", parameters.position_gain),
            ("velocity-lag-s", parameters.velocity_lag),
            ("max-velocity", parameters.max_velocity),
            ("following-error-window", parameters.following_error_window),
            ("following-error-time-s", parameters.following_error_time),
        ];
        for (parameter, received) in checks {
            if !(received.is_finite() && received >= 0.0) {
                return Err(WrongDriveParameter {
                    parameter,
                    received,
                    expected: "a finite number of at least 0",
                });
            }
        }
        let DriveParameters {
            following_error_window: window,
            following_error_time: time,
            ..
        } = parameters;
        Ok(Self {
            parameters,
            monitor: WindowMonitor::new(window, time),
            state: DriveState::Off,
            position: 0.0,
            velocity: 0.0,
            last_set: 0.0,
            // After no time the whole deviation remains.
            lag: Lag { dt: 0.0, left: 1.0 },
        })
    }

    fn following_error(&self) -> f64 {
        match self.state {
            DriveState::Off => 0.0,
            _ => self.last_set - self.position,
        }
    }

    fn possible(&self, command: f64) -> f64 {
        match self.parameters.max_velocity {
            0.0 => command,
            most => command.clamp(-most, most),
        }
    }

    /// A sampled controller that corrects more than half of its error per cycle rings.
    fn gain(&self, dt: f64) -> f64 {
        self.parameters.position_gain.min(0.5 / dt)
    }

    /// The exact response of a first-order lag to a command held for `dt`.
    fn follow(&mut self, command: f64, dt: f64) {
        let lag = self.parameters.velocity_lag;
        let left = self.lag.left_after(dt, lag);
        let excess = self.velocity - command;
        // v(t) = c + (v₀ - c)·e^(-t/τ) and its integral: exact, so stable for any ratio of cycle and lag.
        self.position += command * dt + excess * lag * (1.0 - left);
        self.velocity = command + excess * left;
    }
}

impl Drive for SimulatedDrive {
    /// Switches power on at `position` and `velocity`, like the mechanics.
    fn power_on(&mut self, position: f64, velocity: f64) {
        if self.state == DriveState::Off {
            self.state = DriveState::Following;
            self.position = position;
            self.velocity = velocity;
            self.last_set = position;
            self.monitor.forget();
        }
    }

    fn reset(&mut self) {
        self.state = DriveState::Off;
        self.velocity = 0.0;
    }

    fn step(&mut self, set: &Kinematics, Seconds(dt): Seconds) {
        let command = match self.state {
            DriveState::Off | DriveState::SwitchingOn => return,
            // Braked by the lag of its velocity controller, as a drive without set values.
            DriveState::Tripped => 0.0,
            DriveState::Following => {
                let feed_forward = (set.position - self.last_set) / dt;
                // Controlled towards the previous set position, which it should have reached by now.
                feed_forward + self.gain(dt) * (self.last_set - self.position)
            }
        };
        self.last_set = set.position;
        self.follow(self.possible(command), dt);
        if self.monitor.trips(self.following_error(), Seconds(dt)) {
            self.state = DriveState::Tripped;
        }
    }

    fn actual(&self) -> Actual {
        let following_error = self.following_error();
        let tripped = self.state == DriveState::Tripped;
        Actual {
            state: self.state,
            position: self.position,
            velocity: self.velocity,
            following_error,
            fault: tripped.then_some(DriveFault::FollowingError { following_error }),
            attachment: None,
        }
    }

    fn kind(&self) -> DriveKind {
        DriveKind::Simulated
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-3;

    fn drive(window: f64) -> SimulatedDrive {
        SimulatedDrive::new(DriveParameters {
            max_velocity: 2_000.0,
            following_error_window: window,
            ..DriveParameters::default()
        })
        .unwrap()
    }

    fn step(drive: &mut SimulatedDrive, position: f64) {
        let set = Kinematics::at_rest(position);
        drive.step(&set, Seconds(DT));
    }

    #[test]
    fn without_power_it_stands() {
        let mut drive = drive(0.0);
        step(&mut drive, 5.0);
        assert_eq!(
            (drive.actual().position, drive.actual().velocity),
            (0.0, 0.0)
        );
    }

    #[test]
    fn constant_velocity_is_followed_with_a_vanishing_error() {
        let mut drive = drive(0.0);
        drive.power_on(0.0, 0.0);
        for k in 1..2_000 {
            step(&mut drive, 500.0 * DT * f64::from(k));
        }
        assert!((drive.actual().velocity / 500.0 - 1.0).abs() < 1e-9);
        assert!(drive.actual().following_error.abs() < 1e-6);
    }

    #[test]
    fn a_set_position_read_twice_is_a_jerk_of_the_actual_velocity() {
        let mut drive = drive(0.0);
        drive.power_on(0.0, 500.0);
        let mut lowest = f64::MAX;
        for k in 1..1_000 {
            let read = if k == 500 { k - 1 } else { k };
            step(&mut drive, 500.0 * DT * f64::from(read));
            lowest = lowest.min(drive.actual().velocity);
        }
        // For one cycle the feed-forward is 0, and a lag of one cycle follows it by 1 - 1/e.
        assert!(lowest < 0.5 * 500.0, "{lowest}");
    }

    #[test]
    fn a_large_following_error_trips_after_its_time_and_stays() {
        let mut drive = drive(1.0);
        drive.power_on(0.0, 0.0);
        let tripped = (1..1_000).find(|_| {
            step(&mut drive, 1_000.0);
            drive.actual().state == DriveState::Tripped
        });
        // Exceeded from the first cycle, for more than 20 ms.
        assert!(matches!(tripped, Some(20 | 21)), "after 20 ms: {tripped:?}");
        for _ in 0..100 {
            step(&mut drive, 1_000.0);
        }
        assert_eq!(drive.actual().state, DriveState::Tripped);
        assert!(drive.actual().velocity.abs() < 1e-6);
        drive.power_on(0.0, 0.0);
        assert_eq!(
            drive.actual().state,
            DriveState::Tripped,
            "no restart by itself"
        );
        drive.reset();
        assert_eq!(drive.actual().state, DriveState::Off);
    }

    #[test]
    fn constants_out_of_range_are_named() {
        let wrong = SimulatedDrive::new(DriveParameters {
            velocity_lag: -1.0,
            ..DriveParameters::default()
        })
        .unwrap_err();
        assert_eq!(wrong.parameter, "velocity-lag-s");
    }
}
