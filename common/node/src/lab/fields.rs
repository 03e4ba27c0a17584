//! The fields of a `[lab]` table, for people.

use std::fmt;

use coaxle_wire::one_line;
use toml::Value;

/// Injected faults and simulated inputs of a `[lab]` table: each field with its value.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LabFields(Vec<String>);

impl LabFields {
    pub(super) fn of(table: &Value) -> Self {
        let mut fields = Vec::new();
        collect("lab", table, &mut fields);
        Self(fields)
    }

    /// Returns the reason why a node that is to run a machine does not start.
    #[must_use]
    pub fn refusal(&self) -> String {
        format!(
            "lab: received {self}, expected no [lab] table: no fault is injected into a machine; take the table out, or start \
             the node with --lab for an experiment"
        )
    }
}

impl fmt::Display for LabFields {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0[..] {
            [] => f.write_str("nothing injected or simulated"),
            fields => f.write_str(&one_line(&fields.join(", "))),
        }
    }
}

/// Collects each value that is no table, with its path. Elements of lists are named by the node or slave that they are for.
fn collect(path: &str, value: &Value, fields: &mut Vec<String>) {
    match value {
        Value::Table(table) => {
            for (name, value) in table {
                collect(&format!("{path}.{name}"), value, fields);
            }
        }
        // A list of numbers is one value, a list of parts has names.
        Value::Array(list) if list.iter().any(|element| key_of(element).is_some()) => {
            for element in list {
                let Some((key, name)) = key_of(element) else {
                    continue;
                };
                let mut rest = element.clone();
                if let Value::Table(rest) = &mut rest {
                    // The name stands before the path, not among the fields.
                    rest.remove(key);
                }
                collect(&format!("{path} {name:?}"), &rest, fields);
            }
        }
        value => fields.push(format!("{path} = {value}")),
    }
}

/// Returns the key and the name that identify an element of a list.
fn key_of(element: &Value) -> Option<(&'static str, &str)> {
    // A far node is known by its node, a slave by its name.
    ["node", "name"].into_iter().find_map(|key| {
        let name = element.get(key)?.as_str()?;
        Some((key, name))
    })
}
