//! Flying gears from files: motion of master and slave, limits of the slave, and the gear, as TOML.
//!
//! | PLC name | in the file |
//! |--|--|
//! | `MC_FlyingGear` | `[flying-gear]` |
//! | the axis parameters of the slave | `[axis]` |
//!
//! `docs/GEARS.md` describes the format with examples.

mod text;

use std::borrow::Cow;
use std::path::Path;

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_gear::{FlyingGear, FlyingGearError, FlyingGearParameters};
use coaxle_node::config::{ConfigError, parse};
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};
use schemars::{JsonSchema, Schema, SchemaGenerator};

/// A gear file: the data for enabling a flying gear.
#[derive(Clone, Debug, PartialEq)]
pub struct GearFile {
    /// A title of one line.
    pub title: String,
    /// Unit of the master positions, for people.
    pub master_unit: String,
    /// Unit of the slave positions, for people.
    pub slave_unit: String,
    /// The master: its position, and its velocity at the gear.
    pub master: Kinematics,
    /// Position of the slave at standstill.
    pub slave_position: f64,
    /// Dynamic limits of the slave.
    pub limits: Limits,
    /// The slave's cycle time, in which a gear without a distance is engaged.
    pub cycle: Seconds,
    /// The gear.
    pub parameters: FlyingGearParameters,
}

/// The schema of the file.
impl JsonSchema for GearFile {
    fn schema_name() -> Cow<'static, str> {
        "GearFile".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        text::GearText::json_schema(generator)
    }
}

impl GearFile {
    /// Reads a gear file.
    ///
    /// # Errors
    /// [`ConfigError`], naming the file and the field.
    pub fn load(path: &Path) -> Result<Self, ConfigError> {
        let text = text_file::read(path, MOST_CONFIG_BYTES)?;
        Self::parse(&path.display().to_string(), &text)
    }

    /// Reads a gear file from text; `file` is its name in errors.
    ///
    /// # Errors
    /// [`ConfigError`], naming the file and the field.
    pub fn parse(file: &str, text: &str) -> Result<Self, ConfigError> {
        let parsed: text::GearText = parse(file, text)?;
        parsed
            .checked(file)
            .map_err(|error| error.in_text(file, text))
    }

    /// The gear as a slave would enable it, checked at this speed of the master.
    ///
    /// # Errors
    /// [`FlyingGearError`].
    pub fn gear(&self) -> Result<FlyingGear, FlyingGearError> {
        // Checked at the velocity in the file, which the limits are compared with.
        let gear = FlyingGear::enable(&self.parameters, &self.master, self.slave_position)?;
        gear.check_limits(&self.limits, self.master.velocity, self.cycle.0)?;
        Ok(gear)
    }
}

#[cfg(test)]
mod tests;
