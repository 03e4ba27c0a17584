//! A command as it is spelled out on the command line.

use std::sync::LazyLock;

use clap::error::ErrorKind;
use clap::{Arg, ArgMatches, Command, FromArgMatches, Subcommand};
use coaxle_node::command::{AnyCommand, CommandFamily, ListedCommand};
use coaxle_node::document::from_json_value;
use coaxle_slave as slave;
use serde_json::{Value, json};

use super::blocks::{Block, blocks_of};
use super::cam;
use super::far;
use super::options::{fields_of, subcommand};

/// A command to a slave, or about a far node, with its options.
///
/// Built from the schema of the commands and read by the rules of the network, so that nothing about a
/// command is written down twice.
#[derive(Clone, Debug)]
pub(super) struct SpelledCommand(pub(super) AnyCommand);

const POWER: &str = "power";

/// Every command to a slave but `power`, which has a state instead of options.
static BLOCKS: LazyLock<Vec<Block>> = LazyLock::new(|| {
    let mut blocks = blocks_of::<slave::Command>();
    blocks.retain(|block| block.name != POWER);
    blocks
});

impl Subcommand for SpelledCommand {
    fn augment_subcommands(command: Command) -> Command {
        let power = Command::new(POWER)
            .about("MC_Power: give power, or take it away")
            .arg(Arg::new("state").required(true).value_parser(["on", "off"]));
        command
            .subcommand(power)
            .subcommands(BLOCKS.iter().map(subcommand))
            .subcommands(cam::subcommands())
            .subcommands(far::subcommands())
    }

    fn augment_subcommands_for_update(command: Command) -> Command {
        Self::augment_subcommands(command)
    }

    fn has_subcommand(name: &str) -> bool {
        ListedCommand::of(name).is_some()
    }
}

impl FromArgMatches for SpelledCommand {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let Some((name, options)) = matches.subcommand() else {
            return Err(clap::Error::new(ErrorKind::MissingSubcommand));
        };
        let command = json!({ name: fields(name, options)? });
        from_json_value(&command)
            .map(Self)
            .map_err(|error| clap::Error::raw(ErrorKind::ValueValidation, format!("{error}\n")))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The fields of the command that the options set.
fn fields(name: &str, options: &ArgMatches) -> Result<Value, clap::Error> {
    match ListedCommand::of(name).map(|command| command.family) {
        Some(CommandFamily::Plate(_)) => cam::fields(name, options),
        Some(CommandFamily::Far) => Ok(far::fields(name, options)),
        Some(CommandFamily::Slave) if name == POWER => {
            let state = options.get_one::<String>("state");
            Ok(json!(state.is_some_and(|state| state == "on")))
        }
        Some(CommandFamily::Slave) | None => Ok(fields_of(&BLOCKS, name, options)),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use coaxle_slave::SyncPosition;

    fn parsed(line: &[&str]) -> Result<slave::Command, clap::Error> {
        let command = SpelledCommand::augment_subcommands(Command::new("command"));
        let matches = command.try_get_matches_from(["command"].iter().chain(line))?;
        SpelledCommand::from_arg_matches(&matches).map(|SpelledCommand(command)| match command {
            AnyCommand::Slave(command) => command,
            other => panic!("{other:?}"),
        })
    }

    /// The names of all commands, as the code lists them.
    fn known() -> BTreeSet<String> {
        let error = serde_json::from_value::<slave::Command>(json!({ "dance": {} })).unwrap_err();
        let text = error.to_string();
        let (_, known) = text.split_once("expected one of").unwrap();
        let known = known.split('`').skip(1).step_by(2);
        known.map(str::to_owned).collect()
    }

    #[test]
    fn every_command_can_be_spelled_out() {
        let spelled = BLOCKS.iter().map(|block| block.name.clone());
        let spelled: BTreeSet<_> = spelled.chain([POWER.to_owned()]).collect();
        assert_eq!(spelled, known());
    }

    const POINTS: &str =
        r#"[{ "index": 1, "law": "polynom5", "type": "rest", "master": 0, "slave": 0 }]"#;

    #[test]
    fn every_option_is_a_field_of_its_command() {
        for block in BLOCKS.iter() {
            for field in &block.options {
                // A value of the wrong type: the error must name its field.
                let mut line = vec![block.name.clone()];
                for other in &block.options {
                    if other.required || other.name == field.name {
                        let value = match other.name.as_str() {
                            name if name == field.name => "{\"no\":[]}",
                            "points" => POINTS,
                            "ratios" => "[1]",
                            _ => "1",
                        };
                        line.push(format!("--{}={value}", other.name));
                    }
                }
                let line: Vec<_> = line.iter().map(String::as_str).collect();
                let error = parsed(&line).unwrap_err().to_string();
                let place = format!("{}.{}", block.name, field.path);
                assert!(error.contains(&place), "{line:?}: {error}");
            }
        }
    }

    #[test]
    fn values_have_the_types_of_their_fields() {
        assert_eq!(
            parsed(&["power", "on"]).unwrap(),
            slave::Command::Power(true)
        );
        assert_eq!(
            parsed(&["power", "off"]).unwrap(),
            slave::Command::Power(false)
        );
        assert_eq!(parsed(&["reset"]).unwrap(), slave::Command::Reset {});
        for (text, position) in [("-5", -5.0), (".5", 0.5), ("+1e3", 1e3)] {
            let line = ["home", "--position", text];
            assert_eq!(parsed(&line).unwrap(), slave::Command::Home { position });
        }
        let slave::Command::CamIn(cam_in) = parsed(&[
            "cam-in",
            "--table=3",
            "--activation",
            "at-master-axis-pos",
            "--activation-position",
            "360",
            "--slave-scaling-mode=auto-offset",
        ])
        .unwrap() else {
            panic!("another command");
        };
        assert_eq!((cam_in.table, cam_in.activation.position), (3, 360.0));
    }

    #[test]
    fn sync_positions_may_count_from_now_or_be_of_a_turn() {
        let slave::Command::GearInPos(saw) = parsed(&[
            "gear-in-pos",
            "--ratio=0.6",
            "--master-sync",
            "in-turn=90",
            "--slave-sync=ahead=-1e2",
        ])
        .unwrap() else {
            panic!("another command");
        };
        assert_eq!(
            saw.positions(),
            (SyncPosition::InTurn(90.0), SyncPosition::Ahead(-100.0))
        );
        for (text, expected) in [
            (
                "behind=5",
                "unknown variant `behind`, expected `ahead` or `in-turn`",
            ),
            ("ahead=far", "invalid type: string \"far\", expected f64"),
            (
                "there",
                "expected a position, { ahead = 500 } or { in-turn = 90 }",
            ),
        ] {
            let line = [
                "gear-in-pos",
                "--ratio=1",
                "--slave-sync=0",
                "--master-sync",
                text,
            ];
            let error = parsed(&line).unwrap_err().to_string();
            assert!(
                error.contains("gear-in-pos.master-sync-position"),
                "{error}"
            );
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn what_is_no_number_is_named() {
        for text in ["far", "nan", "inf"] {
            let error = parsed(&["home", "--position", text]).unwrap_err();
            let error = error.to_string();
            assert!(error.contains("home.position"), "{error}");
            assert!(error.contains(text), "{error}");
        }
        assert!(parsed(&["home"]).is_err());
        assert!(parsed(&["dance"]).is_err());
    }
}
