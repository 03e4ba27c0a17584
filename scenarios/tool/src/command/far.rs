//! Commands about a far node, as the command line spells them.

use clap::{Arg, ArgMatches, Command};
use coaxle_node::command::FarCommand;
use serde_json::{Map, Value, json};

use super::blocks::{Block, inner};
use super::options::{fields_of, subcommand, value};

const FILTER_MODE: &str = "filter-mode";
const SET_DELAY: &str = "set-delay";
const SET_PARAMETERS: &str = "set-parameters";

/// Commands without options.
const PLAIN: [(&str, &str); 3] = [
    (
        "enable",
        "With --far: bEnable = TRUE, what was disabled starts anew",
    ),
    (
        "disable",
        "With --far: bEnable = FALSE, the axes pass through as they come",
    ),
    (
        "re-initialise",
        "With --far: forget what was learnt, and the error, and start anew",
    ),
];

/// True if the name is a command about a far node.
pub(super) fn has(name: &str) -> bool {
    FarCommand::NAMES.contains(&name)
}

/// Every command about a far node.
pub(super) fn subcommands() -> Vec<Command> {
    let mode = Command::new(FILTER_MODE)
        .about("With --far: eFilterMode, how the set values are calculated")
        .arg(
            Arg::new("mode")
                .required(true)
                .value_parser(["sync", "bypass", "pt1", "time", "observer"]),
        );
    let delay = Command::new(SET_DELAY)
        .about("With --far: where the constant part of the delay comes from, in observer mode")
        .arg(
            Arg::new("delay")
                .required(true)
                .help("measured, off, or that many µs")
                .allow_negative_numbers(true),
        );
    let plain = PLAIN.map(|(name, about)| Command::new(name).about(about));
    let parameters = subcommand(parameters());
    plain.into_iter().chain([mode, delay, parameters]).collect()
}

/// The command as the network has it.
pub(super) fn fields(name: &str, options: &ArgMatches) -> Value {
    let word = |argument| options.get_one::<String>(argument).map(String::as_str);
    match name {
        FILTER_MODE => json!(word("mode")),
        SET_DELAY => match word("delay") {
            Some(word @ ("measured" | "off")) => json!(word),
            other => json!({ "fixed-us": value(other.unwrap_or_default()) }),
        },
        SET_PARAMETERS => fields_of(&parameters(), options),
        _ => Value::Object(Map::new()),
    }
}

fn parameters() -> Block {
    Block {
        name: SET_PARAMETERS,
        about: "With --far: stAxisSyncParameters, those that are given",
        options: vec![
            inner("start-up-mode", "start-up-mode", "bypass, pt1 or time"),
            inner("fall-back-mode", "fall-back-mode", "bypass or pt1"),
            inner(
                "max-position-diff",
                "extrapolate.max-position-diff",
                "Largest difference of the set positions, u; 0: not watched",
            ),
            inner(
                "use-acc-for-extrapolation",
                "extrapolate.use-acc-for-extrapolation",
                "true or false",
            ),
            inner("t1-factor-pos", "extrapolate.t1-factor-pos", "Cycles"),
            inner("t1-factor-velo", "extrapolate.t1-factor-velo", "Cycles"),
            inner("blending-time-s", "extrapolate.blending-time-s", "s"),
            inner(
                "threshold-for-sync",
                "time-sync.threshold-for-sync",
                "Receiver cycles",
            ),
            inner(
                "max-cycle-index-difference",
                "time-sync.max-cycle-index-difference",
                "0: not watched",
            ),
            inner(
                "age-of-data-limit",
                "time-sync.age-of-data-limit",
                "Receiver cycles; 0: not watched",
            ),
            inner(
                "no-of-periods-for-mean-drift",
                "time-sync.no-of-periods-for-mean-drift",
                "1 to 64",
            ),
            inner(
                "delay-time-offset-s",
                "time-sync.delay-time-offset-s",
                "Added to the correction time, s",
            ),
            inner("slope1-numerator", "time-sync.slope1-numerator", "0 to 1"),
            inner(
                "slope1-denominator",
                "time-sync.slope1-denominator",
                "Above 0, below 1",
            ),
            inner(
                "end-of-transition-limit",
                "time-sync.end-of-transition-limit",
                "Receiver cycles",
            ),
            inner(
                "new-drift-bending-cycles",
                "time-sync.new-drift-bending-cycles",
                "Receiver cycles",
            ),
            inner(
                "time-mode-blending-cycles",
                "time-sync.time-mode-blending-cycles",
                "Receiver cycles",
            ),
            inner(
                "data-cycle-time-s",
                "time-sync.data-cycle-time-s",
                "What the node's frames say, s; 0: whatever they say",
            ),
            inner(
                "force-time-mode",
                "time-sync.force-time-mode",
                "true or false",
            ),
            inner(
                "automatic-re-init",
                "time-sync.automatic-re-init",
                "true or false",
            ),
        ],
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
        assert_eq!(known, BTreeSet::from(FarCommand::NAMES));
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
        for field in parameters().options {
            let value = match field.name {
                "start-up-mode" | "fall-back-mode" => "pt1",
                "use-acc-for-extrapolation" | "force-time-mode" | "automatic-re-init" => "true",
                _ => "1",
            };
            let option = format!("--{}={value}", field.name);
            let command = parsed(&["set-parameters", &option]).expect("a command");
            let text = serde_json::to_string(&command).expect("JSON");
            assert!(text.contains(&format!("\"{}\":", field.name)), "{text}");
        }
        assert_eq!(parameters().options.len(), 2 + 5 + 13);
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
