//! `[lab]`: injected faults and simulated inputs in the config of a node, apart from the settings that a machine runs.
//!
//! A scenario is an experiment, and has these fields of its nodes where they belong. The config of a node has them in a table
//! of their own, with which a node starts only with `--lab`: an injected fault is never mistaken for one of the machine.

mod fields;
#[cfg(test)]
mod tests;

use std::path::Path;

use coaxle_wire::document::{Document, Misread};
use schemars::{JsonSchema, Schema};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::config::schema::{
    LabField, lab_fields, marked_schema_of, schema_of, schema_without_lab_fields,
};
use crate::config::{
    ClockConfig, ConfigError, Wrong, check_kind, document_of, document_of_table, error_in_part,
    parse_table,
};
use crate::faults::check_clock;
use crate::text_file::{self, MOST_CONFIG_BYTES};

pub use fields::LabFields;

/// The config of a node whose file may have a `[lab]` table. As a type it has the fields of the table where they belong.
pub trait WithLab: Clone + Serialize + DeserializeOwned + JsonSchema {
    /// The table.
    type Lab: LabTable;

    /// Reads the config with its deserializer. Each crate that calls a deserializer makes all of its code again; this
    /// method is made once, in the crate of the config.
    ///
    /// # Errors
    /// [`Misread`] with the field.
    fn read(document: &Document) -> Result<Self, Misread>;

    /// Moves the fields of the table to where they belong.
    ///
    /// # Errors
    /// [`Wrong`] names a field that has no place in this config.
    fn set_lab(&mut self, lab: Self::Lab) -> Result<(), Wrong>;

    /// Returns the fields of the table, from where they belong.
    fn lab(&self) -> Self::Lab;
}

/// A `[lab]` table. By default nothing is injected.
pub trait LabTable:
    Clone + Default + PartialEq + Serialize + DeserializeOwned + JsonSchema
{
    /// Reads the table with its deserializer, as [`WithLab::read`] does.
    ///
    /// # Errors
    /// [`Misread`] with the field.
    fn read(document: &Document) -> Result<Self, Misread>;

    /// Reads the files that the table names by relative paths from `folder`, as the node's start does.
    ///
    /// # Errors
    /// [`Wrong`] names the field and the file.
    fn check_files(&self, folder: &Path) -> Result<(), Wrong>;
}

/// Checks the files that the clock of a `[lab]` table names by relative paths from `folder`.
///
/// # Errors
/// [`Wrong`] names the field and the file.
pub fn check_lab_clock(clock: &ClockConfig, folder: &Path) -> Result<(), Wrong> {
    // On a copy: the paths of the config itself stay as they were written.
    let mut clock = clock.clone();
    clock.relative_to(folder);
    check_clock(&clock).map_err(|wrong| wrong.within("clock"))
}

/// The config of a node as a file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeFile<C> {
    /// The config.
    pub config: C,
    /// Injected faults and simulated inputs of its `[lab]` table; none without a table.
    pub lab: Option<LabFields>,
}

impl<C: WithLab> NodeFile<C> {
    /// Reads a file, and the files that its `[lab]` table names.
    ///
    /// # Errors
    /// [`ConfigError`], naming the file and the field.
    pub fn load(path: &Path) -> Result<Self, ConfigError> {
        let text = text_file::read(path, MOST_CONFIG_BYTES)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::read(&path.display().to_string(), &text, Some(folder))
    }

    /// Reads a text; `file` is what the errors call it.
    ///
    /// # Errors
    /// [`ConfigError`], naming the file and the field.
    pub fn parse(file: &str, text: &str) -> Result<Self, ConfigError> {
        Self::read(file, text, None)
    }

    /// Reads the text of a config that runs a machine: nothing is injected or simulated.
    ///
    /// # Errors
    /// [`ConfigError`], naming the file and the field; a `[lab]` table.
    pub fn parse_machine(file: &str, text: &str) -> Result<C, ConfigError> {
        let Self { config, lab } = Self::parse(file, text)?;
        match lab {
            None => Ok(config),
            Some(fields) => Err(ConfigError::whole(file, fields.refusal()).in_text(file, text)),
        }
    }

    /// Writes a config as the text of a file.
    ///
    /// # Errors
    /// A config that cannot be written as TOML.
    pub fn text_of(config: &C) -> Result<String, toml::ser::Error> {
        let mut table = toml::Table::try_from(config)?;
        // The fields are in their places in the type, and in the table in the file.
        remove_lab_fields(marked_schema_of::<C>().as_value(), &mut table);
        let lab = config.lab();
        if lab != C::Lab::default() {
            table.insert(LAB.to_owned(), toml::Value::try_from(lab)?);
        }
        toml::to_string(&table)
    }

    /// Returns the schema of a file.
    #[must_use]
    pub fn schema() -> Schema {
        let mut schema = schema_without_lab_fields::<C>();
        let mut lab = schema_of::<C::Lab>();
        // A schema within another one names no dialect.
        lab.remove("$schema");
        if let Some(Value::Object(definitions)) = lab.remove("$defs") {
            let empty = || Value::Object(Map::new());
            let known = schema.ensure_object().entry("$defs").or_insert_with(empty);
            if let Value::Object(known) = known {
                known.extend(definitions);
            }
        }
        if let Some(Value::Object(properties)) = schema.get_mut("properties") {
            properties.insert(LAB.to_owned(), lab.to_value());
        }
        schema
    }

    fn read(file: &str, text: &str, folder: Option<&Path>) -> Result<Self, ConfigError> {
        let read = Self::from_table(file, parse_table(file, text)?, folder);
        read.map_err(|error| error.in_text(file, text))
    }

    fn from_table(
        file: &str,
        whole: toml::Table,
        folder: Option<&Path>,
    ) -> Result<Self, ConfigError> {
        let schema = marked_schema_of::<C>();
        check_kind(file, &schema, &whole)?;
        // Then: a field at its old place gets an answer of its own, not that of an unknown field.
        refuse_lab_fields(file, schema.as_value(), &whole)?;
        let mut rest = whole.clone();
        let table = rest.remove(LAB);
        let misread =
            |path, misread: &Misread| error_in_part(file, path, misread, &whole, Self::schema);
        let mut config = C::read(&document_of_table(&rest)).map_err(|error| misread("", &error))?;
        let Some(table) = table else {
            return Ok(Self { config, lab: None });
        };
        // Before parsing: shown as written, without defaults.
        let fields = LabFields::of(&table);
        let lab = C::Lab::read(&document_of(&table)).map_err(|error| misread(LAB, &error))?;
        // Without a folder, as in a text of a test, relative files have no place.
        if let Some(folder) = folder {
            lab.check_files(folder)
                .map_err(|wrong| wrong.within(LAB).in_file(file))?;
        }
        config
            .set_lab(lab)
            .map_err(|wrong| wrong.within(LAB).in_file(file))?;
        let lab = Some(fields);
        Ok(Self { config, lab })
    }
}

/// The table's name in a file.
const LAB: &str = "lab";

/// Fields of the table that stand where a scenario has them.
fn refuse_lab_fields(file: &str, schema: &Value, table: &toml::Table) -> Result<(), ConfigError> {
    let misplaced = lab_fields(schema, table);
    if misplaced.is_empty() {
        return Ok(());
    }
    let wrong = misplaced.into_iter().map(|LabField { field, in_lab }| {
        let reason = format!(
            "what is injected or simulated lives in [lab]: write {in_lab}, and start the node with --lab"
        );
        Wrong::with_reason(field, reason)
    });
    Err(ConfigError::fields(file, wrong))
}

/// Takes the fields of the table out of the places where a scenario has them.
fn remove_lab_fields(schema: &Value, table: &mut toml::Table) {
    for LabField { field, .. } in lab_fields(schema, table) {
        remove(table, &field);
    }
}

/// Removes a field by its path: `far[0].timing.faults`.
fn remove(table: &mut toml::Table, path: &str) {
    let Some((first, rest)) = path.split_once('.') else {
        table.remove(path);
        return;
    };
    let (name, index) = match first.split_once('[') {
        // An index behind the name: an element of a list.
        Some((name, index)) => (name, index.trim_end_matches(']').parse().ok()),
        None => (first, None),
    };
    let value = table.get_mut(name).and_then(|value| match index {
        Some(index) => value.get_mut::<usize>(index),
        None => Some(value),
    });
    if let Some(toml::Value::Table(inner)) = value {
        remove(inner, rest);
    }
}
