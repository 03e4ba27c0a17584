//! Readable descriptions of the values that a schema allows.

use serde_json::Value;

use super::{alternatives, resolved};

/// Description of the expected value, such as `a number from 0 to 1: share of messages that never
/// arrive`.
#[must_use]
pub fn expected(root: &Value, schema: &Value) -> String {
    let kind = kind(root, schema);
    let meaning = schema.get("description").and_then(Value::as_str);
    match meaning.map(first_sentence) {
        Some(meaning) if !meaning.is_empty() => format!("{kind}: {meaning}"),
        _ => kind,
    }
}

/// Kind of the expected value: `a number from 0 to 1`.
#[must_use]
pub fn kind(root: &Value, schema: &Value) -> String {
    let schema = resolved(root, schema);
    // The meaning of a pattern in words.
    if let Some(kind) = schema.get("x-kind").and_then(Value::as_str) {
        return kind.to_owned();
    }
    if let Some(value) = schema.get("const") {
        return value.to_string();
    }
    if let Some(values) = schema.get("enum").and_then(Value::as_array) {
        return one_of(values.iter().map(ToString::to_string));
    }
    if let Some(all) = alternatives(schema) {
        return one_of(all.iter().map(|one| kind(root, one)));
    }
    match schema.get("type").and_then(Value::as_str) {
        Some("number") => format!("a number{}", range(schema)),
        Some("integer") => format!("a whole number{}", range(schema)),
        Some("boolean") => "true or false".to_owned(),
        Some("string") => format!("a text{}", characters(schema)),
        Some("array") => format!("a list{}", length(schema)),
        Some("object") => match variant(schema) {
            Some(name) => format!("{{ {name} = … }}"),
            None => "a table".to_owned(),
        },
        _ => "a value".to_owned(),
    }
}

fn one_of(kinds: impl Iterator<Item = String>) -> String {
    let mut all: Vec<String> = Vec::new();
    for kind in kinds {
        // Alternatives may read the same in words.
        if !all.contains(&kind) {
            all.push(kind);
        }
    }
    all.join(" or ")
}

fn range(schema: &Value) -> String {
    let bound = |name: &str| schema.get(name).and_then(Value::as_f64);
    let least = bound("minimum").map(readable);
    let above = bound("exclusiveMinimum").map(readable);
    let most = bound("maximum").map(readable);
    let below = bound("exclusiveMaximum").map(readable);
    // A schema of ours has one bound at either end.
    match (least, above, most, below) {
        (Some(least), _, Some(most), _) => format!(" from {least} to {most}"),
        (Some(least), _, None, None) => format!(" of at least {least}"),
        (Some(least), _, None, Some(below)) => format!(" from {least} to below {below}"),
        (None, Some(above), Some(most), _) => format!(" above {above}, at most {most}"),
        (None, Some(above), None, Some(below)) => format!(" above {above} and below {below}"),
        (None, Some(above), None, None) => format!(" above {above}"),
        (None, None, Some(most), _) => format!(" of at most {most}"),
        (None, None, None, Some(below)) => format!(" below {below}"),
        (None, None, None, None) => String::new(),
    }
}

fn characters(schema: &Value) -> String {
    let bound = |name: &str| schema.get(name).and_then(Value::as_u64);
    match (bound("minLength"), bound("maxLength")) {
        (Some(least), Some(most)) => format!(" of {least} to {most} characters"),
        _ => String::new(),
    }
}

fn length(schema: &Value) -> String {
    let bound = |name: &str| schema.get(name).and_then(Value::as_u64);
    match (bound("minItems"), bound("maxItems")) {
        (Some(least), Some(most)) if least == most => format!(" of {most}"),
        (Some(least), Some(most)) => format!(" of {least} to {most}"),
        (Some(least), None) => format!(" of at least {least}"),
        (None, Some(most)) => format!(" of at most {most}"),
        (None, None) => String::new(),
    }
}

/// A number without hundreds of zeros.
pub(in crate::config) fn readable(number: f64) -> String {
    if number == 0.0 || (1e-9..1e15).contains(&number.abs()) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

/// The name of the variant of an enum that a schema is of: its only field, which is required.
pub(super) fn variant(schema: &Value) -> Option<&str> {
    let fields = schema.get("properties")?.as_object()?;
    match schema.get("required")?.as_array()?.as_slice() {
        // A struct with one required field has the same schema, and reads the same.
        [only] if fields.len() == 1 => only.as_str(),
        _ => None,
    }
}

/// First sentence of a description, for the middle of a sentence.
fn first_sentence(text: &str) -> String {
    let line = text.split("\n\n").next().unwrap_or_default();
    let sentence = line.split(". ").next().unwrap_or_default();
    let sentence = sentence.trim_end_matches('.');
    let mut letters = sentence.chars();
    match letters.next() {
        // `MC_Power` keeps its capitals.
        Some(first) if letters.clone().next().is_some_and(char::is_lowercase) => {
            first.to_lowercase().chain(letters).collect()
        }
        _ => sentence.to_owned(),
    }
}
