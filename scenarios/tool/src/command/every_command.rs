//! Every command in the table can be given in each way that there is: as an order on the wire, by an event of a scenario, by a
//! step of a program, and on the command line. The examples are those of `docs/WIRE.md`, which has one for each.

use std::collections::BTreeMap;
use std::path::Path;

use clap::{Command, FromArgMatches, Subcommand};
use coaxle_lab::event::{Event, EventKind};
use coaxle_node::CommandOrder;
use coaxle_node::command::{AnyCommand, CommandFamily, ListedCommand, PlateWork};
use coaxle_node::config::parse;
use coaxle_receiver::StepConfig;
use serde_json::{Value, json};

use super::blocks::blocks_of;
use super::spelled::SpelledCommand;

/// The fields of each command in the examples, by its key.
fn examples() -> BTreeMap<String, Value> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/WIRE.md");
    let page = std::fs::read_to_string(page).expect("docs/WIRE.md");
    let rows = page
        .lines()
        .filter_map(|line| line.strip_prefix("| `{ \"")?.split_once("` |"));
    rows.filter_map(|(example, _)| {
        let command: Value = serde_json::from_str(&format!("{{ \"{example}")).ok()?;
        let (key, fields) = command.as_object()?.iter().next()?;
        Some((key.clone(), fields.clone()))
    })
    .collect()
}

fn example_of(command: &ListedCommand, examples: &BTreeMap<String, Value>) -> Value {
    let fields = examples.get(command.key);
    let fields = fields.unwrap_or_else(|| panic!("no example of {}", command.key));
    json!({ command.key: fields })
}

/// The command as the network reads it.
fn by_order(listed: &ListedCommand, command: &Value) -> AnyCommand {
    let order = json!({ "version": 1, addressee_of(listed): "x", "command": command });
    let order = CommandOrder::from_json(order.to_string().as_bytes());
    let order = order.unwrap_or_else(|error| panic!("{}: {error}", listed.key));
    order.into_parts().1
}

const fn addressee_of(listed: &ListedCommand) -> &'static str {
    if listed.family.is_about_far_node() {
        "far"
    } else {
        "slave"
    }
}

/// A JSON value in a line of TOML.
fn in_toml(value: &Value) -> String {
    match value {
        Value::Object(fields) => {
            let fields = fields
                .iter()
                .map(|(name, value)| format!("{name} = {}", in_toml(value)));
            format!("{{ {} }}", fields.collect::<Vec<_>>().join(", "))
        }
        Value::Array(items) => {
            let items = items.iter().map(in_toml);
            format!("[{}]", items.collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

#[test]
fn a_scenario_gives_every_command() {
    let examples = examples();
    for listed in ListedCommand::all() {
        let command = example_of(&listed, &examples);
        let text = format!(
            "at-s = 1\nnode = 'n'\n{} = 'x'\ncommand = {}",
            addressee_of(&listed),
            in_toml(&command)
        );
        let event = parse::<Event>("e", &text).unwrap_or_else(|error| panic!("{text}: {error}"));
        let EventKind::Command(commanded) = event.what else {
            panic!("{text}");
        };
        let expected = by_order(&listed, &command);
        assert_eq!(commanded.order.into_parts().1, expected, "{text}");
    }
}

#[test]
fn a_program_gives_every_command_to_its_slave_and_changes_plates() {
    let examples = examples();
    for listed in ListedCommand::all() {
        let command = example_of(&listed, &examples);
        let text = format!("do = {}", in_toml(&command));
        let step = parse::<StepConfig>("s", &text);
        let is_for_steps = matches!(
            listed.family,
            CommandFamily::Slave | CommandFamily::Plate(PlateWork::Changes)
        );
        if !is_for_steps {
            let error = step.expect_err("no command of a step").to_string();
            let received = format!("do: received {:?}, expected one of `power`", listed.key);
            assert!(error.contains(&received), "{error}");
            continue;
        }
        let step = step.unwrap_or_else(|error| panic!("{text}: {error}"));
        let expected = by_order(&listed, &command);
        assert_eq!(step.command.expect("a command").name(), expected.name());
        if let AnyCommand::Slave(expected) = expected {
            let command = parse::<StepConfig>("s", &text).expect("as before");
            assert_eq!(command.slave_command(), Some(&expected));
        }
    }
}

/// The words on the command line for a command.
fn spelled(listed: &ListedCommand, fields: &Value, folder: &Path) -> Vec<String> {
    let mut words = vec![listed.key.to_owned()];
    match (listed.key, fields) {
        ("power", Value::Bool(on)) => words.push(if *on { "on" } else { "off" }.to_owned()),
        ("filter-mode", mode) => words.push(word(mode)),
        ("set-delay", Value::Object(fixed)) => words.push(word(&fixed["fixed-us"])),
        ("set-delay", delay) => words.push(word(delay)),
        ("cam-table-select", fields) => {
            let file = folder.join("plate.toml");
            let plate = toml::to_string(&fields["plate"]).expect("a cam file");
            std::fs::write(&file, plate).expect("a file");
            words.push(file.display().to_string());
            let table = fields.get("table").map(|table| format!("--table={table}"));
            let replace = fields["replace"] == json!(true);
            words.extend(table);
            words.extend(replace.then(|| "--replace".to_owned()));
        }
        (key, fields) => {
            let blocks = blocks_of::<AnyCommand>();
            let block = blocks.iter().find(|block| block.name == key);
            for option in &block.expect("a command").options {
                let pointer = format!("/{}", option.path.replace('.', "/"));
                let value = fields.pointer(&pointer);
                words.extend(value.map(|value| format!("--{}={}", option.name, word(value))));
            }
        }
    }
    words
}

fn word(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

#[test]
fn the_command_line_gives_every_command() {
    let examples = examples();
    let folder = tempfile::tempdir().expect("a folder");
    for listed in ListedCommand::all() {
        let mut command = example_of(&listed, &examples);
        // TwinCAT reserves this field of both parts, and no option sets it.
        for part in ["time-sync", "extrapolate"] {
            let part = command.pointer_mut(&format!("/set-parameters/{part}"));
            if let Some(fields) = part.and_then(Value::as_object_mut) {
                fields.remove("sys-cmd").expect("the reserved field");
            }
        }
        let words = spelled(&listed, &command[listed.key], folder.path());
        let line = ["command".to_owned()].into_iter().chain(words.clone());
        let matches = SpelledCommand::augment_subcommands(Command::new("command"))
            .try_get_matches_from(line)
            .and_then(|matches| SpelledCommand::from_arg_matches(&matches));
        let SpelledCommand(given) = matches.unwrap_or_else(|error| panic!("{words:?}: {error}"));
        assert_eq!(given, by_order(&listed, &command), "{words:?}");
    }
}
