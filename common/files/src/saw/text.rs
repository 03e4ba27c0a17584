//! The text format of a saw file.

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_node::config::{ConfigError, CycleMicros, Finite, Positive, Wrong};
use coaxle_saw::{
    CouplingMoment, EncoderNoise, GearInPos, GearInVelo, Ratio, SawCommand, SlaveLimits,
    diagonal_ratio, saw_table_id,
};
use schemars::JsonSchema;
use serde::Deserialize;

use super::SawFile;

/// A flying saw at the moment of coupling: motion of master and slave, limits of the slave, and the
/// command.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct SawText {
    /// A title of one line.
    #[serde(default)]
    title: String,
    /// Unit of the master positions, for display; `u` by default.
    #[serde(default = "any_unit")]
    master_unit: String,
    /// Unit of the slave positions, for display; `u` by default.
    #[serde(default = "any_unit")]
    slave_unit: String,
    /// The axis id of the slave, 1 to 255, which determines the number of its table.
    #[serde(default = "first_axis")]
    slave_axis: u32,
    /// The angle between the slave's and the master's direction, °, of a diagonal saw.
    angle_degrees: Option<f64>,
    /// The master.
    master: MovingText,
    /// Encoder of the master, if it is measured.
    encoder: Option<EncoderText>,
    /// The slave.
    slave: MovingText,
    /// Dynamic limits of the slave.
    axis: AxisText,
    /// Synchronous at a position; this or `gear-in-velo`.
    gear_in_pos: Option<GearInPos>,
    /// Synchronous in velocity, at any position; this or `gear-in-pos`.
    gear_in_velo: Option<GearInVelo>,
}

fn any_unit() -> String {
    "u".to_owned()
}

const fn first_axis() -> u32 {
    1
}

/// Motion of an axis at the moment of coupling.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "SawMotion")]
struct MovingText {
    /// Position, u.
    position: Finite,
    /// Velocity, u/s.
    velocity: Finite,
    /// Acceleration, u/s².
    #[serde(default)]
    acceleration: Finite,
}

/// The encoder that the master is measured by.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "SawEncoder")]
struct EncoderText {
    /// The length of an increment, u.
    scaling: Positive,
    /// The cycle time of reading it, µs.
    cycle_time_us: CycleMicros,
}

/// Dynamic limits of the slave.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "SawAxis")]
struct AxisText {
    /// Highest velocity, u/s.
    velocity: Positive,
    /// Highest acceleration, u/s².
    acceleration: Positive,
    /// Highest deceleration, u/s². Equal to the acceleration by default.
    deceleration: Option<Positive>,
    /// Highest jerk, u/s³.
    jerk: Positive,
    /// Lower software limit, u.
    min_position: Option<Finite>,
    /// Upper software limit, u.
    max_position: Option<Finite>,
}

impl SawText {
    /// Checks the fields together and returns the file; `file` is its name in errors.
    pub(super) fn checked(self, file: &str) -> Result<SawFile, ConfigError> {
        // No other saw exists in a file, so that every number is free.
        let table_id = saw_table_id(self.slave_axis, |_| false)
            .map_err(|error| ConfigError::field(file, "slave-axis", error))?;
        let moment = CouplingMoment {
            master: self.master.kinematics(),
            encoder: self.encoder.as_ref().map(EncoderText::checked),
            slave: self.slave.kinematics(),
            axis: self.axis.checked(file)?,
        };
        let angle = self.angle_degrees;
        let command = one_command(file, self.gear_in_pos, self.gear_in_velo)?;
        Ok(SawFile {
            title: self.title,
            master_unit: self.master_unit,
            slave_unit: self.slave_unit,
            table_id,
            moment,
            command: at_angle(file, angle, command)?,
        })
    }
}

fn one_command(
    file: &str,
    position: Option<GearInPos>,
    velocity: Option<GearInVelo>,
) -> Result<SawCommand, ConfigError> {
    match (position, velocity) {
        (Some(command), None) => Ok(SawCommand::GearInPos(command)),
        (None, Some(command)) => Ok(SawCommand::GearInVelo(command)),
        // Given as missing and given twice need different cures.
        (position, _) => {
            let received = if position.is_some() { "both" } else { "none" };
            let expected = "either [gear-in-pos] or [gear-in-velo]";
            Err(Wrong::of("command", received, expected).in_file(file))
        }
    }
}

/// The command of a diagonal saw, if there is an angle.
fn at_angle(
    file: &str,
    angle: Option<f64>,
    mut command: SawCommand,
) -> Result<SawCommand, ConfigError> {
    let Some(angle) = angle else {
        return Ok(command);
    };
    let ratio = match &mut command {
        SawCommand::GearInPos(command) => &mut command.ratio,
        SawCommand::GearInVelo(command) => &mut command.ratio,
    };
    // The angle acts on the numerator alone: the denominator stays as it was written.
    let Ratio { numerator, .. } = diagonal_ratio(angle, ratio.numerator)
        .map_err(|error| ConfigError::field(file, "angle-degrees", error))?;
    ratio.numerator = numerator;
    Ok(command)
}

impl MovingText {
    fn kinematics(&self) -> Kinematics {
        Kinematics {
            position: self.position.get(),
            velocity: self.velocity.get(),
            acceleration: self.acceleration.get(),
        }
    }
}

impl EncoderText {
    fn checked(&self) -> EncoderNoise {
        EncoderNoise {
            scaling: self.scaling.get(),
            cycle: Seconds(self.cycle_time_us.0.span().as_secs_f64()),
        }
    }
}

impl AxisText {
    fn checked(&self, file: &str) -> Result<SlaveLimits, ConfigError> {
        let dynamics = Limits::new(
            self.velocity.get(),
            self.acceleration.get(),
            self.deceleration.unwrap_or(self.acceleration).get(),
            self.jerk.get(),
        )
        .map_err(|error| ConfigError::field(file, "axis", error))?;
        let min_position = self.min_position.map(Finite::get);
        let max_position = self.max_position.map(Finite::get);
        if let (Some(min), Some(max)) = (min_position, max_position)
            // Equal limits leave no way, and no position in between.
            && min >= max
        {
            let expected = format!("above min-position, which is {min}");
            return Err(Wrong::of("axis.max-position", max, expected).in_file(file));
        }
        Ok(SlaveLimits {
            dynamics,
            min_position,
            max_position,
            // The guard belongs to the axis of a receiver, not to a plan from a file.
            guard: None,
        })
    }
}
