//! `drive` of a slave: the drive that follows its set values.

use std::path::PathBuf;

use coaxle_axis::drive::{DriveParameters, ProcessDriveParameters};
use coaxle_clock::CycleTime;
use coaxle_node::config::{AtLeastZero, DeadTimeMicros, Positive, Wrong};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The drive that follows the set values of a slave; a simulated one without a `kind`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Form", into = "Form")]
pub enum DriveConfig {
    /// `kind = "simulated"`: calculated.
    Simulated(SimulatedConfig),
    /// `kind = "shared-memory"`: another process on this machine. In virtual time, where there are
    /// no processes, a simulated drive replaces it.
    SharedMemory(SharedMemoryConfig),
}

impl Default for DriveConfig {
    fn default() -> Self {
        Self::Simulated(SimulatedConfig::default())
    }
}

impl DriveConfig {
    /// Parameters of the simulation; for a drive in another process, those of its replacement.
    #[must_use]
    pub fn simulated(&self) -> DriveParameters {
        match self {
            Self::Simulated(drive) => drive.parameters,
            Self::SharedMemory(config) => DriveParameters {
                // The replacement keeps the window, so that virtual time monitors the drive as well.
                following_error_window: config.following_error_window.get(),
                following_error_time: config.following_error_time_s.get(),
                ..DriveParameters::default()
            },
        }
    }

    /// The kind, as written in a config.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Simulated(_) => "simulated",
            Self::SharedMemory(_) => "shared-memory",
        }
    }
}

/// A simulated drive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SimulatedConfig {
    /// Parameters of its controllers.
    pub parameters: DriveParameters,
    /// Time after which it follows a set value.
    pub dead_time: DeadTimeMicros,
}

/// A drive process that shares memory with the receiver.
#[derive(Clone, Debug, PartialEq)]
pub struct SharedMemoryConfig {
    /// The file that both map, for example `/dev/shm/coaxle-carriage`: on a file system in memory,
    /// because a disk could hold up the cycle.
    pub path: PathBuf,
    /// Largest following error, u. It has to exceed the distance that the slave travels in the
    /// cycles that the process takes to respond.
    pub following_error_window: Positive,
    /// Time for which the following error may exceed its window, s. 0.02 by default.
    pub following_error_time_s: AtLeastZero,
    /// Cycles that may pass without a heartbeat of the process, 1 to 100 000. 20 by default.
    pub max_silent_cycles: u32,
    /// Time from the power command until the drive follows, s, at most 600. 5 by default.
    pub switch_on_time_s: Positive,
}

impl SharedMemoryConfig {
    /// Monitoring parameters of the drive, in cycles of this length.
    #[must_use]
    pub fn parameters(&self, cycle_time: CycleTime) -> ProcessDriveParameters {
        // Rounded up: the drive has at least its time. At most 600 s of 100 µs are 6·10⁶ cycles, within a u32.
        let cycles = (self.switch_on_time_s.get() / cycle_time.as_secs_f64()).ceil();
        ProcessDriveParameters {
            max_silent_cycles: self.max_silent_cycles,
            switch_on_cycles: cycles.max(1.0) as u32,
            following_error_window: self.following_error_window.get(),
            following_error_time: self.following_error_time_s.get(),
        }
    }
}

/// The drive as written in a config: the fields of all kinds.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
struct Form {
    /// Kind of drive; a simulated one by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    kind: Option<Kind>,
    /// Shared memory: the file that both map, for example `/dev/shm/coaxle-carriage`.
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<PathBuf>,
    /// Simulated: gain of the position controller, 1/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    position_gain: Option<f64>,
    /// Simulated: lag of the velocity controller, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity_lag_s: Option<f64>,
    /// Simulated: highest velocity, u/s; 0: not limited.
    #[serde(skip_serializing_if = "Option::is_none")]
    max_velocity: Option<f64>,
    /// Simulated: time after which it follows a set value, µs; 0: at once. The slave's `dead-time-us` makes up for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    dead_time_us: Option<f64>,
    /// Largest following error, u; 0: not monitored. Shared memory: above 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    following_error_window: Option<f64>,
    /// Time for which the following error may exceed its window, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    following_error_time_s: Option<f64>,
    /// Shared memory: cycles that may pass without a heartbeat, 1 to 100 000. 20 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    max_silent_cycles: Option<u32>,
    /// Shared memory: time from the power command until the drive follows, s, at most 600. 5 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    switch_on_time_s: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DriveKind")]
enum Kind {
    /// Calculated.
    Simulated,
    /// Another process on this machine.
    SharedMemory,
}

impl TryFrom<Form> for DriveConfig {
    type Error = Wrong;

    fn try_from(form: Form) -> Result<Self, Wrong> {
        match form.kind.unwrap_or(Kind::Simulated) {
            Kind::Simulated => simulated(&form),
            Kind::SharedMemory => shared_memory(form),
        }
    }
}

fn simulated(form: &Form) -> Result<DriveConfig, Wrong> {
    none_of(
        [
            ("path", form.path.is_some()),
            ("max-silent-cycles", form.max_silent_cycles.is_some()),
            ("switch-on-time-s", form.switch_on_time_s.is_some()),
        ],
        "simulated",
    )?;
    let default = DriveParameters::default();
    let parameters = DriveParameters {
        position_gain: form.position_gain.unwrap_or(default.position_gain),
        velocity_lag: form.velocity_lag_s.unwrap_or(default.velocity_lag),
        max_velocity: form.max_velocity.unwrap_or(default.max_velocity),
        following_error_window: (form.following_error_window)
            .unwrap_or(default.following_error_window),
        following_error_time: (form.following_error_time_s).unwrap_or(default.following_error_time),
    };
    let dead_time = DeadTimeMicros::new(form.dead_time_us.unwrap_or_default())
        .map_err(|wrong| wrong.within("dead-time-us"))?;
    Ok(DriveConfig::Simulated(SimulatedConfig {
        parameters,
        dead_time,
    }))
}

/// Longest time to switch on, s.
const LONGEST_SWITCH_ON: f64 = 600.0;
/// Most cycles without a heartbeat.
const MOST_SILENT_CYCLES: u32 = 100_000;

fn shared_memory(form: Form) -> Result<DriveConfig, Wrong> {
    none_of(
        [
            ("position-gain", form.position_gain.is_some()),
            ("velocity-lag-s", form.velocity_lag_s.is_some()),
            ("max-velocity", form.max_velocity.is_some()),
            ("dead-time-us", form.dead_time_us.is_some()),
        ],
        "shared-memory",
    )?;
    // After the fields of other kinds: those say that the kind may be the mistake.
    let none = |field, expected| move || Wrong::of(field, "none", expected);
    let path = form.path.ok_or_else(none(
        "path",
        "the file that the drive process maps too, such as \"/dev/shm/coaxle-carriage\"",
    ))?;
    let window = form.following_error_window.ok_or_else(none(
        "following-error-window",
        "the largest following error, u: a drive in another process is watched",
    ))?;
    let max_silent_cycles = form.max_silent_cycles.unwrap_or(20);
    // With 0 a heartbeat in every second cycle would count as lost.
    if !(1..=MOST_SILENT_CYCLES).contains(&max_silent_cycles) {
        let expected = format!("1 to {MOST_SILENT_CYCLES}");
        return Err(Wrong::of("max-silent-cycles", max_silent_cycles, expected));
    }
    let switch_on = form.switch_on_time_s.unwrap_or(5.0);
    if switch_on > LONGEST_SWITCH_ON {
        let expected = format!("at most {LONGEST_SWITCH_ON}");
        return Err(Wrong::of("switch-on-time-s", switch_on, expected));
    }
    let time = form.following_error_time_s.unwrap_or(0.02);
    Ok(DriveConfig::SharedMemory(SharedMemoryConfig {
        path,
        following_error_window: Positive::new(window)
            .map_err(|wrong| wrong.within("following-error-window"))?,
        following_error_time_s: AtLeastZero::new(time)
            .map_err(|wrong| wrong.within("following-error-time-s"))?,
        max_silent_cycles,
        switch_on_time_s: Positive::new(switch_on)
            .map_err(|wrong| wrong.within("switch-on-time-s"))?,
    }))
}

fn none_of<const N: usize>(
    fields: [(&'static str, bool); N],
    kind: &'static str,
) -> Result<(), Wrong> {
    match fields.into_iter().find(|(_, is_there)| *is_there) {
        Some((field, _)) => {
            let expected = format!("none in a drive of kind = {kind:?}");
            Err(Wrong::of(field, "one", expected))
        }
        None => Ok(()),
    }
}

impl From<DriveConfig> for Form {
    fn from(config: DriveConfig) -> Self {
        match config {
            // Without its kind, as in files from before there were others.
            DriveConfig::Simulated(SimulatedConfig {
                parameters: drive,
                dead_time,
            }) => Self {
                position_gain: Some(drive.position_gain),
                velocity_lag_s: Some(drive.velocity_lag),
                max_velocity: Some(drive.max_velocity),
                dead_time_us: Some(dead_time.get()).filter(|time| *time > 0.0),
                following_error_window: Some(drive.following_error_window),
                following_error_time_s: Some(drive.following_error_time),
                ..Self::default()
            },
            DriveConfig::SharedMemory(drive) => Self {
                kind: Some(Kind::SharedMemory),
                path: Some(drive.path),
                following_error_window: Some(drive.following_error_window.get()),
                following_error_time_s: Some(drive.following_error_time_s.get()),
                max_silent_cycles: Some(drive.max_silent_cycles),
                switch_on_time_s: Some(drive.switch_on_time_s.get()),
                ..Self::default()
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(text: &str) -> Result<DriveConfig, String> {
        coaxle_node::config::parse("drive", text).map_err(|error| error.to_string())
    }

    const SHARED: &str =
        "kind = 'shared-memory'\npath = '/dev/shm/saw'\nfollowing-error-window = 2";

    #[test]
    fn without_a_kind_it_is_simulated_as_before() {
        let gain = drive("position-gain = 20").unwrap();
        assert_eq!(
            gain,
            drive("kind = 'simulated'\nposition-gain = 20").unwrap()
        );
        let DriveConfig::Simulated(SimulatedConfig { parameters, .. }) = &gain else {
            panic!("{gain:?}");
        };
        assert_eq!(
            (parameters.position_gain, parameters.velocity_lag),
            (20.0, 0.001)
        );
        assert_eq!(drive(""), Ok(DriveConfig::default()));
    }

    #[test]
    fn what_is_written_is_read_again() {
        for text in ["max-velocity = 7", "dead-time-us = 4000", SHARED] {
            let config = drive(text).unwrap();
            let written = toml::to_string(&config).unwrap();
            assert_eq!(drive(&written), Ok(config), "{written}");
        }
    }

    #[test]
    fn a_shared_memory_has_defaults() {
        let DriveConfig::SharedMemory(config) = drive(SHARED).unwrap() else {
            panic!("another kind");
        };
        let cycle = coaxle_clock::Span::from_millis(2);
        let parameters = config.parameters(CycleTime::new(cycle).unwrap());
        assert_eq!(
            (parameters.max_silent_cycles, parameters.switch_on_cycles),
            (20, 2_500)
        );
        assert_eq!(parameters.following_error_time, 0.02);
    }

    #[test]
    fn what_is_wrong_is_named_with_what_is_expected() {
        for (text, expected) in [
            (
                "kind = 'magic'",
                "kind: received \"magic\", expected `simulated` or `shared-memory`",
            ),
            ("gain = 1", "unknown field `gain`"),
            (
                "path = '/x'",
                "path: received one, expected none in a drive of kind = \"simulated\"",
            ),
            (
                "kind = 'shared-memory'",
                "path: received none, expected the file",
            ),
            (
                "kind = 'shared-memory'\npath = '/x'",
                "following-error-window: received none, expected the largest",
            ),
            (
                &format!("{SHARED}\nmax-velocity = 1"),
                "max-velocity: received one, expected none in a drive of kind = \"shared-memory\"",
            ),
            (
                &format!("{SHARED}\nmax-silent-cycles = 0"),
                "max-silent-cycles: received 0, expected 1 to 100000",
            ),
            (
                &format!("{SHARED}\nswitch-on-time-s = 0"),
                "switch-on-time-s: received 0, expected a finite number above 0",
            ),
            (
                &format!("{SHARED}\nswitch-on-time-s = 601"),
                "switch-on-time-s: received 601, expected at most 600",
            ),
            (
                &format!("{SHARED}\nfollowing-error-time-s = -1"),
                "following-error-time-s: received -1, expected a finite number of at least 0",
            ),
        ] {
            let error = drive(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
