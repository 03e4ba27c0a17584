//! `coaxle init`: the configs of two nodes to start with, from six answers or options, checked together.

mod answers;
mod files;
#[cfg(test)]
mod tests;

use std::fmt::Write as _;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use coaxle_node::keys::NodeName;
use coaxle_os::exit::{Exit, wrong_argument};
use coaxle_report::inspect;
use coaxle_topology::PlantAnalysis;

use crate::secure;
use crate::topology::configs;
use answers::{Interview, PlacedNode};
use files::{receiver_config, sender_config};

/// Folder of the certificates, in that of the configs.
const NETWORK: &str = "net";
/// The operator of a new network.
const OPERATOR: &str = "operator";

/// The folder, and the answers.
#[derive(Debug, Args)]
pub(crate) struct InitArgs {
    /// The folder that the files go to: a new or an empty one
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// The node that leads: its name and the address of its PC, as in conveyor@192.168.1.10
    #[arg(long, value_name = "NAME[@HOST]", value_parser = PlacedNode::read)]
    lead: Option<PlacedNode>,
    /// The node that follows, likewise
    #[arg(long, value_name = "NAME[@HOST]", value_parser = PlacedNode::read)]
    follow: Option<PlacedNode>,
    /// Task of the follower: what it does with the axis
    #[arg(long, value_enum)]
    task: Option<FollowerTask>,
    /// Certificates for both, so that nobody else is let in [default: yes if they are on two PCs]
    #[arg(long, value_name = "yes|no", value_parser = answers::yes_or_no)]
    secure: Option<bool>,
    /// Cycle time of both, µs
    #[arg(long, value_name = "MICROSECONDS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(100..=100_000))]
    cycle_time_us: u32,
}

/// Task of a follower.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FollowerTask {
    /// A roll moves with it, by a gear
    Gear,
    /// A flying saw cuts what it moves
    Saw,
    /// Nothing: its position is watched
    Watch,
}

/// All that the files depend on.
#[derive(Clone, Debug)]
struct StartPlan {
    lead: PlacedNode,
    follow: PlacedNode,
    task: FollowerTask,
    is_secure: bool,
    cycle_time_us: u32,
}

/// Writes the files, checks them together, and prints what to do next. On a terminal it asks for what no option says.
///
/// # Errors
/// Names that are alike, a folder that has files in it, or that cannot be written.
pub(crate) fn init(args: &InitArgs) -> anyhow::Result<Exit> {
    let asked = Interview::new(std::io::stdin().is_terminal());
    let plan = plan(args, &asked)?;
    let folder = &args.folder;
    make_empty(folder)?;
    write(folder, &plan)?;
    check(folder, &plan)?;
    inspect::print_text(&next(folder, &plan))?;
    Ok(Exit::Done)
}

fn plan(args: &InitArgs, asked: &Interview) -> anyhow::Result<StartPlan> {
    let lead = asked.node(args.lead.as_ref(), "leads", "conveyor")?;
    let follow = asked.node(args.follow.as_ref(), "follows", "saw")?;
    if lead.name == follow.name {
        let name = lead.name.as_str();
        return wrong_argument(format!(
            "--follow: received {name:?}, which leads, expected a name of its own"
        ));
    }
    let task = asked.task(args.task)?;
    let are_apart = !(lead.is_local() && follow.is_local());
    let is_secure = asked.secure(args.secure, are_apart)?;
    Ok(StartPlan {
        lead,
        follow,
        task,
        is_secure,
        cycle_time_us: args.cycle_time_us,
    })
}

fn make_empty(folder: &Path) -> anyhow::Result<()> {
    let place = folder.display();
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {place}"))?;
    let mut files = std::fs::read_dir(folder).with_context(|| format!("cannot read {place}"))?;
    if files.next().is_some() {
        return wrong_argument(format!(
            "{place} has files in it, expected a new or an empty folder"
        ));
    }
    Ok(())
}

fn write(folder: &Path, plan: &StartPlan) -> anyhow::Result<()> {
    let files = configs_of(folder, plan);
    let texts = [sender_config(plan), receiver_config(plan)];
    for (file, text) in files.iter().zip(texts) {
        std::fs::write(file, text).with_context(|| format!("cannot write {}", file.display()))?;
    }
    if plan.is_secure {
        let operator = OPERATOR.parse().map_err(anyhow::Error::msg)?;
        let nodes = [&plan.lead, &plan.follow];
        let addresses = nodes.map(|node| (node.name.clone(), node.host.clone()));
        let network = folder.join(NETWORK);
        secure::cli::init(files.to_vec(), network, operator, addresses.to_vec())?;
    }
    Ok(())
}

fn check(folder: &Path, plan: &StartPlan) -> anyhow::Result<()> {
    let nodes = configs::nodes(&configs_of(folder, plan), None)?;
    let findings = PlantAnalysis::of(&nodes).findings;
    let first = findings.first();
    first.map_or(Ok(()), |finding| Err(anyhow::anyhow!("{finding}")))
}

fn configs_of(folder: &Path, plan: &StartPlan) -> [PathBuf; 2] {
    [&plan.lead, &plan.follow].map(|node| folder.join(file_of(&node.name)))
}

fn file_of(name: &NodeName) -> String {
    format!("{name}.toml")
}

/// Steps that follow, on each PC.
fn next(folder: &Path, plan: &StartPlan) -> String {
    let StartPlan {
        lead,
        follow,
        is_secure,
        ..
    } = plan;
    let mut text = format!("{}: written and checked together\n\n", folder.display());
    for (node, role) in [(lead, "sender"), (follow, "receiver")] {
        let file = file_of(&node.name);
        let beside = match is_secure {
            true => format!(" and {NETWORK}/{}, at the same places", node.name),
            false => String::new(),
        };
        let _ = writeln!(
            text,
            "On {}, with {file}{beside}:\n    coaxle {role} {file}\n",
            node.host
        );
    }
    let (network, from) = match is_secure {
        true => (
            format!(" --secure {NETWORK}/{OPERATOR}"),
            format!("anywhere, with {NETWORK}/{OPERATOR}"),
        ),
        false => (String::new(), format!("on {}", follow.host)),
    };
    let name = &follow.name;
    let _ = writeln!(
        text,
        "Then {from}:\n    coaxle wait-sync {name} --timeout 60s{network}\n    coaxle status {name}{network}\n    \
         coaxle why {name}{network}\n"
    );
    if *is_secure {
        let _ = writeln!(
            text,
            "{NETWORK}/authority makes certificates: keep it away from both. They end in a year: `coaxle secure renew` (docs/SECURE.md).\n"
        );
    }
    text + "As services: docs/SERVICE.md. Every field: docs/REFERENCE.md, or `coaxle example`."
}
