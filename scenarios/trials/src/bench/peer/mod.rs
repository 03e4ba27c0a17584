//! A process of a measurement: this very program, called with [`PEER`](super::plan::PEER).

mod nodes;
mod raw;

use std::io::Write;

use anyhow::Context;
use clap::Args;
use coaxle_clock::Span;
use coaxle_host::cli::parse_duration;
use coaxle_os::exit::Exit;
use coaxle_os::{Os, System};

use super::plan::{PeerPlan, PeerReport};

/// Arguments of such a process.
#[derive(Debug, Args)]
pub struct PeerArgs {
    /// Plan of the process, as JSON
    plan: String,
    /// Die with this process, which started this one
    #[arg(long, value_name = "PID")]
    parent: i32,
    /// End after this time at the latest
    #[arg(long = "for", value_name = "DURATION", value_parser = parse_duration)]
    limit: Span,
}

/// Does its part until it is ended, and writes its report to standard output.
///
/// # Errors
/// A wrong plan, or a part that fails.
pub fn run(args: &PeerArgs) -> anyhow::Result<Exit> {
    // First, so that from here on a killed parent leaves no process behind.
    Os::die_with_parent(args.parent).context("cannot be tied to the process that started it")?;
    let plan: PeerPlan = serde_json::from_str(&args.plan).context("the plan of a process")?;
    let told = perform(plan, args.limit)?;
    // Reports of a minute have tens of thousands of numbers: without a buffer each would be a system call.
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    serde_json::to_writer(&mut out, &told).context("cannot tell what was seen")?;
    out.flush().context("cannot tell what was seen")?;
    Ok(Exit::Done)
}

fn perform(plan: PeerPlan, limit: Span) -> anyhow::Result<PeerReport> {
    match plan {
        PeerPlan::UdpSender { to, pace } => raw::send_datagrams(to, &pace, limit),
        PeerPlan::UdpReceiver { at, looks } => raw::receive_datagrams(at, looks.as_ref(), limit),
        PeerPlan::ZenohSender { transport, pace } => raw::publish(&transport, &pace, limit),
        PeerPlan::ZenohReceiver {
            transport,
            real_time,
            looks,
        } => raw::subscribe(&transport, &real_time, looks.as_ref(), limit),
        PeerPlan::Sender { config, stamps } => nodes::send(&config, stamps, limit),
        PeerPlan::SenderAlone { config } => nodes::send_without_network(&config, limit),
        PeerPlan::Receiver { config } => nodes::receive(&config, limit),
    }
}

/// Reports that it is ready.
fn report_ready() -> anyhow::Result<()> {
    let mut out = std::io::stdout();
    writeln!(out, "{}", super::plan::READY)
        .and_then(|()| out.flush())
        .context("nobody waits for this process")
}
