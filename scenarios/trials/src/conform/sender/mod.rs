//! `coaxle conform sender`: the rules of docs/WIRE.md that a node keeps which publishes axes.

mod judge;
mod listen;
#[cfg(test)]
mod tests;

use clap::{Args, ValueEnum};
use coaxle_clock::Span;
use coaxle_host::cli::{NetworkArgs, parse_duration};
use coaxle_host::network::transport::{OverZenoh, Transport};
use coaxle_node::Channel;
use coaxle_node::frame::sender_id;
use coaxle_node::keys::NodeName;
use coaxle_os::{Interrupt, machine};

use super::rule::TrialResult;
use judge::{Requester, SenderJudge};
use listen::NodeListener;

/// Arguments of `coaxle conform sender`.
#[derive(Debug, Args)]
pub(crate) struct SenderArgs {
    /// The node that publishes axes
    #[arg(value_name = "NODE", value_parser = |name: &str| NodeName::new(name))]
    pub(super) node: NodeName,
    /// Channel of its axes: those of a sender, or the slaves of a receiver
    #[arg(long, value_enum, default_value_t)]
    channel: Published,
    /// Listen for this time, such as 10s, 500ms, 2min
    #[arg(long = "for", value_name = "DURATION", default_value = "10s", value_parser = parse_duration)]
    listen_for: Span,
    #[command(flatten)]
    network: NetworkArgs,
}

/// A channel that a node publishes once per cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Published {
    #[default]
    Axes,
    Slaves,
}

/// Name of the requester of time here.
const NAME: &str = "conform";

/// Listens, and returns the findings.
///
/// # Errors
/// A wrong network section, or a network that cannot be joined.
pub(super) fn judge(args: &SenderArgs) -> anyhow::Result<TrialResult> {
    let interrupt = Interrupt::listen()?;
    let transport = OverZenoh::open_and_wait(&args.network.transport()?)?;
    let heard = listen(args, &transport, &interrupt);
    transport.close();
    heard
}

fn listen(
    args: &SenderArgs,
    transport: &OverZenoh,
    interrupt: &Interrupt,
) -> anyhow::Result<TrialResult> {
    let channel = match args.channel {
        Published::Axes => Channel::Axes,
        Published::Slaves => Channel::Slaves,
    };
    let now = machine::now();
    let requester = Requester {
        id: sender_id(&NodeName::new(NAME)?),
        // A new run each time: responses to an earlier tool do not match.
        run: now.as_nanos().unsigned_abs(),
    };
    let mut listener = NodeListener::new(transport, &args.node, channel, requester)?;
    let mut judge = SenderJudge::new(&args.node, channel, requester, now);
    if !listener.listen(&mut judge, args.listen_for, interrupt)? {
        return Ok(TrialResult::Interrupted);
    }
    if judge.frames() > 0 {
        return Ok(TrialResult::Findings(judge.findings(machine::now())));
    }
    let key = args.node.channel_key(channel);
    let why = transport.invisibility_reason(args.node.as_str());
    let why = why.map_or_else(String::new, |why| format!("; {}", why.reason()));
    let whereabouts = transport.whereabouts();
    Ok(TrialResult::Nothing(format!(
        "nothing came on {key}, {whereabouts}{why}"
    )))
}
