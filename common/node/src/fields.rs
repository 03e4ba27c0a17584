//! The fields of a structure, by their names.

use serde::Serialize;
use serde_json::{Map, Value};

/// The fields of a structure for a status or a summary; empty for other values.
#[must_use]
pub fn fields_of(structure: &impl Serialize) -> Map<String, Value> {
    match serde_json::to_value(structure) {
        Ok(Value::Object(fields)) => fields,
        _ => Map::new(),
    }
}
