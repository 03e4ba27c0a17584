//! The options of a command, and the fields that they set.

use clap::{Arg, ArgMatches, Command};
use serde_json::{Map, Value, json};

use super::blocks::{Block, CommandOption};

/// Former names of options, by their present ones.
const FORMER: [(&str, &str); 2] = [
    ("master-sync-position", "master-sync"),
    ("slave-sync-position", "slave-sync"),
];

/// The command with its options.
pub(super) fn subcommand(block: &'static Block) -> Command {
    Command::new(block.name.as_str())
        .about(block.about.as_str())
        .args(block.options.iter().map(argument))
}

fn argument(field: &'static CommandOption) -> Arg {
    let former = FORMER.iter().find(|(name, _)| *name == field.name);
    Arg::new(field.name.as_str())
        .long(field.name.as_str())
        .aliases(former.map(|(_, former)| *former))
        .help(field.help.as_str())
        .required(field.required)
        .allow_negative_numbers(true)
}

/// The fields that the options set of the command with this name; null without such a command.
pub(super) fn fields_of(blocks: &[Block], name: &str, options: &ArgMatches) -> Value {
    let Some(block) = blocks.iter().find(|block| block.name == name) else {
        return Value::Null;
    };
    let mut fields = Map::new();
    for field in &block.options {
        if let Some(text) = options.get_one::<String>(field.name.as_str()) {
            set(&mut fields, &field.path, value(text));
        }
    }
    Value::Object(fields)
}

/// Numbers, lists and the like as they are; `in-turn=90` has a reference and a number; everything else is a word.
pub(super) fn value(text: &str) -> Value {
    if let Ok(json) = serde_json::from_str(text) {
        return json;
    }
    if let Some((from, number)) = text.split_once('=') {
        return json!({ from: value(number) });
    }
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => json!(number),
        _ => json!(text),
    }
}

fn set(fields: &mut Map<String, Value>, path: &str, value: Value) {
    match path.split_once('.') {
        None => {
            fields.insert(path.to_owned(), value);
        }
        Some((part, rest)) => {
            let part = fields.entry(part).or_insert_with(|| json!({}));
            if let Value::Object(part) = part {
                set(part, rest, value);
            }
        }
    }
}
