//! The text format of a gear file.

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_gear::FlyingGearParameters;
use coaxle_node::config::{ConfigError, CycleMicros, Finite, Positive};
use schemars::JsonSchema;
use serde::Deserialize;

use super::GearFile;

/// A flying gear: motion of master and slave when it is enabled, limits of the slave, and the gear.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct GearText {
    /// A title of one line.
    #[serde(default)]
    title: String,
    /// Unit of the master positions, for display; `u` by default.
    #[serde(default = "any_unit")]
    master_unit: String,
    /// Unit of the slave positions, for display; `u` by default.
    #[serde(default = "any_unit")]
    slave_unit: String,
    /// The cycle time of the slave, µs, in which a gear without a distance would have to be
    /// engaged; 1000 by default.
    cycle_time_us: Option<CycleMicros>,
    /// The master.
    master: MasterText,
    /// The slave, at standstill.
    slave: SlaveText,
    /// Dynamic limits of the slave.
    axis: AxisText,
    /// The gear.
    flying_gear: FlyingGearParameters,
}

fn any_unit() -> String {
    "u".to_owned()
}

/// The master when the gear is enabled.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "GearMaster")]
struct MasterText {
    /// Position, u.
    position: Finite,
    /// Velocity while it passes the gear, u/s.
    velocity: Finite,
}

/// The slave when the gear is enabled.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "GearSlave")]
struct SlaveText {
    /// Position, u.
    position: Finite,
}

/// Dynamic limits of the slave.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "GearAxis")]
struct AxisText {
    /// Highest velocity, u/s.
    velocity: Positive,
    /// Highest acceleration, u/s².
    acceleration: Positive,
    /// Highest deceleration, u/s². Equal to the acceleration by default.
    deceleration: Option<Positive>,
    /// Highest jerk, u/s³.
    jerk: Positive,
}

impl GearText {
    /// Checks the fields together and returns the file; `file` is its name in errors.
    pub(super) fn checked(self, file: &str) -> Result<GearFile, ConfigError> {
        let axis = &self.axis;
        let limits = Limits::new(
            axis.velocity.get(),
            axis.acceleration.get(),
            axis.deceleration.unwrap_or(axis.acceleration).get(),
            axis.jerk.get(),
        );
        let cycle = self
            .cycle_time_us
            .map_or(1e-3, |cycle| cycle.0.span().as_secs_f64());
        Ok(GearFile {
            title: self.title,
            master_unit: self.master_unit,
            slave_unit: self.slave_unit,
            master: Kinematics {
                position: self.master.position.get(),
                velocity: self.master.velocity.get(),
                // The gear is enabled while the master moves steadily.
                acceleration: 0.0,
            },
            slave_position: self.slave.position.get(),
            limits: limits.map_err(|error| ConfigError::field(file, "axis", error))?,
            cycle: Seconds(cycle),
            parameters: self.flying_gear,
        })
    }
}
