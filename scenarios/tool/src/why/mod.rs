//! `coaxle why`: what limits the accuracy of a receiver now, by how much, and what to change first.
//!
//! Its only source is the status that the node publishes, twice within a second. [`causes`] finds what it says.

mod causes;
#[cfg(test)]
mod planted;
#[cfg(test)]
mod tests;

use std::time::Duration;

use clap::Args;
use coaxle_host::cli::NetworkArgs;
use coaxle_host::client::Watcher;
use coaxle_node::keys::NodeName;
use coaxle_os::exit::Exit;
use coaxle_report::inspect::{self, shown_to};
use serde_json::{Map, Value};

use crate::status::{StatusFields, gather, micros};
use causes::{LimitingCause, findings};

/// Time between the two statuses: four come in it.
const APART: Duration = Duration::from_secs(1);

/// The node, and the velocity that counts.
#[derive(Debug, Args)]
pub(crate) struct WhyArgs {
    /// The node
    #[arg(value_name = "NODE", value_parser = |name: &str| NodeName::new(name))]
    node: NodeName,
    /// Velocity at which errors of time are compared, u/s [default: that of each axis now; 1000 where it stands]
    #[arg(long, value_name = "U_PER_S", value_parser = velocity)]
    velocity: Option<f64>,
    /// As JSON, for programs
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    network: NetworkArgs,
}

fn velocity(text: &str) -> Result<f64, String> {
    let number = text.parse().ok();
    let number = number.filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "expected a finite number above 0".to_owned())
}

/// Prints what is wrong, and the errors by their size. The exit code is that of a failure if anything is wrong.
///
/// # Errors
/// A wrong network section, a network that cannot be joined, or a node that does not turn up.
pub(crate) fn why(args: &WhyArgs) -> anyhow::Result<Exit> {
    let watcher = args.network.watch(std::slice::from_ref(&args.node))?;
    let statuses = two_statuses(&watcher, &args.node);
    watcher.close();
    let Some([before, now]) = statuses? else {
        return Ok(Exit::NoData);
    };
    let [before, now] = [&before, &now].map(StatusFields::of);
    let found = findings(&before, &now, args.velocity);
    let text = match args.json {
        true => serde_json::to_string_pretty(&found)?,
        false => in_words(&args.node, &found),
    };
    inspect::print_text(&text)?;
    let is_wrong = found.iter().any(|finding| finding.is_wrong);
    Ok(Exit::Failed.done_if(!is_wrong))
}

fn two_statuses(
    watcher: &Watcher,
    node: &NodeName,
) -> anyhow::Result<Option<[Map<String, Value>; 2]>> {
    let nodes = std::slice::from_ref(node);
    let newest = || {
        let seen = gather(watcher, nodes)?;
        let status = seen.into_iter().next().and_then(|node| node.status);
        anyhow::Ok(status.map(|(_, status)| status))
    };
    let before = newest()?;
    std::thread::park_timeout(APART);
    Ok(before.zip(newest()?).map(|(before, now)| [before, now]))
}

/// Writes a paragraph for each finding, the first of which is to be changed first.
fn in_words(node: &NodeName, found: &[LimitingCause]) -> String {
    if found.is_empty() {
        return format!("{node}: nothing limits it that it could measure");
    }
    let mut lines = Vec::new();
    for (number, finding) in found.iter().enumerate() {
        let size = size(finding);
        let mark = if finding.is_wrong { "wrong" } else { "error" };
        lines.push(format!("{}. {mark}: {}{size}", number + 1, finding.what));
        lines.push(format!("   {}", finding.why));
        if let Some(remedy) = &finding.remedy {
            lines.push(format!("   → {remedy}"));
        }
    }
    format!(
        "{node}, the first to be changed first\n{}",
        lines.join("\n")
    )
}

/// `, at most 44.0 µs or 0.022 mm at 500 mm/s`
fn size(finding: &LimitingCause) -> String {
    let mut parts = Vec::new();
    if let Some(time) = finding.time_us {
        parts.push(micros(time));
    }
    if let Some(way) = &finding.way {
        parts.push(format!("{} {}", shown_to(way.by, 3), way.unit));
    }
    if parts.is_empty() {
        return String::new();
    }
    let way = finding.way.as_ref();
    let velocity = way.and_then(|way| Some((way.at_velocity?, &way.unit)));
    let velocity =
        velocity.map(|(velocity, unit)| format!(" at {} {unit}/s", shown_to(velocity, 3)));
    format!(
        ", at most {}{}",
        parts.join(" or "),
        velocity.unwrap_or_default()
    )
}
