//! `coaxle command`: tells a slave of a running node what to do.

mod blocks;
mod network;
mod saw;
mod spelled;

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::Args;
use coaxle_host::Commander;
use coaxle_node::CommandOrder;
use coaxle_node::command::{CommandAnswer, CommandVerdict, SlaveName};
use coaxle_node::keys::NodeName;
use coaxle_slave as slave;

use crate::inspect;
use spelled::Spelled;

/// Who is told what.
#[derive(Debug, Args)]
#[command(
    subcommand_value_name = "COMMAND",
    subcommand_help_heading = "Commands"
)]
pub struct CommandArgs {
    /// The node that the slave belongs to
    #[arg(value_parser = |name: &str| NodeName::new(name))]
    node: NodeName,
    /// The slave
    slave: SlaveName,
    #[command(subcommand)]
    spelled: Option<Spelled>,
    /// The command as JSON, as the network has it: '{ "halt": {} }'
    #[arg(long, value_name = "JSON")]
    order: Option<String>,
    /// Only ask what would come of it
    #[arg(long, global = true)]
    dry_run: bool,
    /// Print the node's answer as JSON
    #[arg(long, global = true)]
    json: bool,
    /// Look for the node here, such as tcp/192.168.1.10:7448; may be given several times [default:
    /// this machine, ports 7447 and 7448]
    #[arg(long, global = true, value_name = "ENDPOINT")]
    connect: Vec<String>,
    /// Look for the node where this config file of a node says: where it listens, and where it
    /// connects to
    #[arg(long, global = true, value_name = "FILE", conflicts_with = "connect")]
    config: Option<PathBuf>,
}

/// Sends the command and prints the answer; false if it is not accepted.
///
/// # Errors
/// No command, or more than one; the node does not turn up or does not answer.
pub fn print(args: &CommandArgs) -> anyhow::Result<bool> {
    let order = CommandOrder {
        slave: args.slave,
        command: args.command()?,
        dry_run: args.dry_run,
    };
    let transport = network::transport(&args.connect, args.config.as_deref())?;
    let commander = Commander::open(&transport)?;
    let answer = commander.send(&args.node, &order);
    commander.close();
    let answer = answer?;
    inspect::print(|out| {
        if args.json {
            writeln!(out, "{}", answer.to_json())?;
        } else {
            writeln!(out, "{}/{}: {}", args.node, args.slave, in_words(&answer))?;
        }
        Ok(answer.is_accepted())
    })
}

impl CommandArgs {
    fn command(&self) -> anyhow::Result<slave::Command> {
        match (&self.spelled, &self.order) {
            (Some(spelled), None) => Ok(spelled.0),
            (None, Some(json)) => {
                let mut json = serde_json::Deserializer::from_str(json);
                serde_path_to_error::deserialize(&mut json).context("--order")
            }
            (None, None) => bail!("expected a command, or --order; see coaxle command --help"),
            (Some(_), Some(_)) => bail!("received a command and --order, expected one of them"),
        }
    }
}

fn in_words(answer: &CommandAnswer) -> String {
    let (verdict, axis, saw) = match &answer.verdict {
        CommandVerdict::Accepted {
            dry_run,
            job,
            awaits,
            axis,
            saw,
        } => {
            let mut verdict = match (dry_run, job) {
                (true, _) => "would be accepted".to_owned(),
                (false, Some(job)) => format!("accepted, job {job}"),
                (false, None) => "accepted".to_owned(),
            };
            if !awaits.is_empty() {
                verdict += &format!("; checked when it is due: {}", awaits.join(", "));
            }
            (verdict, axis, saw.as_ref().map(saw::accepted))
        }
        CommandVerdict::Refused {
            dry_run,
            text,
            axis,
            saw,
            ..
        } => {
            let would = if *dry_run { "would be " } else { "" };
            let refused = format!("{would}refused, {text}");
            (refused, axis, saw.as_ref().map(saw::refused))
        }
        CommandVerdict::NotTaken { text, .. } => return format!("not taken: {text}"),
    };
    let saw = saw.unwrap_or_default();
    format!(
        "{verdict}; the slave is in {} at {}, velocity {}{saw}",
        axis.status, axis.position, axis.velocity
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use coaxle_axis::{Awaits, AxisStatus};
    use coaxle_node::command::{CommandOutcome, NotTaken, SlaveView};
    use coaxle_slave::{Dynamics, Refusal};

    #[derive(Debug, Parser)]
    struct Cli {
        #[command(flatten)]
        args: CommandArgs,
    }

    fn parsed(line: &[&str]) -> Result<CommandArgs, clap::Error> {
        let line = ["command", "saw", "carriage"].iter().chain(line);
        Cli::try_parse_from(line).map(|cli| cli.args)
    }

    #[test]
    fn commands_are_spelled_out_or_given_as_json() {
        let expected = slave::Command::MoveAbsolute {
            position: -100.0,
            velocity: Some(200.0),
            dynamics: Dynamics {
                jerk: Some(5e3),
                ..Dynamics::default()
            },
        };
        let json = r#"{ "move-absolute": { "position": -100, "velocity": 200, "dynamics": { "jerk": 5e3 } } }"#;
        for line in [
            &[
                "move-absolute",
                "--position",
                "-100",
                "--velocity=200",
                "--jerk",
                "5e3",
                "--dry-run",
            ][..],
            &["--dry-run", "--order", json],
        ] {
            let args = parsed(line).unwrap();
            assert_eq!(args.command().unwrap(), expected);
            assert!(args.dry_run);
            assert_eq!(
                (args.node.as_str(), args.slave.as_str()),
                ("saw", "carriage")
            );
        }
    }

    #[test]
    fn exactly_one_command_is_expected() {
        for (line, expected) in [
            (&[][..], "expected a command"),
            (
                &["--order", "{\"halt\":{}}", "reset"][..],
                "expected one of them",
            ),
            (&["--order", "{\"dance\":{}}"][..], "dance"),
        ] {
            let error = parsed(line).unwrap().command().unwrap_err();
            assert!(format!("{error:#}").contains(expected), "{error:#}");
        }
    }

    #[test]
    fn answers_are_one_line() {
        let order = CommandOrder {
            slave: SlaveName::new("carriage").unwrap(),
            command: slave::Command::Reset {},
            dry_run: false,
        };
        let slave = SlaveView {
            status: AxisStatus::Standstill,
            coupling: None,
            position: 12.5,
            velocity: 0.0,
        };
        let refusal = Refusal::NoMaster;
        for (dry_run, outcome, expected) in [
            (
                false,
                CommandOutcome::Accepted {
                    job: Some(7),
                    awaits: Awaits::JUMP | Awaits::FINITE,
                    slave,
                    saw: None,
                },
                "accepted, job 7; checked when it is due: no-jump, finite; the slave is in standstill at 12.5, velocity 0",
            ),
            (
                true,
                CommandOutcome::Refused {
                    refusal,
                    slave,
                    moment: None,
                },
                "would be refused, 0x4b09: no master to couple to; the slave is in standstill",
            ),
            (
                false,
                CommandOutcome::NotTaken(NotTaken::NoSlaves),
                "not taken: the node has no slaves",
            ),
        ] {
            let order = CommandOrder { dry_run, ..order };
            let words = in_words(&CommandAnswer::new(&order, &outcome));
            assert!(words.starts_with(expected), "{words}");
        }
    }
}
