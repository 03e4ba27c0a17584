//! Flying saws from files: a coupling moment and one command, as TOML.
//!
//! | PLC name | in the file |
//! |--|--|
//! | `MC_GearInPos`, `MC_GearInVelo` | `[gear-in-pos]`, `[gear-in-velo]` |
//! | `RatioNumerator`, `RatioDenominator` | `ratio`; for a diagonal saw with `angle-degrees` |
//! | `ST_SyncMode` | `sync-mode` |
//! | `Velocity`, `Acceleration`, `Deceleration`, `Jerk`, `Options` | `limits` |
//! | the axis parameters of the slave | `[axis]` |
//! | the axis id of the slave | `slave-axis` |
//!
//! `docs/SAWS.md` describes the format with examples.

mod text;

use std::borrow::Cow;
use std::path::Path;

use coaxle_node::config::{ConfigError, parse};
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};
use coaxle_saw::{
    CouplingMoment, SawCommand, SawCoupling, SawPlan, SawRefusal, SawRemedy, SawTolerances,
};
use schemars::{JsonSchema, Schema, SchemaGenerator};

/// A saw file: the data for planning a synchronisation.
#[derive(Clone, Debug, PartialEq)]
pub struct SawFile {
    /// A title of one line.
    pub title: String,
    /// Unit of the master positions, for people.
    pub master_unit: String,
    /// Unit of the slave positions, for people.
    pub slave_unit: String,
    /// The table that holds the profile.
    pub table_id: u32,
    /// The two axes when the command is given.
    pub moment: CouplingMoment,
    /// Command for the slave.
    pub command: SawCommand,
}

/// The schema of the file.
impl JsonSchema for SawFile {
    fn schema_name() -> Cow<'static, str> {
        "SawFile".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        text::SawText::json_schema(generator)
    }
}

impl SawFile {
    /// Reads a saw file.
    ///
    /// # Errors
    /// [`ConfigError`], naming the file and the field.
    pub fn load(path: &Path) -> Result<Self, ConfigError> {
        let text = text_file::read(path, MOST_CONFIG_BYTES)?;
        Self::parse(&path.display().to_string(), &text)
    }

    /// Reads a saw file from text; `file` is its name in errors.
    ///
    /// # Errors
    /// [`ConfigError`], naming the file and the field.
    pub fn parse(file: &str, text: &str) -> Result<Self, ConfigError> {
        let parsed: text::SawText = parse(file, text)?;
        let checked = parsed.checked(file);
        // Lines are known to the text only.
        checked.map_err(|error| error.in_text(file, text))
    }

    /// The synchronisation as it would be carried out: with a start distance, from the moment at
    /// which the master is within it.
    ///
    /// # Errors
    /// [`SawRefusal`].
    pub fn plan(&self) -> Result<SawPlan, SawRefusal> {
        SawCoupling::start(self.command, &self.moment, SawTolerances::default())
            .map(|coupling| *coupling.plan())
    }

    /// Changes that would make a refused command valid; empty if no search applies.
    #[must_use]
    pub fn remedy(&self) -> SawRemedy {
        self.command.remedy(&self.moment)
    }
}

#[cfg(test)]
mod tests;
