//! A simulated servo drive with a following-error monitor.
//!
//! Position interface: each cycle brings a set position. The drive differentiates it for its
//! velocity feed-forward, adds a proportional position controller, and follows that command with
//! first-order lag. A beat in the set position shows up as what it is: a jerk in the actual velocity.

use core::fmt;

/// The drive.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    parameters: DriveParameters,
    state: DriveState,
    position: f64,
    velocity: f64,
    last_set: f64,
    /// How long the following error has been beyond its window, s.
    beyond: f64,
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
    /// Fastest it can move, u/s; 0: no limit.
    pub max_velocity: f64,
    /// Largest following error, u; 0: not watched.
    pub following_error_window: f64,
    /// How long the following error may be beyond its window, s.
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

/// Whether the drive moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DriveState {
    /// No power: it stands where it stands.
    #[default]
    Off,
    /// It follows its set position.
    Following,
    /// The following error was too large for too long: it comes to rest and stays, until reset.
    Tripped,
}

/// A constant that no drive can have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrongDriveParameter {
    /// The parameter.
    pub parameter: &'static str,
    /// Its value.
    pub received: f64,
    /// What it may be.
    pub expected: &'static str,
}

impl fmt::Display for WrongDriveParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} is {}, expected {}",
            self.parameter, self.received, self.expected
        )
    }
}

impl core::error::Error for WrongDriveParameter {}

impl Drive {
    /// A drive without power, at position 0.
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
        Ok(Self {
            parameters,
            state: DriveState::Off,
            position: 0.0,
            velocity: 0.0,
            last_set: 0.0,
            beyond: 0.0,
        })
    }

    /// Power on, standing at `position` and moving at `velocity` as the mechanics do. A tripped
    /// drive stays tripped.
    pub fn power_on(&mut self, position: f64, velocity: f64) {
        if self.state == DriveState::Off {
            self.state = DriveState::Following;
            self.position = position;
            self.velocity = velocity;
            self.last_set = position;
            self.beyond = 0.0;
        }
    }

    /// Acknowledges a trip: power is off afterwards.
    pub fn reset(&mut self) {
        self.state = DriveState::Off;
        self.velocity = 0.0;
    }

    /// `dt` seconds towards `set_position`.
    pub fn step(&mut self, set_position: f64, dt: f64) {
        let command = match self.state {
            DriveState::Off => return,
            DriveState::Tripped => 0.0,
            DriveState::Following => {
                let feed_forward = (set_position - self.last_set) / dt;
                feed_forward + self.gain(dt) * (self.last_set - self.position)
            }
        };
        self.last_set = set_position;
        self.follow(self.possible(command), dt);
        self.watch(dt);
    }

    /// Whether it moves.
    #[must_use]
    pub const fn state(&self) -> DriveState {
        self.state
    }

    /// Actual position, u.
    #[must_use]
    pub const fn position(&self) -> f64 {
        self.position
    }

    /// Actual velocity, u/s.
    #[must_use]
    pub const fn velocity(&self) -> f64 {
        self.velocity
    }

    /// Set minus actual position, u.
    #[must_use]
    pub fn following_error(&self) -> f64 {
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

    /// The exact answer of a first-order lag to a command held for `dt`.
    fn follow(&mut self, command: f64, dt: f64) {
        let lag = self.parameters.velocity_lag;
        let left = if lag > 0.0 { libm::exp(-dt / lag) } else { 0.0 };
        let excess = self.velocity - command;
        self.position += command * dt + excess * lag * (1.0 - left);
        self.velocity = command + excess * left;
    }

    fn watch(&mut self, dt: f64) {
        let window = self.parameters.following_error_window;
        let beyond = window > 0.0 && self.following_error().abs() > window;
        self.beyond = if beyond { self.beyond + dt } else { 0.0 };
        if beyond && self.beyond > self.parameters.following_error_time {
            self.state = DriveState::Tripped;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-3;

    fn drive(window: f64) -> Drive {
        Drive::new(DriveParameters {
            max_velocity: 2_000.0,
            following_error_window: window,
            ..DriveParameters::default()
        })
        .unwrap()
    }

    #[test]
    fn without_power_it_stands() {
        let mut drive = drive(0.0);
        drive.step(5.0, DT);
        assert_eq!((drive.position(), drive.velocity()), (0.0, 0.0));
    }

    #[test]
    fn constant_velocity_is_followed_with_a_vanishing_error() {
        let mut drive = drive(0.0);
        drive.power_on(0.0, 0.0);
        for k in 1..2_000 {
            drive.step(500.0 * DT * f64::from(k), DT);
        }
        assert!((drive.velocity() / 500.0 - 1.0).abs() < 1e-9);
        assert!(drive.following_error().abs() < 1e-6);
    }

    #[test]
    fn a_set_position_read_twice_is_a_jerk_of_the_actual_velocity() {
        let mut drive = drive(0.0);
        drive.power_on(0.0, 500.0);
        let mut lowest = f64::MAX;
        for k in 1..1_000 {
            let read = if k == 500 { k - 1 } else { k };
            drive.step(500.0 * DT * f64::from(read), DT);
            lowest = lowest.min(drive.velocity());
        }
        assert!(lowest < 0.5 * 500.0, "{lowest}");
    }

    #[test]
    fn a_large_following_error_trips_after_its_time_and_stays() {
        let mut drive = drive(1.0);
        drive.power_on(0.0, 0.0);
        let tripped = (1..1_000).find(|_| {
            drive.step(1_000.0, DT);
            drive.state() == DriveState::Tripped
        });
        assert!(matches!(tripped, Some(20 | 21)), "after 20 ms: {tripped:?}");
        for _ in 0..100 {
            drive.step(1_000.0, DT);
        }
        assert_eq!(drive.state(), DriveState::Tripped);
        assert!(drive.velocity().abs() < 1e-6);
        drive.power_on(0.0, 0.0);
        assert_eq!(drive.state(), DriveState::Tripped, "no restart by itself");
        drive.reset();
        assert_eq!(drive.state(), DriveState::Off);
    }

    #[test]
    fn constants_out_of_range_are_named() {
        let wrong = Drive::new(DriveParameters {
            velocity_lag: -1.0,
            ..DriveParameters::default()
        })
        .unwrap_err();
        assert_eq!(wrong.parameter, "velocity-lag-s");
    }
}
