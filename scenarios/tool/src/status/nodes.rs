//! `coaxle nodes`: the nodes of a network.

use std::collections::BTreeMap;

use clap::Args;

use coaxle_host::cli::NetworkArgs;
use coaxle_host::client::SeenNode;
use coaxle_os::exit::Exit;
use coaxle_report::inspect::{self, right, table};
use comfy_table::Cell;
use serde_json::json;

use super::circles;
use super::reading::StatusFields;
use super::words::{UNKNOWN, or_unknown, seconds};
use super::{ROUND, STATUS_TIMEOUT, reading};

/// Arguments of `coaxle nodes`.
#[derive(Debug, Args)]
pub struct NodesArgs {
    /// Print a JSON list
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    network: NetworkArgs,
}

/// Prints the nodes. Without any node, or with axes that follow each other in a circle, that is no success.
///
/// # Errors
/// A wrong network section, or a network that cannot be joined.
pub fn nodes(args: &NodesArgs) -> anyhow::Result<Exit> {
    let watcher = args.network.watch(&[])?;
    let _ = watcher.wait_for(STATUS_TIMEOUT, |seen| !seen.is_empty());
    // The first node ends the wait above; the others and all statuses take a round.
    let seen = watcher.wait_for(ROUND, |_| false);
    let place = watcher.whereabouts().to_owned();
    watcher.close();
    if seen.is_empty() && !args.json {
        tracing::error!("no node is there after {}, {place}", STATUS_TIMEOUT + ROUND);
    }
    let text = match args.json {
        true => as_json(&seen),
        false => as_table(&seen),
    };
    let circles = circles::among(&seen);
    for circle in &circles {
        tracing::error!("0x816f: a circle: {circle}");
    }
    inspect::print(|out| {
        if !text.is_empty() {
            writeln!(out, "{text}")?;
        }
        Ok(true)
    })?;
    let exit = Exit::NoData.done_if(!seen.is_empty());
    Ok(match exit {
        // Without any node there is no circle either, so that exit code stands.
        Exit::Done => Exit::NotMet.done_if(circles.is_empty()),
        exit => exit,
    })
}

fn as_table(seen: &[SeenNode]) -> String {
    let mut table = table([
        "node", "role", "health", "up", "follows", "heard by", "axes",
    ]);
    for node in seen {
        // A node whose status is not received is still listed, by its liveliness token.
        let empty = serde_json::Map::new();
        let status = reading(node).unwrap_or(StatusFields::of(&empty));
        let health = match node.is_alive {
            true => status.text("health").unwrap_or(UNKNOWN),
            // The last health would be that of before.
            false => "gone",
        };
        let role = match (status.text("role"), status.text("lab")) {
            (Some(role), Some(_)) => format!("{role}, lab"),
            (role, _) => role.unwrap_or(UNKNOWN).to_owned(),
        };
        let sources = status.parts("sources").map(|(name, _)| name);
        table.add_row([
            Cell::new(&node.name),
            Cell::new(role),
            Cell::new(health),
            right(&or_unknown(status.number("uptime_s"), seconds)),
            Cell::new(sources.collect::<Vec<_>>().join(", ")),
            Cell::new(status.names("seen_by")),
            Cell::new(axes(&status)),
        ]);
    }
    match seen {
        [] => String::new(),
        _ => table.to_string(),
    }
}

/// `conveyor (1), belt (2)`: axes for others to follow, with the ids that they need for it.
fn axes(status: &StatusFields<'_>) -> String {
    let mut by_id = BTreeMap::new();
    for (name, axis) in status.parts("axes") {
        let id = match axis.text("node") {
            Some(_) => axis.number("published_id"),
            None => axis.number("id"),
        };
        if let Some(id) = id {
            // By id, because followers name axes by it.
            by_id.insert(id as u64, format!("{name} ({id})"));
        }
    }
    let mut axes: Vec<_> = by_id.into_values().collect();
    let slave =
        |(name, slave): (&str, StatusFields<'_>)| Some((name.to_owned(), slave.number("id")?));
    let slaves = status.parts("slaves").filter_map(slave);
    axes.extend(slaves.map(|(name, id)| format!("slave {name} ({id})")));
    axes.join(", ")
}

fn as_json(seen: &[SeenNode]) -> String {
    let node = |node: &SeenNode| {
        let status = reading(node);
        let text = |name| status.and_then(|status| status.text(name));
        let sources = status.map(|status| status.parts("sources").map(|(name, _)| name).collect());
        let sources: Vec<&str> = sources.unwrap_or_default();
        json!({
            "node": node.name, "alive": node.is_alive, "role": text("role"), "health": text("health"),
            "epoch": text("epoch"), "follows": sources, "lab": text("lab"),
        })
    };
    format!("{:#}", seen.iter().map(node).collect::<serde_json::Value>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status::samples::{RECEIVER, SENDER, object};
    use coaxle_clock::Instant;
    use coaxle_node::keys::NodeName;

    fn seen() -> Vec<SeenNode> {
        let node = |name: &str, is_alive, json: Option<&str>| SeenNode {
            name: NodeName::new(name).unwrap(),
            is_alive,
            status: json.map(|json| (Instant::EPOCH, object(json))),
        };
        vec![
            node("conveyor", true, Some(SENDER)),
            node("new", true, None),
            node("saw", false, Some(RECEIVER)),
        ]
    }

    #[test]
    fn who_is_there_is_listed_with_what_can_be_followed() {
        let text = as_table(&seen());
        let squeezed = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        let lines: Vec<_> = text.lines().map(squeezed).collect();
        for expected in [
            "conveyor sender ok 25.2 s saw conveyor (1)",
            "new – – –",
            "saw receiver gone 25.0 s conveyor",
        ] {
            assert!(
                lines.iter().any(|line| line == expected),
                "{expected}\n{lines:#?}"
            );
        }
        assert_eq!(as_table(&[]), "");
    }

    #[test]
    fn a_node_of_an_experiment_is_listed_as_one() {
        let mut all = seen();
        if let Some((_, status)) = &mut all[0].status {
            status.insert("lab".to_owned(), json!("lab.clock.drift-ppm = 500"));
        }
        let text = as_table(&all);
        assert!(text.contains("sender, lab"), "{text}");
        let list: serde_json::Value = serde_json::from_str(&as_json(&all)).unwrap();
        assert_eq!(list[0]["lab"], "lab.clock.drift-ppm = 500");
    }

    #[test]
    fn the_list_of_json_has_them_all() {
        let list: serde_json::Value = serde_json::from_str(&as_json(&seen())).unwrap();
        assert_eq!(list[0]["node"], "conveyor");
        assert_eq!(
            (&list[1]["alive"], &list[1]["role"]),
            (&true.into(), &serde_json::Value::Null)
        );
        assert_eq!(list[2]["follows"], json!(["conveyor"]));
    }
}
