//! `coaxle topology`: who follows whom over all nodes, from their configs or while they run.

pub(crate) mod configs;
pub(crate) mod live;
mod table;

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use coaxle_clock::Span;
use coaxle_host::cli::{NetworkArgs, parse_duration};
use coaxle_os::exit::Exit;
use coaxle_report::{inspect, print};
use coaxle_topology::{PlantAnalysis, dot};

/// Arguments of `coaxle topology`.
#[derive(Debug, Args)]
pub(crate) struct TopologyArgs {
    /// Config files of senders, receivers and gateways
    #[arg(value_name = "CONFIG", required_unless_present = "live")]
    configs: Vec<PathBuf>,
    /// Show the nodes that run, with measured delays
    #[arg(long, conflicts_with_all = ["configs", "assume_delay"])]
    live: bool,
    /// Take this delay for each way whose delay no config states
    #[arg(long, value_name = "DURATION", value_parser = parse_duration)]
    assume_delay: Option<Span>,
    /// Print JSON
    #[arg(long, conflicts_with = "dot")]
    json: bool,
    /// Print a graph in the language of Graphviz: `coaxle topology … --dot | dot -Tsvg`
    #[arg(long)]
    dot: bool,
    /// Write a picture as well
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    #[command(flatten)]
    network: NetworkArgs,
}

/// Prints routes, proposals and findings. Contradictions are no success.
///
/// # Errors
/// A config that no node would start with; a network that cannot be joined, or without nodes; a picture that cannot be written.
pub(crate) fn topology(args: &TopologyArgs) -> anyhow::Result<Exit> {
    let plant = match args.live {
        true => PlantAnalysis::of(&live::nodes(&args.network)?),
        false => {
            let nodes = configs::nodes(&args.configs, args.assume_delay)?;
            configs::with_written_fields(PlantAnalysis::of(&nodes), &args.configs)
        }
    };
    if let Some(path) = &args.svg {
        write_picture(path, &plant)?;
    }
    inspect::print_text(&text(args, &plant)?)?;
    Ok(Exit::Failed.done_if(plant.findings.is_empty()))
}

fn text(args: &TopologyArgs, plant: &PlantAnalysis) -> anyhow::Result<String> {
    if args.json {
        return serde_json::to_string_pretty(plant).context("cannot write JSON");
    }
    Ok(match args.dot {
        true => dot(plant).trim_end().to_owned(),
        false => table::text(plant),
    })
}

fn write_picture(path: &Path, plant: &PlantAnalysis) -> anyhow::Result<()> {
    std::fs::write(path, print::svg_of_plant(plant))
        .with_context(|| format!("cannot write {}", path.display()))
}
