//! `coaxle command`: sends a command to a slave of a running node, or about a node that it follows.

mod blocks;
mod cam;
#[cfg(test)]
mod every_command;
mod far;
mod options;
mod saw;
mod spelled;

use clap::Args;
use coaxle_axis::SyncPositions;
use coaxle_clock::far_clock::DelaySource;
use coaxle_host::cli::NetworkArgs;
use coaxle_host::client::Commander;
use coaxle_node::CommandOrder;
use coaxle_node::command::{
    Addressee, AnyCommand, CommandAnswer, CommandVerdict, FarName, FarView, SlaveName, SlaveView,
    WrongAddressee,
};
use coaxle_node::document::from_json;
use coaxle_node::keys::NodeName;
use coaxle_os::exit::wrong_argument;
use coaxle_report::inspect::{self, shown};

use spelled::SpelledCommand;

/// Addressee and command.
#[derive(Debug, Args)]
#[command(
    subcommand_value_name = "COMMAND",
    subcommand_help_heading = "Commands"
)]
pub struct CommandArgs {
    /// The node that receives the command
    #[arg(value_parser = |name: &str| NodeName::new(name))]
    node: NodeName,
    /// Slave of that node
    #[arg(required_unless_present = "far", conflicts_with = "far")]
    slave: Option<SlaveName>,
    /// Instead of a slave: a node that it follows, by its name
    #[arg(long, value_name = "FAR NODE")]
    far: Option<FarName>,
    #[command(subcommand)]
    spelled: Option<SpelledCommand>,
    /// The command as JSON, as the network has it: '{ "halt": {} }'
    #[arg(long, value_name = "JSON")]
    order: Option<String>,
    /// Only plan the command and print its result
    #[arg(long, global = true)]
    dry_run: bool,
    /// Print the node's response as JSON
    #[arg(long, global = true)]
    json: bool,
    #[command(flatten)]
    network: NetworkArgs,
}

/// Sends the command and prints the response; false if it is not accepted.
///
/// # Errors
/// No command, or more than one; the node does not turn up or does not respond.
pub fn print(args: &CommandArgs) -> anyhow::Result<bool> {
    let order = args.order()?;
    let commander = Commander::open(&args.network.transport()?)?;
    let answer = commander.send(&args.node, &order);
    commander.close();
    let answer = answer?;
    inspect::print(|out| {
        if args.json {
            writeln!(out, "{}", answer.to_json())?;
        } else {
            writeln!(
                out,
                "{}/{}: {}",
                args.node,
                order.addressee(),
                in_words(&answer)
            )?;
        }
        Ok(answer.is_accepted())
    })
}

impl CommandArgs {
    fn order(&self) -> anyhow::Result<CommandOrder> {
        let addressee = match (self.slave, self.far) {
            (Some(slave), _) => Addressee::Slave(slave),
            (None, Some(far)) => Addressee::Far(far),
            (None, None) => return wrong_argument("expected a slave, or --far"),
        };
        let order = CommandOrder::new(addressee, self.command()?, self.dry_run);
        order.or_else(|wrong| {
            wrong_argument(match wrong {
                WrongAddressee::Slave { command } => {
                    format!("received {command} for a slave, expected --far with it")
                }
                WrongAddressee::Far { command } => {
                    format!("received {command} with --far, expected a slave for it")
                }
            })
        })
    }

    /// Returns the command, spelled out or as JSON.
    fn command(&self) -> anyhow::Result<AnyCommand> {
        match (&self.spelled, &self.order) {
            (Some(SpelledCommand(command)), None) => Ok(command.clone()),
            (None, Some(json)) => from_json(json.as_bytes())
                .or_else(|reason| wrong_argument(format!("--order: {reason}"))),
            (None, None) => {
                wrong_argument("expected a command, or --order; see coaxle command --help")
            }
            (Some(_), Some(_)) => {
                wrong_argument("received a command and --order, expected one of them")
            }
        }
    }
}

/// Result of an order.
pub(crate) fn in_words(answer: &CommandAnswer) -> String {
    let (verdict, state, saw) = match &answer.verdict {
        CommandVerdict::Accepted {
            dry_run,
            job,
            awaits,
            axis,
            far,
            sync_positions,
            saw,
            cam,
        } => {
            let mut verdict = match (dry_run, job) {
                (true, _) => "would be accepted".to_owned(),
                (false, Some(job)) => format!("accepted, job {job}"),
                (false, None) => "accepted".to_owned(),
            };
            if !awaits.is_empty() {
                verdict += &format!("; checked when it is due: {}", awaits.join(", "));
            }
            let state = state_of(axis.as_ref(), far.as_ref());
            let synchronous = sync_positions.as_ref().map(synchronous);
            (
                verdict,
                state,
                (saw.as_ref().map(saw::accepted))
                    .or(synchronous)
                    .or_else(|| cam.as_ref().map(cam::read)),
            )
        }
        CommandVerdict::Refused {
            dry_run,
            text,
            axis,
            far,
            saw,
            ..
        } => {
            let would = if *dry_run { "would be " } else { "" };
            let refused = format!("{would}refused, {text}");
            let state = state_of(axis.as_ref(), far.as_ref());
            (refused, state, saw.as_ref().map(saw::refused))
        }
        CommandVerdict::NotTaken { text, .. } => return format!("not taken: {text}"),
    };
    let saw = saw.unwrap_or_default();
    format!("{verdict}{state}{saw}")
}

/// Positions where a flying gear is fully engaged.
fn synchronous(at: &SyncPositions) -> String {
    format!(
        "; synchronous with the master at {}, the slave at {}",
        shown(at.master),
        shown(at.slave)
    )
}

/// State of the slave or far node that the order was about.
fn state_of(axis: Option<&SlaveView>, far: Option<&FarView>) -> String {
    let slave = axis.map(|axis| {
        format!(
            "; the slave is in {} at {}, velocity {}",
            axis.status, axis.position, axis.velocity
        )
    });
    let far = far.map(|far| {
        let on = if far.enabled { "enabled" } else { "disabled" };
        let known = if far.synced { "" } else { "not " };
        let delay = match far.delay {
            DelaySource::Measured => "measured".to_owned(),
            DelaySource::Fixed(delay) => format!("{} µs", delay.as_micros_f64()),
            DelaySource::Off => "off".to_owned(),
        };
        let mode = far.mode;
        format!("; the far node is {on}, mode {mode}, {known}synchronised, delay {delay}")
    });
    slave.or(far).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use coaxle_axis::{Awaits, AxisStatus};
    use coaxle_node::command::{
        CommandOutcome, FarCommand, FarOrder, FarRefusal, NotTaken, SlaveOrder,
    };
    use coaxle_slave as slave;
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
            let CommandOrder::Slave(order) = args.order().unwrap() else {
                panic!("another order");
            };
            assert_eq!(order.command, expected);
            assert!(args.dry_run && order.dry_run);
            assert_eq!(
                (args.node.as_str(), args.slave.map(String::from)),
                ("saw", Some("carriage".to_owned()))
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
            let error = parsed(line).unwrap().order().unwrap_err();
            assert!(format!("{error:#}").contains(expected), "{error:#}");
        }
    }

    #[test]
    fn answers_are_one_line() {
        let order = SlaveOrder {
            addressee: SlaveName::new("carriage").unwrap(),
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
                    sync_positions: None,
                    saw: None,
                },
                "accepted, job 7; checked when it is due: no-jump, finite; the slave is in standstill at 12.5, velocity 0",
            ),
            (
                true,
                CommandOutcome::Refused {
                    refusal,
                    slave,
                    saw: None,
                },
                "would be refused, 0x4b09: no master to couple to; the slave is in standstill",
            ),
            (
                false,
                CommandOutcome::NotTaken(NotTaken::NoSlaves),
                "not taken: the node has no slaves",
            ),
        ] {
            let order = SlaveOrder { dry_run, ..order }.into();
            let words = in_words(&CommandAnswer::new(&order, &outcome));
            assert!(words.starts_with(expected), "{words}");
        }
    }

    fn far(line: &[&str]) -> Result<CommandOrder, String> {
        let line = ["command", "saw", "--far", "belt"].iter().chain(line);
        let cli = Cli::try_parse_from(line).map_err(|error| error.to_string())?;
        cli.args.order().map_err(|error| format!("{error:#}"))
    }

    #[test]
    fn a_far_node_is_commanded_with_far_and_a_slave_without() {
        let expected = FarOrder {
            addressee: FarName::new("belt").unwrap(),
            command: FarCommand::FilterMode(coaxle_receiver::FilterMode::Pt1),
            dry_run: true,
        };
        for line in [
            &["filter-mode", "pt1", "--dry-run"][..],
            &["--dry-run", "--order", "{ \"filter-mode\": \"pt1\" }"],
        ] {
            assert_eq!(far(line), Ok(expected.into()));
        }
        let error = far(&["halt"]).unwrap_err();
        assert!(error.contains("expected a slave for it"), "{error}");
        let error = parsed(&["disable"]).unwrap().order().unwrap_err();
        assert!(error.to_string().contains("expected --far"), "{error}");
        assert!(far(&["carriage", "halt"]).is_err(), "not both");
        assert!(Cli::try_parse_from(["command", "saw", "halt"]).is_err());
    }

    #[test]
    fn answers_about_far_nodes_too() {
        let order = far(&["disable"]).unwrap();
        let view = FarView {
            enabled: true,
            mode: coaxle_receiver::FilterMode::Auto,
            synced: false,
            delay: DelaySource::Fixed(coaxle_clock::Span::from_micros_f64(120.5)),
        };
        let state = "the far node is enabled, mode sync, not synchronised, delay 120.5 µs";
        for (outcome, expected) in [
            (
                CommandOutcome::FarAccepted { far: view },
                format!("accepted; {state}"),
            ),
            (
                CommandOutcome::FarRefused {
                    refusal: FarRefusal::Delay { received: 2e6 },
                    far: view,
                },
                format!(
                    "refused, 0x4b56: fixed-us: received 2000000, expected a number from -1000000 to \
                     1000000; {state}"
                ),
            ),
        ] {
            assert_eq!(in_words(&CommandAnswer::new(&order, &outcome)), expected);
        }
    }
}
