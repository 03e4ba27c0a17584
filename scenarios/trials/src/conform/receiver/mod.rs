//! `coaxle conform receiver`: the rules of docs/WIRE.md that a node keeps which follows axes.

mod frames;
mod perform;
mod player;
mod reading;
mod requests;
mod role;
mod script;
#[cfg(test)]
mod tests;

use anyhow::bail;
use clap::Args;
use coaxle_clock::{CycleTime, Span};
use coaxle_host::cli::{NetworkArgs, parse_duration};
use coaxle_host::client::{SeenNode, Watcher};
use coaxle_node::keys::NodeName;
use coaxle_os::Interrupt;

use super::rule::TrialResult;
use role::{PlayOptions, chosen_role};

/// Arguments of `coaxle conform receiver`.
#[derive(Debug, Args)]
pub(crate) struct ReceiverArgs {
    /// The node that follows axes. Its slaves may move: the played axis has an error for a while, falls silent and
    /// comes back elsewhere
    #[arg(value_name = "NODE", value_parser = |name: &str| NodeName::new(name))]
    pub(super) node: NodeName,
    /// The far node to play, which must not run itself [default: the one that the receiver follows]
    #[arg(long = "as", value_name = "NODE", value_parser = |name: &str| NodeName::new(name))]
    played: Option<NodeName>,
    /// The axis of that node [default: the first one that the receiver follows]
    #[arg(long, value_name = "ID")]
    axis: Option<u32>,
    /// Period of frames, 100us to 100ms [default: the receiver's own cycle time, and its multiple from 5 ms on]
    #[arg(long, value_name = "DURATION", value_parser = cycle_time)]
    cycle_time: Option<CycleTime>,
    #[command(flatten)]
    network: NetworkArgs,
}

/// Startup time allowed for a receiver to appear.
const STATUS_TIMEOUT: Span = Span::from_secs(5);

/// Plays the script, and returns the findings.
///
/// # Errors
/// A wrong network section, a network that cannot be joined, a receiver that follows no node that can be played.
pub(super) fn judge(args: &ReceiverArgs) -> anyhow::Result<TrialResult> {
    let interrupt = Interrupt::listen()?;
    let watcher = args.network.watch(std::slice::from_ref(&args.node))?;
    let heard = play(args, &watcher, &interrupt);
    watcher.close();
    heard
}

fn play(
    args: &ReceiverArgs,
    watcher: &Watcher,
    interrupt: &Interrupt,
) -> anyhow::Result<TrialResult> {
    let seen = watcher.wait_for(STATUS_TIMEOUT, |seen| {
        seen.iter().any(names_what_it_follows)
    });
    let status = seen.iter().find_map(|node| node.status.as_ref());
    let Some((at, status)) = status else {
        let why = watcher.invisibility_reason(&args.node);
        let why = why.map_or_else(String::new, |why| format!("; {}", why.reason()));
        return Ok(TrialResult::Nothing(format!(
            "node {} says nothing, {}{why}",
            args.node,
            watcher.whereabouts()
        )));
    };
    let options = PlayOptions {
        played: args.played.clone(),
        axis: args.axis,
        cycle_time: args.cycle_time,
    };
    let role = match chosen_role(&args.node, status, &options, at.as_nanos().unsigned_abs()) {
        Ok(role) => role,
        Err(why) => bail!("{}: {why}", args.node),
    };
    tracing::info!(
        "plays {}, axis {}, to {}",
        role.played,
        role.axis,
        args.node
    );
    let found = perform::perform(&**watcher.transport(), role, interrupt)?;
    Ok(found.map_or(TrialResult::Interrupted, TrialResult::Findings))
}

/// True once a status names the followed nodes and axes: the first one of a node that has just started does not.
fn names_what_it_follows(node: &SeenNode) -> bool {
    let status = node.status.as_ref().map(|(_, status)| status);
    status.is_some_and(|status| {
        ["sources", "axes"]
            .iter()
            .all(|of| status.contains_key(*of))
    })
}

fn cycle_time(text: &str) -> Result<CycleTime, String> {
    let span = parse_duration(text).map_err(|error| error.to_string())?;
    CycleTime::new(span).map_err(|error| error.to_string())
}
