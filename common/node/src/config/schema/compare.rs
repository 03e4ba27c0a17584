//! Comparison of a document with its schema: all missing or unknown fields at once.

use serde_json::Value as Schema;
use toml::{Table, Value};

use super::expected::{expected, variant};
use super::{LAB_MARK, alternatives, resolved};
use crate::config::{Wrong, did_you_mean};

/// Finds all missing or unknown fields of a document. Where a value allows several alternatives and
/// it is ambiguous which is meant, no field is reported.
pub(in crate::config) fn compare(root: &Schema, document: &Table) -> Vec<Wrong> {
    Comparison::of(root, document).findings
}

/// A field of a document that injects or simulates something.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct LabField {
    /// Path of the field.
    pub(crate) field: String,
    /// Text of the field in a `[lab]` table.
    pub(crate) in_lab: String,
}

/// The fields of a document that its schema marks as those that inject or simulate something.
pub(crate) fn lab_fields(root: &Schema, document: &Table) -> Vec<LabField> {
    Comparison::of(root, document).lab_fields
}

/// Greatest number of names listed for an unknown one.
const MOST_LISTED: usize = 24;
/// Greatest number of findings in one document.
const MOST_FINDINGS: usize = 20;

struct Comparison<'s> {
    root: &'s Schema,
    findings: Vec<Wrong>,
    lab_fields: Vec<LabField>,
}

impl<'s> Comparison<'s> {
    fn of(root: &'s Schema, document: &Table) -> Self {
        let mut comparison = Self {
            root,
            findings: Vec::new(),
            lab_fields: Vec::new(),
        };
        comparison.table(root, document, "");
        comparison
    }

    fn value(&mut self, schema: &'s Schema, value: &Value, path: &str) {
        let Some(schema) = self.meant(schema, value) else {
            // Ambiguous: nothing is said rather than something wrong.
            return;
        };
        match value {
            Value::Table(table) => self.table(schema, table, path),
            Value::Array(list) => {
                let items = schema.get("items");
                for (n, element) in list.iter().enumerate() {
                    // Tuples have a schema for each place.
                    let firsts = schema.get("prefixItems").and_then(|firsts| firsts.get(n));
                    if let Some(schema) = firsts.or(items) {
                        self.value(schema, element, &format!("{path}[{n}]"));
                    }
                }
            }
            _ => {}
        }
    }

    fn table(&mut self, schema: &'s Schema, table: &Table, path: &str) {
        let known = schema.get("properties").and_then(Schema::as_object);
        // An open table takes any field, as Zenoh's settings do.
        let is_closed = schema.get("additionalProperties") == Some(&Schema::Bool(false));
        let field = |name: &str| match path {
            "" => name.to_owned(),
            path => format!("{path}.{name}"),
        };
        let mut unknown = Vec::new();
        for (name, value) in table {
            match known.and_then(|known| known.get(name)) {
                Some(schema) => {
                    if let Some(mark) = schema.get(LAB_MARK).and_then(Schema::as_str) {
                        // The mark has a place for the value, so that the message can be copied into the file.
                        self.lab_fields.push(LabField {
                            field: field(name),
                            in_lab: mark.replace("{}", &short(value)),
                        });
                    }
                    self.value(schema, value, &field(name));
                }
                None if is_closed => unknown.push(name.as_str()),
                None => {}
            }
        }
        let names = || known.into_iter().flat_map(|known| known.keys());
        let free = || {
            let free = names().filter(|name| !table.contains_key(*name));
            free.map(String::as_str)
        };
        for name in &unknown {
            // Fields that are not there yet are meant more often than those that are.
            let meant = match did_you_mean(name, free()) {
                meant if meant.is_empty() => did_you_mean(name, names().map(String::as_str)),
                meant => meant,
            };
            let reason = match meant {
                meant if meant.is_empty() => format!("unknown field `{name}`, {}", listed(free())),
                meant => format!("unknown field `{name}`{meant}"),
            };
            self.find(field(name), reason);
        }
        let required = schema.get("required").and_then(Schema::as_array);
        for name in required.into_iter().flatten().filter_map(Schema::as_str) {
            // A typo is one mistake, not two.
            let is_typo = |typo: &&str| !did_you_mean(typo, [name]).is_empty();
            if table.contains_key(name) || unknown.iter().any(is_typo) {
                continue;
            }
            let schema = known.and_then(|known| known.get(name));
            let expected = schema.map_or("one".to_owned(), |schema| expected(self.root, schema));
            self.find(field(name), format!("missing, expected {expected}"));
        }
    }

    fn find(&mut self, field: String, reason: String) {
        if self.findings.len() < MOST_FINDINGS {
            self.findings.push(Wrong::with_reason(field, reason));
        }
    }

    /// The schema that applies to a value, if it is unambiguous.
    fn meant(&self, schema: &'s Schema, value: &Value) -> Option<&'s Schema> {
        let mut candidates = Vec::new();
        self.candidates(schema, value, &mut candidates);
        // No candidate, or several: the document does not say which is meant.
        match candidates[..] {
            [only] => Some(only),
            _ => None,
        }
    }

    fn candidates(&self, schema: &'s Schema, value: &Value, candidates: &mut Vec<&'s Schema>) {
        let schema = resolved(self.root, schema);
        match alternatives(schema) {
            Some(all) => {
                // Alternatives may have alternatives.
                for one in all {
                    self.candidates(one, value, candidates);
                }
            }
            None if fits(schema, value) => candidates.push(schema),
            None => {}
        }
    }
}

/// A value on one line, its beginning if it is long.
fn short(value: &Value) -> String {
    /// Characters of a value in a message.
    const MOST: usize = 120;
    let text = value.to_string();
    // Cut at a character, not in the middle of its bytes.
    match text.char_indices().nth(MOST) {
        None => text,
        Some((end, _)) => format!("{} …", &text[..end]),
    }
}

/// True if a value matches the kind of a schema: for a variant of an enum, if it is this variant.
fn fits(schema: &Schema, value: &Value) -> bool {
    let kind = schema.get("type").and_then(Schema::as_str);
    match value {
        // A variant of an enum is a table with its name as the only key.
        Value::Table(table) if kind == Some("object") => match variant(schema) {
            Some(name) => table.contains_key(name),
            None => true,
        },
        Value::Array(_) => kind == Some("array"),
        // Plain values have no fields that could be missing.
        _ => false,
    }
}

fn listed<'n>(names: impl Iterator<Item = &'n str>) -> String {
    let mut names: Vec<_> = names.map(|name| format!("`{name}`")).collect();
    let left_out = names.len().saturating_sub(MOST_LISTED);
    names.truncate(MOST_LISTED);
    match (&names[..], left_out) {
        ([], _) => "expected none".to_owned(),
        (names, 0) => format!("expected one of {}", names.join(", ")),
        (names, more) => format!("expected one of {}, and {more} more", names.join(", ")),
    }
}
