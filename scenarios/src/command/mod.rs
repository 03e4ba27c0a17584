//! `coaxle command`: tells a slave of a running node what to do, or the node about one that it follows.

mod blocks;
mod cam;
mod cam_blocks;
mod far;
mod options;
mod saw;
mod spelled;

use anyhow::{Context, bail};
use clap::Args;
use coaxle_axis::SyncPositions;
use coaxle_host::Commander;
use coaxle_node::CommandOrder;
use coaxle_node::command::{
    CamCommand, CamOrder, CommandAnswer, CommandVerdict, FarCommand, FarDelay, FarName, FarOrder,
    FarView, SlaveName, SlaveOrder, SlaveView,
};
use coaxle_node::keys::NodeName;
use coaxle_receiver::Mode;
use serde::de::DeserializeOwned;

use crate::inspect::{self, shown};
use crate::network::NetworkArgs;
use spelled::Spelled;

/// Who is told what.
#[derive(Debug, Args)]
#[command(
    subcommand_value_name = "COMMAND",
    subcommand_help_heading = "Commands"
)]
pub struct CommandArgs {
    /// The node that is told
    #[arg(value_parser = |name: &str| NodeName::new(name))]
    node: NodeName,
    /// Its slave
    #[arg(required_unless_present = "far", conflicts_with = "far")]
    slave: Option<SlaveName>,
    /// Instead of a slave: a node that it follows, by its name
    #[arg(long, value_name = "FAR NODE")]
    far: Option<FarName>,
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
    #[command(flatten)]
    network: NetworkArgs,
}

/// Sends the command and prints the answer; false if it is not accepted.
///
/// # Errors
/// No command, or more than one; the node does not turn up or does not answer.
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
        let dry_run = self.dry_run;
        Ok(match (self.slave, self.far) {
            (Some(slave), _) => self.order_to(slave)?,
            (None, Some(far)) => CommandOrder::Far(FarOrder {
                far,
                command: self.far_command()?,
                dry_run,
            }),
            (None, None) => bail!("expected a slave, or --far"),
        })
    }

    fn order_to(&self, slave: SlaveName) -> anyhow::Result<CommandOrder> {
        let dry_run = self.dry_run;
        let of_slave = |command| SlaveOrder {
            slave,
            command,
            dry_run,
        };
        let of_cam = |command| CamOrder {
            slave,
            command,
            dry_run,
        };
        Ok(match self.spelled()? {
            Some(Spelled::Slave(command)) => of_slave(*command).into(),
            Some(Spelled::Cam(command)) => of_cam(command.clone()).into(),
            Some(Spelled::Far(command)) => bail!(
                "received {} for a slave, expected --far with it",
                command.name()
            ),
            None if self.is_cam_order() => of_cam(self.read_order()?).into(),
            None => of_slave(self.read_order()?).into(),
        })
    }

    /// Whether the JSON is about a cam plate.
    fn is_cam_order(&self) -> bool {
        let json = self.order.as_deref().unwrap_or_default();
        let command: serde_json::Map<String, serde_json::Value> =
            serde_json::from_str(json).unwrap_or_default();
        let names = |name: &String| CamCommand::NAMES.contains(&name.as_str());
        command.keys().any(names)
    }

    fn far_command(&self) -> anyhow::Result<FarCommand> {
        match self.spelled()? {
            Some(Spelled::Far(command)) => Ok(*command),
            Some(Spelled::Slave(command)) => bail!(
                "received {} with --far, expected a slave for it",
                command.name()
            ),
            Some(Spelled::Cam(command)) => bail!(
                "received {} with --far, expected a slave for it",
                command.name()
            ),
            None => self.read_order(),
        }
    }

    /// None where it is given as JSON.
    fn spelled(&self) -> anyhow::Result<Option<&Spelled>> {
        match (&self.spelled, &self.order) {
            (None, None) => bail!("expected a command, or --order; see coaxle command --help"),
            (Some(_), Some(_)) => bail!("received a command and --order, expected one of them"),
            (spelled, _) => Ok(spelled.as_ref()),
        }
    }

    fn read_order<T: DeserializeOwned>(&self) -> anyhow::Result<T> {
        let json = self.order.as_deref().unwrap_or_default();
        let mut json = serde_json::Deserializer::from_str(json);
        serde_path_to_error::deserialize(&mut json).context("--order")
    }
}

fn in_words(answer: &CommandAnswer) -> String {
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

/// Where a flying gear is fully engaged.
fn synchronous(at: &SyncPositions) -> String {
    format!(
        "; synchronous with the master at {}, the slave at {}",
        shown(at.master),
        shown(at.slave)
    )
}

/// What the order was about, as it is now.
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
            FarDelay::Measured => "measured".to_owned(),
            FarDelay::FixedUs(micros) => format!("{micros} µs"),
            FarDelay::Off => "off".to_owned(),
        };
        let mode = Mode::from(far.mode);
        format!("; the far node is {on}, mode {mode}, {known}synchronised, delay {delay}")
    });
    slave.or(far).unwrap_or_default()
}

#[cfg(test)]
mod tests;
