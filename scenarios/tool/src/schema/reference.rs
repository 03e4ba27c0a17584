//! `docs/REFERENCE.md`, made from the schemas.
#![cfg(test)]

use std::collections::BTreeSet;
use std::fmt::Write;

use coaxle_files::cam::CamFile;
use coaxle_files::gear::GearFile;
use coaxle_files::saw::SawFile;
use coaxle_gateway::config::{GatewayConfig, GatewayLab};
use coaxle_lab::scenario::Scenario;
use coaxle_lab::summary::{ReceiverSummary, SlaveSummary};
use coaxle_node::config::schema::{alternatives, kind, resolved, schema_without_lab_fields};
use coaxle_receiver::ReceiverConfig;
use coaxle_receiver::config::ReceiverLab;
use coaxle_sender::config::{SenderConfig, SenderLab};
use schemars::JsonSchema;
use serde_json::Value;

use super::figures;

/// Schema over all files together, so that a definition in several of them is described once.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its schema is used")]
struct All {
    scenario: Scenario,
    sender: SenderConfig,
    sender_lab: SenderLab,
    receiver: ReceiverConfig,
    receiver_lab: ReceiverLab,
    gateway: GatewayConfig,
    gateway_lab: GatewayLab,
    cam: CamFile,
    saw: SawFile,
    gear: GearFile,
    receiver_figures: ReceiverSummary,
    slave_figures: SlaveSummary,
}

/// The files: property, heading.
const FILES: [(&str, &str); 10] = [
    ("scenario", "A scenario"),
    ("sender", "The config of a sender"),
    ("sender_lab", "The lab table of a sender"),
    ("receiver", "The config of a receiver"),
    ("receiver_lab", "The lab table of a receiver"),
    ("gateway", "The config of a gateway"),
    ("gateway_lab", "The lab table of a gateway"),
    ("cam", "A cam file"),
    ("saw", "A saw file"),
    ("gear", "A gear file"),
];

/// The page.
pub(super) fn page() -> String {
    let root = schema_without_lab_fields::<All>().to_value();
    let mut page = Page {
        root: &root,
        text: INTRODUCTION.to_owned(),
        named: Vec::new(),
        seen: BTreeSet::new(),
    };
    for (property, _) in FILES {
        // First all files, so that links lead to their own sections and not to a definition.
        page.seen.insert(name_of(&root["properties"][property]));
    }
    for (property, heading) in FILES {
        page.section(2, heading, page.property(property));
    }
    page.definitions();
    for (property, heading, signals) in [
        (
            "receiver_figures",
            "Figures of a receiver",
            figures::of_receiver(),
        ),
        ("slave_figures", "Figures of a slave", figures::of_slave()),
    ] {
        page.figures(property, heading, &signals);
    }
    page.text
}

struct Page<'s> {
    root: &'s Value,
    text: String,
    /// Definitions that were named, in the order in which they were first.
    named: Vec<String>,
    seen: BTreeSet<String>,
}

impl<'s> Page<'s> {
    fn property(&self, name: &str) -> &'s Value {
        resolved(self.root, &self.root["properties"][name])
    }

    /// Writes the definitions that the files above name, and those named by these.
    fn definitions(&mut self) {
        self.text += "\n## What these are made of\n";
        let mut next = 0;
        // By index, since a section may name further definitions while the list is walked through.
        while let Some(name) = self.named.get(next).cloned() {
            let schema = &self.root["$defs"][&name];
            self.section(3, shown(&name), schema);
            next += 1;
        }
    }

    fn section(&mut self, level: usize, heading: &str, schema: &'s Value) {
        let _ = write!(self.text, "\n{} {heading}\n\n", "#".repeat(level));
        if let Some(meaning) = schema["description"].as_str() {
            let _ = writeln!(self.text, "{meaning}\n");
        }
        let mut rows = Vec::new();
        self.rows("", schema, &mut rows);
        if rows.is_empty() {
            let what = self.kind(schema);
            let _ = writeln!(self.text, "It is {what}.");
            return;
        }
        self.text += "| field or value | what it is | default | meaning |\n|--|--|--|--|\n";
        for row in rows {
            let _ = writeln!(self.text, "{row}");
        }
    }

    fn rows(&mut self, prefix: &str, schema: &'s Value, rows: &mut Vec<String>) {
        let required = schema["required"].as_array().into_iter().flatten();
        let required: BTreeSet<_> = required.filter_map(Value::as_str).collect();
        for (name, field) in schema["properties"].as_object().into_iter().flatten() {
            let default = match field.get("default") {
                // The fields of a table have their own defaults in their own rows.
                Some(Value::Object(_)) => String::new(),
                Some(value) => format!("`{value}`"),
                None if required.contains(name.as_str()) => "required".to_owned(),
                // An optional field without a default has an empty cell: its meaning says what happens without it.
                None => String::new(),
            };
            let name = format!("{prefix}{name}");
            self.row(&format!("`{name}`"), field, &default, rows);
            self.inner_rows(&name, field, rows);
        }
        for one in alternatives(schema).into_iter().flatten() {
            self.alternative(one, rows);
        }
        for value in schema["enum"].as_array().into_iter().flatten() {
            rows.push(format!("| `{value}` |  |  |  |"));
        }
    }

    /// The fields of a table that has no name of its own.
    fn inner_rows(&mut self, name: &str, field: &'s Value, rows: &mut Vec<String>) {
        // A named table has its own section instead.
        if field.get("$ref").is_none() && field.get("properties").is_some() {
            self.rows(&format!("{name}."), field, rows);
        }
    }

    fn alternative(&mut self, one: &'s Value, rows: &mut Vec<String>) {
        if let Some(value) = one.get("const") {
            let meaning = cell(one["description"].as_str().unwrap_or_default());
            rows.push(format!("| `{value}` |  |  | {meaning} |"));
            return;
        }
        let (Some(fields), None) = (one["properties"].as_object(), one.get("$ref")) else {
            match alternatives(one) {
                Some(all) => all.iter().for_each(|one| self.alternative(one, rows)),
                None if one.get("enum").is_some() => self.rows("", one, rows),
                None => self.row("", one, "", rows),
            }
            return;
        };
        for (name, field) in fields {
            let mut what = self.kind(field);
            if field["type"] == "object" && field.get("properties").is_none() {
                what = "`{}`".to_owned();
            }
            let meaning = one["description"]
                .as_str()
                .or(field["description"].as_str());
            let meaning = cell(meaning.unwrap_or_default());
            rows.push(format!("| `{name}` | {what} |  | {meaning} |"));
            self.inner_rows(name, field, rows);
        }
    }

    fn row(&mut self, name: &str, field: &'s Value, default: &str, rows: &mut Vec<String>) {
        let what = self.kind(field);
        let meaning = cell(field["description"].as_str().unwrap_or_default());
        rows.push(format!("| {name} | {what} | {default} | {meaning} |"));
    }

    /// Kind of a value, with a link to the section of a named definition.
    fn kind(&mut self, schema: &Value) -> String {
        if schema.get("$ref").is_some() {
            let name = name_of(schema);
            let link = format!("[{}](#{})", shown(&name), self.anchor(&name));
            // Queued once, as a section of its own follows for each name.
            if self.seen.insert(name.clone()) {
                self.named.push(name);
            }
            return link;
        }
        if let Some(all) = alternatives(schema) {
            let kinds: Vec<_> = all.iter().map(|one| self.kind(one)).collect();
            return kinds.join(" or ");
        }
        match (schema.get("items"), schema.get("additionalProperties")) {
            (Some(items), _) => format!("{}: each {}", kind(self.root, schema), self.kind(items)),
            (None, Some(Value::Object(_))) => "a table of any fields".to_owned(),
            _ => cell(&kind(self.root, schema)),
        }
    }

    /// Anchor of a definition. A file's definition is under the heading of the file.
    fn anchor(&self, name: &str) -> String {
        let properties = &self.root["properties"];
        let mut files = FILES.iter();
        let file = files.find(|(property, _)| name_of(&properties[property]) == name);
        let heading = file.map_or(shown(name), |(_, heading)| heading);
        // As GitHub makes anchors of headings.
        heading.to_lowercase().replace(' ', "-")
    }

    fn figures(&mut self, property: &str, heading: &str, signals: &str) {
        let schema = self.property(property);
        let _ = write!(self.text, "\n## {heading}\n\n");
        let _ = writeln!(
            self.text,
            "{}\n",
            schema["description"].as_str().unwrap_or_default()
        );
        self.text += "| figure | meaning |\n|--|--|\n";
        for (name, field) in schema["properties"].as_object().into_iter().flatten() {
            let meaning = cell(field["description"].as_str().unwrap_or_default());
            let _ = writeln!(self.text, "| `{name}` | {meaning} |");
        }
        self.text += signals;
    }
}

fn name_of(schema: &Value) -> String {
    let target = schema["$ref"].as_str().unwrap_or_default();
    target.rsplit('/').next().unwrap_or_default().to_owned()
}

/// Heading of a definition. Commands have their positions as a type parameter, which schemas name; plain numbers go without.
fn shown(definition: &str) -> &str {
    // `schemars` names a generic type after its parameters.
    definition.strip_suffix("Atdouble").unwrap_or(definition)
}

/// A text in a cell of a table.
fn cell(text: &str) -> String {
    // A line break would end the row, a bar the cell.
    text.replace("\n\n", " ").replace('|', "\\|")
}

const INTRODUCTION: &str = "# Reference of the files

Every field of every file, with its range, its default and its meaning; and the figures of `summary.json`. All files are TOML,
names are kebab-case, unknown fields are refused. Where a name does not say its unit, the meaning does; `u` is the unit of the
axis.

An editor shows the same while a file is written, completes names and marks what is wrong, by a JSON Schema:
`coaxle schema --out schemas` writes one for each kind of file. A first line in the file says which one is its own, for
[Taplo](https://taplo.tamasfe.dev) and so for the extension *Even Better TOML* of Visual Studio Code:

```toml
#:schema ./schemas/coaxle-receiver.schema.json
```

What is injected or simulated for an experiment is apart: the config of a node has it in a table `[lab]`, without which a machine runs,
and with which a node starts with `--lab` only. A scenario is an experiment. Its nodes have the same fields in their places:
`clock` and `seed` of each sender and receiver; `faults`, `request-faults` and `timing.faults` of each `[[receiver.far]]`, or beside
`master`; `marks` and `tool` of each `[[receiver.slave]]`.

What a schema cannot say, such as that a name is one of another list, is checked when a file is read: `coaxle check SCENARIO`,
`coaxle sender CONFIG --check`, `coaxle receiver CONFIG --check`, `coaxle cam check FILE` and `coaxle saw plan FILE` read
one and say what is wrong in it, with line and column.

This page is made from the types that read the files: `UPDATE_DOCS=1 cargo test -p coaxle reference` writes it again. What
signals mean is in [SIGNALS.md](SIGNALS.md).
";
