//! `coaxle conform`: checks another implementation's node against docs/WIRE.md.
//!
//! Judging needs no network: messages and their arrivals go in, findings come out.

mod queue;
mod receiver;
mod report;
mod rule;
mod sender;

use std::path::PathBuf;

use clap::{Args, Subcommand};
use coaxle_lab::junit;
use coaxle_node::keys::NodeName;
use coaxle_os::exit::Exit;
use coaxle_os::machine;
use coaxle_report::inspect;

use receiver::ReceiverArgs;
use report::ReportFormat;
use rule::TrialResult;
use sender::SenderArgs;

/// Arguments of `coaxle conform`.
#[derive(Debug, Args)]
pub struct ConformArgs {
    #[command(subcommand)]
    tried: ConformTarget,
    /// A line for each rule, or JSON
    #[arg(short, long, value_enum, default_value_t, global = true)]
    format: ReportFormat,
    /// Write a report in JUnit's format: a case for each rule
    #[arg(long, value_name = "FILE", global = true)]
    junit: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum ConformTarget {
    /// Listen to a node that publishes axes, send it time requests, and show which rules it keeps
    Sender(SenderArgs),
    /// Play good and bad frames to a node that follows axes, as the far node that its config names, and judge its
    /// reaction
    Receiver(ReceiverArgs),
}

impl ConformTarget {
    const fn node(&self) -> &NodeName {
        match self {
            Self::Sender(args) => &args.node,
            Self::Receiver(args) => &args.node,
        }
    }
}

/// Tries a node and prints the findings: not met if a rule is broken, no data if nothing came.
///
/// # Errors
/// A wrong network section, a network that cannot be joined, a node that cannot be tried, or a report that cannot be
/// written.
pub fn conform(args: &ConformArgs) -> anyhow::Result<Exit> {
    let began = machine::now();
    let (kind, heard) = match &args.tried {
        ConformTarget::Sender(args) => ("sender", sender::judge(args)?),
        ConformTarget::Receiver(args) => ("receiver", receiver::judge(args)?),
    };
    let findings = match heard {
        TrialResult::Findings(findings) => findings,
        TrialResult::Interrupted => return Ok(Exit::Interrupted),
        TrialResult::Nothing(why) => {
            tracing::error!("{why}");
            return Ok(Exit::NoData);
        }
    };
    let node = args.tried.node();
    if let Some(path) = &args.junit {
        let took = (machine::now() - began).as_secs_f64();
        let suite = format!("conform {kind} {node}");
        junit::write(path, &suite, took, report::cases(&findings))?;
    }
    inspect::print_text(&report::shown(node.as_str(), &findings, args.format))?;
    Ok(report::exit(&findings))
}
