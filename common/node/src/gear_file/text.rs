//! A gear file as it is written.

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_gear::FlyingGearParameters;
use schemars::JsonSchema;
use serde::Deserialize;

use super::GearFile;
use crate::config::{ConfigError, CycleMicros, Finite, Positive};

/// A flying gear: where master and slave are when it is enabled, what the slave can do, and the gear.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct GearText {
    /// One line: what it shows.
    #[serde(default)]
    title: String,
    /// What master positions are in, for people; `u` by default.
    #[serde(default = "any_unit")]
    master_unit: String,
    /// What slave positions are in, for people; `u` by default.
    #[serde(default = "any_unit")]
    slave_unit: String,
    /// The cycle time of the slave, µs, in which a gear without a way would have to be engaged; 1000 by default.
    cycle_time_us: Option<CycleMicros>,
    /// The master.
    master: MasterText,
    /// The slave, which stands.
    slave: SlaveText,
    /// What the slave can do.
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
    /// The velocity with which it passes the gear, u/s.
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

/// What the slave can do.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "GearAxis")]
struct AxisText {
    /// Highest velocity, u/s.
    velocity: Positive,
    /// Highest acceleration, u/s².
    acceleration: Positive,
    /// Highest deceleration, u/s². The same as the acceleration by default.
    deceleration: Option<Positive>,
    /// Highest jerk, u/s³.
    jerk: Positive,
}

impl GearText {
    /// The file with what its fields together must be checked; `file` is what errors call it.
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
                acceleration: 0.0,
            },
            slave_position: self.slave.position.get(),
            limits: limits.map_err(|error| ConfigError::field(file, "axis", error))?,
            cycle: Seconds(cycle),
            parameters: self.flying_gear,
        })
    }
}
