//! `coaxle when`: the time until a promised axis comes to a position, for scripts.

use std::time::Duration;

use clap::{Args, ValueEnum};
use coaxle_axis::motion_plan::AwaitedPosition;
use coaxle_axis::{Modulo, TravelDirection};
use coaxle_clock::Span;
use coaxle_host::cli::NetworkArgs;
use coaxle_host::client::{PromiseReader, PromisedArrival, Watcher};
use coaxle_node::Channel;
use coaxle_node::guess::did_you_mean;
use coaxle_node::keys::NodeName;
use coaxle_os::exit::{Exit, wrong_argument};
use coaxle_report::inspect;
use coaxle_topology::{PlantNode, about_from_json};

use crate::status;

/// Time in which frames and plans come.
// Plans come every 100 ms, ten of which may be lost.
const PATIENCE: Span = Span::from_secs(1);
/// Time in which a node describes its axes.
const ANSWER: Duration = Duration::from_secs(1);

/// The axis and the position.
#[derive(Debug, Args)]
pub(crate) struct WhenArgs {
    /// The node that generates the axis: a sender
    #[arg(value_name = "NODE", value_parser = |name: &str| NodeName::new(name))]
    node: NodeName,
    /// The axis, by its id or its name
    axis: String,
    /// The position, in units of the axis
    #[arg(allow_negative_numbers = true, value_parser = finite)]
    position: f64,
    /// The axis repeats the position in each of its modulo turns
    #[arg(long)]
    in_turn: bool,
    /// Direction in which it comes there [default: any]
    #[arg(long, value_enum)]
    direction: Option<WantedDirection>,
    #[command(flatten)]
    network: NetworkArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum WantedDirection {
    /// To larger positions
    Forward,
    /// To smaller ones
    Backward,
}

fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "expected a finite number".to_owned())
}

/// Prints the time from the newest frame to the arrival, s. Without one in the promise it prints nothing, and its exit code is that of
/// missing data.
///
/// # Errors
/// A wrong network section, a network that cannot be joined, a node that does not turn up, or an axis that it does not have.
pub(crate) fn when(args: &WhenArgs) -> anyhow::Result<Exit> {
    let watcher = args.network.watch(std::slice::from_ref(&args.node))?;
    let arrival = arrival(args, &watcher);
    watcher.close();
    let (node, axis) = (&args.node, &args.axis);
    match arrival? {
        PromisedArrival::Comes { after, .. } => {
            inspect::print_text(&after.as_secs_f64().to_string())?;
            return Ok(Exit::Done);
        }
        PromisedArrival::Beyond { promised } => {
            tracing::warn!(
                "it is not there within the promise, which ends {promised} after its newest frame"
            );
        }
        PromisedArrival::NoPromise => tracing::warn!(
            "axis {axis} of node {node} promises nothing: it needs a program and a lead-ms (docs/PRESENTATION.md)"
        ),
        PromisedArrival::NoFrame => {
            tracing::warn!("node {node} sends no frame with axis {axis} within {PATIENCE}");
        }
    }
    Ok(Exit::NoData)
}

fn arrival(args: &WhenArgs, watcher: &Watcher) -> anyhow::Result<PromisedArrival> {
    status::gather(watcher, std::slice::from_ref(&args.node))?;
    let about = about(watcher, &args.node);
    let (id, modulo) = axis(args, about.as_ref()).or_else(wrong_argument)?;
    let position = AwaitedPosition {
        position: args.position,
        modulo,
        direction: args.direction.map(TravelDirection::from),
    };
    let reader = PromiseReader::over(&**watcher.transport(), &args.node, id)?;
    Ok(reader.arrival(&position, PATIENCE))
}

/// Description of a node by itself; none of one that gives none.
fn about(watcher: &Watcher, node: &NodeName) -> Option<PlantNode> {
    let client = watcher.transport().client(&node.about_key(), ANSWER).ok()?;
    let reply = client.request(String::new()).ok()??;
    about_from_json(&reply).ok().map(|(about, _)| about)
}

/// Id of the axis, and the modulo period in which the position repeats.
///
/// # Errors
/// The axes that are there instead, in words.
fn axis(args: &WhenArgs, about: Option<&PlantNode>) -> Result<(u32, Option<Modulo>), String> {
    let axes = about.map_or(&[][..], |about| &about.axes);
    let id_of = |published: Option<(Channel, u32)>| match published {
        Some((Channel::Axes, id)) => Some(id),
        _ => None,
    };
    let given = args.axis.parse::<u32>().ok();
    let is_it = |name: &str, id: u32| name == args.axis || given == Some(id);
    let found = axes.iter().find_map(|axis| {
        let id = id_of(axis.published)?;
        is_it(&axis.name, id).then_some((id, axis.modulo))
    });
    let (id, modulo) = match (found, given) {
        (Some(found), _) => found,
        // A node that does not describe its axes may have it.
        (None, Some(id)) if about.is_none() => (id, None),
        (None, _) => {
            let axes = axes.iter().filter(|axis| id_of(axis.published).is_some());
            let names: Vec<_> = axes.map(|axis| axis.name.as_str()).collect();
            let meant = did_you_mean(&args.axis, names.iter().copied());
            let (received, names) = (&args.axis, names.join(", "));
            return Err(format!(
                "AXIS: received {received:?}, expected an axis of the node: {names}{meant}"
            ));
        }
    };
    match (args.in_turn, modulo) {
        (false, _) => Ok((id, None)),
        (true, None) => Err(format!(
            "--in-turn: received one for axis {id}, which states no modulo, expected one that does"
        )),
        (true, Some(turn)) if !turn.has(args.position) => {
            let (position, length) = (args.position, turn.length());
            Err(format!(
                "POSITION: received {position}, expected 0 up to less than the modulo turn of {length}"
            ))
        }
        (true, turn) => Ok((id, turn)),
    }
}

impl From<WantedDirection> for TravelDirection {
    fn from(direction: WantedDirection) -> Self {
        match direction {
            WantedDirection::Forward => Self::Forward,
            WantedDirection::Backward => Self::Backward,
        }
    }
}
