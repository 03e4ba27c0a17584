//! Commands with their options, from the schemas of their types: the name of an option, its field, its help and whether it is
//! required stand at the type, once.

use coaxle_node::config::schema::{alternatives, kind, resolved, schema_of};
use schemars::JsonSchema;
use serde_json::Value;

/// A command of the command line.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) name: String,
    pub(super) about: String,
    pub(super) options: Vec<CommandOption>,
}

/// An option, and the field of the command that it sets.
#[derive(Clone, Debug)]
pub(super) struct CommandOption {
    pub(super) name: String,
    /// Path in the command, with dots.
    pub(super) path: String,
    pub(super) help: String,
    pub(super) required: bool,
}

/// Options that are no name of a field: the last two parts of the path, and the option. A field of a part takes its meaning from
/// that part.
const NAMED_BY_PART: [(&str, &str); 13] = [
    ("activation.mode", "activation"),
    ("activation.position", "activation-position"),
    ("activation.in-turn", "activation-in-turn"),
    ("ratio.numerator", "ratio"),
    ("ratio.denominator", "ratio-denominator"),
    ("master.mode", "master-scaling-mode"),
    ("master.relative", "master-relative"),
    ("master.offset", "master-offset"),
    ("master.scaling", "master-scaling"),
    ("slave.mode", "slave-scaling-mode"),
    ("slave.relative", "slave-relative"),
    ("slave.offset", "slave-offset"),
    ("slave.scaling", "slave-scaling"),
];

/// A field that TwinCAT reserves, and no option sets.
const RESERVED: &str = "sys-cmd";

/// Returns the commands of a type: the variants of an enum, or of several kinds of commands, each with its fields.
pub(super) fn blocks_of<T: JsonSchema>() -> Vec<Block> {
    let root = schema_of::<T>().to_value();
    let mut blocks = Vec::new();
    add_blocks(&root, &root, &mut blocks);
    blocks
}

fn add_blocks(root: &Value, commands: &Value, blocks: &mut Vec<Block>) {
    for command in alternatives(commands).into_iter().flatten() {
        let command = resolved(root, command);
        add_blocks(root, command, blocks);
        let fields = command["properties"].as_object();
        if let Some((name, fields)) = fields.and_then(|fields| fields.iter().next()) {
            let mut options = Vec::new();
            add_options(root, fields, "", true, &mut options);
            blocks.push(Block {
                name: name.clone(),
                about: statement(command),
                options,
            });
        }
    }
}

/// Adds the options of a part of a command, whose path is `of`.
fn add_options(
    root: &Value,
    part: &Value,
    of: &str,
    is_required: bool,
    options: &mut Vec<CommandOption>,
) {
    let part = resolved(root, part);
    let required: Vec<_> = part["required"].as_array().into_iter().flatten().collect();
    for (name, field) in part["properties"].as_object().into_iter().flatten() {
        let path = [of, name].join(if of.is_empty() { "" } else { "." });
        let is_required = is_required && required.iter().any(|required| *required == name);
        let inner = resolved(root, field);
        if inner.get("properties").is_some() && alternatives(inner).is_none() {
            add_options(root, inner, &path, is_required, options);
        } else if name != RESERVED {
            options.push(CommandOption {
                name: option_of(&path),
                help: help(root, field),
                required: is_required,
                path,
            });
        }
    }
}

fn option_of(path: &str) -> String {
    let is_last = |part: &str| path == part || path.ends_with(&format!(".{part}"));
    let named = NAMED_BY_PART.iter().find(|(part, _)| is_last(part));
    let last = path.rsplit('.').next().unwrap_or(path);
    named.map_or(last, |(_, option)| option).to_owned()
}

/// The meaning of a field, and its values where it takes names.
fn help(root: &Value, field: &Value) -> String {
    let meaning = statement(field);
    let inner = resolved(root, field);
    let takes_names = inner.get("enum").is_some()
        || alternatives(inner).is_some_and(|all| all.iter().any(|one| one.get("const").is_some()));
    if takes_names {
        format!("{meaning}: {}", kind(root, inner).replace('"', ""))
    } else {
        meaning
    }
}

/// The first paragraph of a description, without the full stop at its end.
fn statement(schema: &Value) -> String {
    let description = schema["description"].as_str().unwrap_or_default();
    let first = description.split("\n\n").next().unwrap_or_default();
    first.trim_end_matches('.').replace('`', "")
}
