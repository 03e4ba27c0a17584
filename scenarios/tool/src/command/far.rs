//! Commands about a far node, as the command line spells them.

use std::sync::LazyLock;

use clap::{Arg, ArgMatches, Command};
use coaxle_node::command::FarCommand;
use serde_json::{Value, json};

use super::blocks::{Block, blocks_of};
use super::options::{fields_of, subcommand, value};

const FILTER_MODE: &str = "filter-mode";
const SET_DELAY: &str = "set-delay";
const VALUE: &str = "value";

/// Commands about a far node that have their value as an argument of its own.
const POSITIONAL: [&str; 2] = [FILTER_MODE, SET_DELAY];

static BLOCKS: LazyLock<Vec<Block>> = LazyLock::new(|| {
    let mut blocks = blocks_of::<FarCommand>();
    for block in &mut blocks {
        block.about = format!("With --far: {}", block.about);
    }
    blocks
});

/// Every command about a far node.
pub(super) fn subcommands() -> Vec<Command> {
    let value = |name| match name {
        FILTER_MODE => Arg::new(VALUE)
            .value_name("MODE")
            .value_parser(["sync", "bypass", "pt1", "time", "observer"]),
        _ => Arg::new(VALUE)
            .value_name("DELAY")
            .help("measured, off, or a number of µs")
            .allow_negative_numbers(true),
    };
    let command = |block: &'static Block| {
        let command = subcommand(block);
        if POSITIONAL.contains(&block.name.as_str()) {
            command.arg(value(&block.name).required(true))
        } else {
            command
        }
    };
    BLOCKS.iter().map(command).collect()
}

/// The command as the network has it.
pub(super) fn fields(name: &str, options: &ArgMatches) -> Value {
    let word = || options.get_one::<String>(VALUE).map(String::as_str);
    match name {
        FILTER_MODE => json!(word()),
        SET_DELAY => match word() {
            Some(word @ ("measured" | "off")) => json!(word),
            other => json!({ "fixed-us": value(other.unwrap_or_default()) }),
        },
        _ => fields_of(&BLOCKS, name, options),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn parsed(line: &[&str]) -> Result<FarCommand, String> {
        let command = Command::new("command").subcommands(subcommands());
        let matches = command
            .try_get_matches_from(["command"].iter().chain(line))
            .map_err(|error| error.to_string())?;
        let (name, options) = matches.subcommand().expect("a command");
        serde_json::from_value(json!({ name: fields(name, options) }))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn every_command_can_be_spelled_out() {
        let error = serde_json::from_value::<FarCommand>(json!({ "dance": {} })).unwrap_err();
        let text = error.to_string();
        let (_, known) = text.split_once("expected one of").expect("a list");
        let known: BTreeSet<_> = known.split('`').skip(1).step_by(2).collect();
        let keys = FarCommand::ROWS.iter().map(|row| row.key);
        assert_eq!(known, keys.collect());
        let spelled = subcommands();
        let spelled: BTreeSet<_> = spelled.iter().map(Command::get_name).collect();
        assert_eq!(spelled, known);
    }

    #[test]
    fn words_and_numbers_become_the_command_of_the_network() {
        for (line, expected) in [
            (&["disable"][..], json!({ "disable": {} })),
            (&["filter-mode", "pt1"], json!({ "filter-mode": "pt1" })),
            (&["set-delay", "off"], json!({ "set-delay": "off" })),
            (
                &["set-delay", "-12.5"],
                json!({ "set-delay": { "fixed-us": -12.5 } }),
            ),
            (
                &[
                    "set-parameters",
                    "--blending-time-s=0.1",
                    "--force-time-mode=true",
                ],
                json!({ "set-parameters": {
                    "extrapolate": { "blending-time-s": 0.1 },
                    "time-sync": { "force-time-mode": true } } }),
            ),
        ] {
            let command = parsed(line).expect("a command");
            assert_eq!(serde_json::to_value(command).expect("JSON"), expected);
        }
    }

    #[test]
    fn every_parameter_has_an_option_but_for_the_reserved_ones() {
        let is_it = |block: &&Block| block.name == "set-parameters";
        let parameters = BLOCKS.iter().find(is_it).expect("the parameters");
        for field in &parameters.options {
            let value = match field.name.as_str() {
                "start-up-mode" | "fall-back-mode" => "pt1",
                "use-acc-for-extrapolation" | "force-time-mode" | "automatic-re-init" => "true",
                _ => "1",
            };
            let option = format!("--{}={value}", field.name);
            let command = parsed(&["set-parameters", &option]).expect("a command");
            let text = serde_json::to_string(&command).expect("JSON");
            assert!(text.contains(&format!("\"{}\":", field.name)), "{text}");
        }
        assert_eq!(parameters.options.len(), 2 + 5 + 13);
    }

    #[test]
    fn what_is_none_of_them_is_named() {
        assert!(
            parsed(&["filter-mode", "fast"])
                .unwrap_err()
                .contains("observer")
        );
        assert!(parsed(&["set-delay", "long"]).unwrap_err().contains("long"));
    }
}
