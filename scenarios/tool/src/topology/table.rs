//! Nodes, routes, proposals and findings as tables.

use coaxle_report::inspect::{right, table};
use coaxle_topology::{AxisSummary, PlantAnalysis, Proposal, RouteSummary, StageSummary, short};
use comfy_table::Cell;

use crate::status::UNKNOWN;

/// Writes everything, the findings last.
pub(super) fn text(plant: &PlantAnalysis) -> String {
    let mut parts = vec![nodes(plant)];
    if !plant.routes.is_empty() {
        parts.push(routes(plant));
    }
    if plant.routes_left_out > 0 {
        parts.push(format!("and {} more routes", plant.routes_left_out));
    }
    let lines = [
        plant.proposals.iter().map(proposal).collect::<Vec<_>>(),
        unused(plant).into_iter().collect(),
        plant
            .notes
            .iter()
            .map(|note| format!("note: {note}"))
            .collect(),
        (plant.findings.iter())
            .map(|finding| format!("wrong: {finding}"))
            .collect(),
    ];
    let lines: Vec<_> = lines.concat();
    if !lines.is_empty() {
        parts.push(lines.join("\n"));
    }
    parts.join("\n\n")
}

fn nodes(plant: &PlantAnalysis) -> String {
    let mut table = table(["node", "role", "cycle", "held back", "axes", "config"]);
    for node in &plant.nodes {
        let axes: Vec<_> = node.axes.iter().map(axis).collect();
        let cycle = node.cycle_time_us.map(|micros| micros / 1e3);
        table.add_row([
            Cell::new(&node.node),
            Cell::new(node.role.name()),
            right(&millis(cycle)),
            right(
                &node
                    .hold_back_ms
                    .map_or(String::new(), |time| millis(Some(time))),
            ),
            Cell::new(axes.join("\n")),
            Cell::new(&node.file),
        ]);
    }
    table.to_string()
}

/// `roll (slaves/1, mm) of far`: an axis with its address in the node, its unit, and its masters.
fn axis(axis: &AxisSummary) -> String {
    let address = axis
        .address
        .as_ref()
        .and_then(|address| address.split_once('/'));
    let mut within: Vec<String> = address
        .map(|(_, rest)| rest.to_owned())
        .into_iter()
        .collect();
    within.extend(axis.unit.clone());
    within.extend(axis.modulo.map(|length| format!("modulo {length}")));
    let within = match within.is_empty() {
        true => String::new(),
        false => format!(" ({})", within.join(", ")),
    };
    let masters = match (axis.masters.as_slice(), axis.follows.as_slice()) {
        ([], []) => format!(": {}", axis.kind),
        ([], [first]) => format!(" ← {first}"),
        ([], [first, standbys @ ..]) => format!(" ← {first}, standby {}", standbys.join(", ")),
        (masters, _) => format!(" ← {}", masters.join(", ")),
    };
    format!("{}{within}{masters}", axis.axis)
}

fn routes(plant: &PlantAnalysis) -> String {
    let mut table = table([
        "root",
        "end",
        "way",
        "delay",
        "needs",
        "shown after",
        "lags",
        "held back",
        "shown",
    ]);
    for route in &plant.routes {
        let stages = |value: fn(&StageSummary) -> Option<f64>| {
            let values: Vec<_> = route
                .stages
                .iter()
                .map(|stage| millis_alone(value(stage)))
                .collect();
            values.join(" + ")
        };
        table.add_row([
            Cell::new(&route.root),
            Cell::new(&route.end),
            Cell::new(way(route)),
            right(&sum(stages(|stage| stage.delay_ms), route.delay_ms)),
            right(&sum(stages(|stage| stage.needed_ms), route.needed_ms)),
            right(&shown_after(route)),
            right(&sum(stages(|stage| stage.lag_ms), route.lag_ms)),
            right(&route.hold_back_ms.map_or(String::new(), short)),
            Cell::new(route.shown.name()),
        ]);
    }
    format!(
        "{table}\nTimes in ms, {UNKNOWN} unknown: the mean delay of messages, what each way needs so that 99.9 % of the cycles find their \
         frames, the presentation delay of the root, the lags of the nodes on the way, the hold-back of the end"
    )
}

/// The nodes on the way.
fn way(route: &RouteSummary) -> String {
    let mut nodes: Vec<&str> = Vec::new();
    for axis in &route.way {
        let node = axis.split('/').next().unwrap_or(axis);
        if nodes.last() != Some(&node) {
            nodes.push(node);
        }
    }
    nodes.join(" → ")
}

fn shown_after(route: &RouteSummary) -> String {
    match route.present_after_ms {
        0.0 => "now".to_owned(),
        delay => short(delay),
    }
}

/// `20 + 20 = 40`, or one part alone.
fn sum(parts: String, sum: Option<f64>) -> String {
    match (parts.contains('+'), sum) {
        (true, Some(sum)) => format!("{parts} = {}", short(sum)),
        _ => parts,
    }
}

fn proposal(proposal: &Proposal) -> String {
    let Proposal {
        node,
        axes,
        stated_ms,
        ..
    } = proposal;
    let axes = axes.join(", ");
    let stated = match stated_ms {
        0.0 => "none is stated".to_owned(),
        stated => format!("{} is stated", short(*stated)),
    };
    match (proposal.present_after_ms, proposal.reason) {
        (Some(delay), _) => format!(
            "proposal: {node} ({axes}): present-after-ms = {}; {stated}",
            short(delay)
        ),
        (None, reason) => format!(
            "proposal: {node} ({axes}): no present-after-ms, because {}; {stated}",
            reason.unwrap_or(UNKNOWN)
        ),
    }
}

/// Published roots that no axis of these nodes follows.
fn unused(plant: &PlantAnalysis) -> Option<String> {
    let nodes = plant.nodes.iter();
    let axes = nodes.flat_map(|node| node.axes.iter().map(move |axis| (node, axis)));
    let unused = axes
        .filter(|(_, axis)| axis.is_unused && axis.masters.is_empty() && axis.follows.is_empty());
    let names: Vec<_> = unused
        .map(|(node, axis)| format!("{}/{}", node.node, axis.axis))
        .collect();
    (!names.is_empty()).then(|| format!("followed by nobody: {}", names.join(", ")))
}

fn millis(time: Option<f64>) -> String {
    time.map_or(UNKNOWN.to_owned(), |time| format!("{} ms", short(time)))
}

fn millis_alone(time: Option<f64>) -> String {
    time.map_or(UNKNOWN.to_owned(), short)
}
