//! Statuses of running nodes: `coaxle status`, `coaxle get`, `coaxle nodes` and `coaxle wait-sync`.
//!
//! Their only source is the status that nodes publish (docs/WIRE.md).

mod base_units;
mod circles;
mod get;
mod metrics;
mod nodes;
mod plain;
mod reading;
#[cfg(test)]
mod samples;
mod wait;
mod words;

use std::time::Duration;

use clap::{Args, ValueEnum};
use coaxle_clock::Span;
use coaxle_host::cli::NetworkArgs;
use coaxle_host::client::{SeenNode, Watcher};
use coaxle_node::guess::did_you_mean;
use coaxle_node::keys::NodeName;
use coaxle_os::exit::{Exit, NodeNotFound};
use coaxle_os::machine;
use coaxle_report::inspect;
use serde_json::Value;

pub use get::{GetArgs, get};
pub use nodes::{NodesArgs, nodes};
pub(crate) use plain::COVERED;
pub(crate) use reading::StatusFields;
pub use wait::{WaitArgs, wait};
pub(crate) use words::{UNKNOWN, micros};

/// Startup time allowed for a node to appear.
// Sessions dial again every second at the latest (`connect/retry`), and a status follows within a quarter.
const STATUS_TIMEOUT: Span = Span::from_secs(5);
/// Nodes publish a status four times a second: within this time, every node there has.
// Two periods of 250 ms and some time on the way.
const ROUND: Span = Span::from_millis(600);
/// Interval of `--watch`.
// Four statuses come in it: faster changes cannot be read.
const AGAIN: Duration = Duration::from_secs(1);

/// The nodes, and the format of their status.
#[derive(Debug, Args)]
pub struct StatusArgs {
    /// The nodes [default: all that are there]
    #[arg(value_name = "NODE", value_parser = |name: &str| NodeName::new(name))]
    nodes: Vec<NodeName>,
    /// For people; as JSON, as the nodes publish it; or as metrics for Prometheus
    #[arg(short, long, value_enum, default_value_t = StatusFormat::Plain)]
    format: StatusFormat,
    /// Show it again every second, until Ctrl-C
    #[arg(short, long)]
    watch: bool,
    #[command(flatten)]
    network: NetworkArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum StatusFormat {
    Plain,
    Json,
    Prometheus,
}

/// Prints the status.
///
/// # Errors
/// A wrong network section, a network that cannot be joined, or a node that does not turn up: names those that are there.
pub fn status(args: &StatusArgs) -> anyhow::Result<Exit> {
    let watcher = args.network.watch(&args.nodes)?;
    let shown = show(args, &watcher);
    watcher.close();
    shown
}

fn show(args: &StatusArgs, watcher: &Watcher) -> anyhow::Result<Exit> {
    let mut seen = gather(watcher, &args.nodes)?;
    while print(args, &seen)? && args.watch {
        std::thread::park_timeout(AGAIN);
        seen = chosen(watcher.seen(), &args.nodes);
    }
    Ok(Exit::Done)
}

/// Prints the statuses; false if the output is closed.
fn print(args: &StatusArgs, seen: &[SeenNode]) -> anyhow::Result<bool> {
    let text = match args.format {
        StatusFormat::Plain => plain::all(seen, machine::now()),
        StatusFormat::Json => json(seen, args.watch),
        StatusFormat::Prometheus => metrics::of(seen),
    };
    let mut is_read = false;
    inspect::print(|out| {
        // Only for people: escape sequences would spoil the lines of programs.
        if args.watch && args.format == StatusFormat::Plain {
            // The screen, from its top.
            write!(out, "\x1b[H\x1b[2J")?;
        }
        writeln!(out, "{text}")?;
        out.flush()?;
        // Not reached if the pipe is closed: then watching ends.
        is_read = true;
        Ok(true)
    })?;
    Ok(is_read)
}

/// Statuses as published: a list, or a line for each node.
fn json(seen: &[SeenNode], lines: bool) -> String {
    let all = seen.iter().filter_map(|node| node.status.as_ref());
    let all = all.map(|(_, status)| Value::Object(status.clone()));
    // An object a line when repeated, so that a program can read them as they come.
    if lines {
        let lines: Vec<_> = all.map(|status| status.to_string()).collect();
        return lines.join("\n");
    }
    format!("{:#}", all.collect::<Value>())
}

/// Waits until all of these nodes, or all that are there, have published their status.
///
/// # Errors
/// [`NodeNotFound`]: a node does not turn up; names those that do.
pub(crate) fn gather(watcher: &Watcher, nodes: &[NodeName]) -> anyhow::Result<Vec<SeenNode>> {
    let has_status = |node: &SeenNode| node.status.is_some();
    if nodes.is_empty() {
        let some = watcher.wait_for(STATUS_TIMEOUT, |seen| seen.iter().any(has_status));
        if some.is_empty() {
            let place = watcher.whereabouts();
            let nobody = format!("no node is there after {STATUS_TIMEOUT}, {place}");
            return Err(NodeNotFound(nobody).into());
        }
        // Never enough: the number of nodes is not known, so the whole round is waited for.
        return Ok(watcher.wait_for(ROUND, |_| false));
    }
    let has_told = |seen: &[SeenNode], name: &NodeName| {
        seen.iter()
            .any(|node| node.name == *name && has_status(node))
    };
    let seen = watcher.wait_for(STATUS_TIMEOUT, |seen| {
        nodes.iter().all(|name| has_told(seen, name))
    });
    match nodes.iter().find(|name| !has_told(&seen, name)) {
        None => Ok(chosen(seen, nodes)),
        Some(missing) => Err(NodeNotFound(absent(watcher, missing)).into()),
    }
}

/// The nodes of these names, or all if no names are given.
fn chosen(mut seen: Vec<SeenNode>, nodes: &[NodeName]) -> Vec<SeenNode> {
    seen.retain(|node| nodes.is_empty() || nodes.contains(&node.name));
    seen
}

/// The reason why a node's status is missing, as far as known: other nodes are there, or why none is.
fn absent(watcher: &Watcher, name: &NodeName) -> String {
    let others: Vec<_> = watcher
        .seen()
        .into_iter()
        .filter(|node| node.is_alive)
        .collect();
    let why = match others.as_slice() {
        // Trying to reach the node takes seconds, and is worth them only if nothing at all is seen.
        [] => watcher
            .invisibility_reason(name)
            .map(|why| why.reason().to_owned()),
        others => {
            let names: Vec<_> = others.iter().map(|node| node.name.as_str()).collect();
            let meant = did_you_mean(name.as_str(), names.iter().copied());
            Some(format!("there are {}{meant}", names.join(", ")))
        }
    };
    let why = why.map_or_else(String::new, |why| format!("; {why}"));
    format!("node {name} says nothing, {}{why}", watcher.whereabouts())
}

/// The metrics of nodes, as Prometheus scrapes them.
pub(crate) fn metrics(seen: &[SeenNode]) -> String {
    metrics::of(seen)
}

/// The status of a node, if it has published one.
fn reading(node: &SeenNode) -> Option<StatusFields<'_>> {
    node.status
        .as_ref()
        .map(|(_, status)| StatusFields::of(status))
}
