//! The schemas of files: JSON Schema, from their types, for editors, errors and the reference.

mod compare;
mod expected;

use schemars::transform::{RecursiveTransform, Transform};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::{Map, Value};

pub(super) use compare::compare;
pub(crate) use compare::{LabField, lab_fields};
pub(super) use expected::readable;
pub use expected::{expected, kind};

/// The mark of a field that injects or simulates something. A scenario has it in its place; the config of a node has it in its
/// `[lab]` table, as the mark says: the value stands for the `{}` in it.
const LAB_MARK: &str = "x-lab";

/// The schema of a file that is read into a `T`: each field with its meaning, its range and its default.
#[must_use]
pub fn schema_of<T: JsonSchema>() -> Schema {
    let mut schema = marked_schema_of::<T>();
    // Marks are for the parser of configs. Editors would take them for unknown keywords.
    RecursiveTransform(without_mark).transform(&mut schema);
    schema
}

/// [`schema_of`] without the fields that inject or simulate something.
#[must_use]
pub fn schema_without_lab_fields<T: JsonSchema>() -> Schema {
    let mut schema = marked_schema_of::<T>();
    RecursiveTransform(without_lab_fields).transform(&mut schema);
    schema
}

/// [`schema_of`] with the marks of the fields that inject or simulate something.
pub(crate) fn marked_schema_of<T: JsonSchema>() -> Schema {
    let mut schema = SchemaGenerator::default().into_root_schema_for::<T>();
    RecursiveTransform(simplify).transform(&mut schema);
    schema
}

fn without_mark(schema: &mut Schema) {
    schema.remove(LAB_MARK);
}

fn without_lab_fields(schema: &mut Schema) {
    if let Some(Value::Object(fields)) = schema.get_mut("properties") {
        fields.retain(|_, field| field.get(LAB_MARK).is_none());
    }
}

/// Resolves a reference to a definition of a schema; other parts are returned as they are.
#[must_use]
pub fn resolved<'s>(root: &'s Value, part: &'s Value) -> &'s Value {
    let target = part.get("$ref").and_then(Value::as_str);
    // All references of these schemas are to definitions of their own.
    let name = target.and_then(|target| target.strip_prefix("#/$defs/"));
    let definition = name.and_then(|name| root.get("$defs")?.get(name));
    definition.unwrap_or(part)
}

/// The alternatives of a value; none where there is a single one.
#[must_use]
pub fn alternatives(part: &Value) -> Option<&Vec<Value>> {
    part.get("anyOf").or(part.get("oneOf"))?.as_array()
}

/// Simplifies a schema: TOML has no null, doc comments are written for rustdoc, and Rust's number
/// formats do not matter to users.
fn simplify(schema: &mut Schema) {
    let Some(fields) = schema.as_object_mut() else {
        return;
    };
    fields.remove("format");
    // TOML has no null: an absent field is the default.
    fields.retain(|name, value| name != "default" || !value.is_null());
    without_null(fields);
    if let Some(Value::String(text)) = fields.get_mut("description") {
        *text = plain(text);
    }
}

fn without_null(fields: &mut Map<String, Value>) {
    if let Some(Value::Array(types)) = fields.get_mut("type") {
        types.retain(|name| name != "null");
        // `type: [number, null]` is an optional number.
        if let [only] = &types[..] {
            let only = only.clone();
            fields.insert("type".to_owned(), only);
        }
    }
    if let Some(Value::Array(values)) = fields.get_mut("enum") {
        values.retain(|value| !value.is_null());
    }
    let Some(Value::Array(all)) = fields.get_mut("anyOf") else {
        return;
    };
    let is_null = |part: &Value| part.get("type").is_some_and(|name| name == "null");
    all.retain(|part| !is_null(part));
    // An alternative that is left alone moves up.
    if let [Value::Object(only)] = &all[..] {
        let only = only.clone();
        fields.remove("anyOf");
        for (name, value) in only {
            // The field's own description wins over that of its type.
            fields.entry(name).or_insert(value);
        }
    }
}

/// The first `(super::Item)` behind a name, as rustdoc takes it: not what people put in brackets.
fn target_of_a_link(text: &str) -> Option<(usize, usize)> {
    let begin = text.match_indices("`(").map(|(at, _)| at + 1);
    let mut targets = begin.filter_map(|begin| {
        let end = begin + text[begin..].find(')')? + 1;
        text[begin..end].contains("::").then_some((begin, end))
    });
    targets.next()
}

/// A doc comment without its links, in one line for each paragraph.
fn plain(text: &str) -> String {
    // Links of rustdoc, whose text stays.
    let mut text = text.replace("[`", "`").replace("`]", "`");
    while let Some((begin, end)) = target_of_a_link(&text) {
        text.replace_range(begin..end, "");
    }
    let paragraphs = text.split("\n\n").map(|lines| lines.replace('\n', " "));
    paragraphs.collect::<Vec<_>>().join("\n\n")
}
