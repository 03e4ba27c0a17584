//! Result of looking at all nodes together, as tables and pictures show it.

use coaxle_clock::Span;
use coaxle_node::circles::AxisAddress;
use serde::Serialize;

use crate::finding::{PlantFinding, findings, modulo_of, unit_of};
use crate::graph::{AxisGraph, AxisNumber};
use crate::plant::{AxisOrigin, FarReference, LagRule, PlantNode, PlantRole, Showing};
use crate::presentation::{AxisStage, PlantLags, ShownAs, Stated, stated_delay};
use crate::proposal::{Need, ProposedDelay, ROUNDED_UP, needs, proposals};
use crate::routes::{AxisRoute, routes};
use crate::way::WayOrigin;

/// Nodes, links between them, routes of motions, proposals, findings. Times are milliseconds; none is unknown.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlantAnalysis {
    /// Nodes, in the order given.
    pub nodes: Vec<NodeSummary>,
    /// Links from a published axis to an axis of another node.
    pub links: Vec<LinkSummary>,
    /// Routes from each root to each end.
    pub routes: Vec<RouteSummary>,
    /// Number of routes beyond the greatest number.
    pub routes_left_out: usize,
    /// Proposed presentation delays.
    pub proposals: Vec<Proposal>,
    /// Contradictions.
    pub findings: Vec<PlantFinding>,
    /// Remarks: nothing contradicts, and something is not as good as it could be.
    pub notes: Vec<PlantFinding>,
}

/// A node.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NodeSummary {
    /// The node's name.
    pub node: String,
    /// File of its config.
    pub file: String,
    /// Kind of node.
    pub role: PlantRole,
    /// Cycle time of its frames, µs.
    pub cycle_time_us: Option<f64>,
    /// Time by which its slaves are held back.
    pub hold_back_ms: Option<f64>,
    /// Its axes.
    pub axes: Vec<AxisSummary>,
}

/// An axis of a node.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisSummary {
    /// Name in its node.
    pub axis: String,
    /// Address under which others can follow it.
    pub address: Option<String>,
    /// `program`, `encoder`, `replay`, `PLC`, `far`, `slave`, `output`.
    pub kind: &'static str,
    /// Unit of its position.
    pub unit: Option<String>,
    /// Length of its modulo period.
    pub modulo: Option<f64>,
    /// Delay by which a root is shown.
    pub present_after_ms: Option<f64>,
    /// Names of its masters in its own node.
    pub masters: Vec<String>,
    /// Addresses that it follows on other nodes: the first choice, then the standbys.
    pub follows: Vec<String>,
    /// True if no axis of these nodes follows it.
    pub is_unused: bool,
}

/// Link from a published axis to an axis of another node.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinkSummary {
    /// Indices of the publishing node and of its axis.
    pub from: (usize, usize),
    /// Indices of the following node and of its axis.
    pub to: (usize, usize),
    /// Figures of the link.
    #[serde(flatten)]
    pub stage: StageSummary,
}

/// Figures of an axis that follows one of another node.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageSummary {
    /// Followed axis, `line/axes/1`.
    pub source: String,
    /// The following node.
    pub node: String,
    /// Mean time of a message.
    pub delay_ms: Option<f64>,
    /// Source of that figure.
    pub delay_origin: Option<WayOrigin>,
    /// PlantLags delay that would do for this way alone.
    pub needed_ms: Option<f64>,
    /// PlantLags delay that the frames state.
    pub present_after_ms: Option<f64>,
    /// Part of it that the node waits for.
    pub lag_ms: Option<f64>,
    /// Values that it shows.
    pub shown: ShownAs,
}

/// Route from a root to an end: of several between the same two, the longest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RouteSummary {
    /// The root, as `node/name`.
    pub root: String,
    /// The end, as `node/name`.
    pub end: String,
    /// Each axis on the way, as `node/name`.
    pub way: Vec<String>,
    /// Links between nodes, the first one first.
    pub stages: Vec<StageSummary>,
    /// Sum of the delays.
    pub delay_ms: Option<f64>,
    /// Sum of what each link needs.
    pub needed_ms: Option<f64>,
    /// Sum of the lags.
    pub lag_ms: Option<f64>,
    /// Time by which the end is held back.
    pub hold_back_ms: Option<f64>,
    /// Delay by which the root is shown; zero without one.
    pub present_after_ms: f64,
    /// The worst of what is shown on the way.
    pub shown: ShownAs,
}

/// PlantLags delay that would do for the generated axes of a node.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Proposal {
    /// The node.
    pub node: String,
    /// File of its config.
    pub file: String,
    /// Names of the axes.
    pub axes: Vec<String>,
    /// Stated delay; zero without one.
    pub stated_ms: f64,
    /// Delay that would do; none where none is known.
    pub present_after_ms: Option<f64>,
    /// Reason why none is known.
    pub reason: Option<&'static str>,
}

impl PlantAnalysis {
    /// Looks at all nodes together.
    #[must_use]
    pub fn of(nodes: &[PlantNode]) -> Self {
        let graph = AxisGraph::of(nodes);
        let shown = PlantLags::of(&graph, &Stated(&graph));
        let found = routes(&graph);
        let proposed = proposals(&graph, &found.found);
        let mut notes = lag_notes(&graph, &shown);
        notes.extend(delay_notes(&graph, &proposed));
        let summaries = found
            .found
            .iter()
            .map(|route| route_of(&graph, &shown, route));
        Self {
            nodes: (0..nodes.len())
                .map(|node| node_of(&graph, &shown, node))
                .collect(),
            links: links(&graph, &shown),
            routes: summaries.collect(),
            routes_left_out: found.left_out,
            proposals: proposed
                .iter()
                .map(|proposed| proposal_of(&graph, proposed))
                .collect(),
            findings: findings(&graph),
            notes,
        }
    }
}

fn millis(time: Span) -> f64 {
    // Dividing gives the closest number: 0.3, not 0.30000000000000004.
    time.as_nanos() as f64 / 1e6
}

fn node_of(graph: &AxisGraph<'_>, shown: &PlantLags, node: usize) -> NodeSummary {
    let this = &graph.nodes[node];
    let has_slaves = (this.axes.iter()).any(|axis| matches!(axis.origin, AxisOrigin::Slave { .. }));
    NodeSummary {
        node: this.name.to_string(),
        file: this.file.clone(),
        role: this.role,
        cycle_time_us: this.cycle_time.map(|cycle| cycle.span().as_micros_f64()),
        // Only slaves are held back.
        hold_back_ms: shown.hold_back[node].filter(|_| has_slaves).map(millis),
        axes: graph
            .axes_of(node)
            .map(|axis| axis_of(graph, axis))
            .collect(),
    }
}

fn axis_of(graph: &AxisGraph<'_>, number: AxisNumber) -> AxisSummary {
    let axis = graph.axis(number);
    let node = &graph.nodes[graph.node_of(number)].name;
    let address = axis.published.map(|(channel, id)| {
        let node = node.clone();
        AxisAddress { node, channel, id }.to_string()
    });
    let kind = match &axis.origin {
        AxisOrigin::Root { motion, .. } => motion.name(),
        AxisOrigin::Far(_) => "far",
        AxisOrigin::Slave { .. } => "slave",
        AxisOrigin::Output(_) => "output",
    };
    let masters = match &axis.origin {
        AxisOrigin::Slave { .. } => graph.masters(number),
        _ => &[],
    };
    let sources = graph.far(number).map_or(&[][..], |far| &far.sources);
    let delay = stated_delay(graph, number);
    AxisSummary {
        axis: axis.name.clone(),
        address,
        kind,
        unit: unit_of(graph, number).map(|unit| unit.to_string()),
        modulo: modulo_of(graph, number).map(coaxle_axis::Modulo::length),
        present_after_ms: (delay > Span::ZERO).then(|| millis(delay)),
        masters: masters
            .iter()
            .map(|master| graph.axis(*master).name.clone())
            .collect(),
        follows: sources.iter().map(ToString::to_string).collect(),
        is_unused: graph.followers(number).is_empty(),
    }
}

fn links(graph: &AxisGraph<'_>, shown: &PlantLags) -> Vec<LinkSummary> {
    let place = |axis: AxisNumber| {
        let node = graph.node_of(axis);
        (node, axis - graph.axes_of(node).start)
    };
    let link = |axis: AxisNumber| {
        let stage = stage_of(graph, shown, axis)?;
        let source = graph.masters(axis).first()?;
        Some(LinkSummary {
            from: place(*source),
            to: place(axis),
            stage,
        })
    };
    (0..graph.count()).filter_map(link).collect()
}

fn stage_of(graph: &AxisGraph<'_>, shown: &PlantLags, axis: AxisNumber) -> Option<StageSummary> {
    let far: &FarReference = graph.far(axis)?;
    let AxisStage {
        present_after,
        lag,
        shown,
    } = shown.stages[axis]?;
    let way = graph.way(axis);
    Some(StageSummary {
        source: far.sources.first()?.to_string(),
        node: graph.nodes[graph.node_of(axis)].name.to_string(),
        delay_ms: way.map(|way| millis(way.delay)),
        delay_origin: way.map(|way| way.origin),
        needed_ms: way.map(|way| millis(way.needed)),
        present_after_ms: present_after.map(millis),
        lag_ms: lag.map(millis),
        shown,
    })
}

fn route_of(graph: &AxisGraph<'_>, shown: &PlantLags, route: &AxisRoute) -> RouteSummary {
    let name = |axis: AxisNumber| {
        let node = &graph.nodes[graph.node_of(axis)].name;
        format!("{node}/{}", graph.axis(axis).name)
    };
    let stages: Vec<_> = (route.axes.iter())
        .filter_map(|axis| stage_of(graph, shown, *axis))
        .collect();
    let sum = |value: fn(&StageSummary) -> Option<f64>| {
        // One unknown part makes the sum unknown.
        let parts: Option<Vec<f64>> = stages.iter().map(value).collect();
        parts.map(|parts| rounded(parts.iter().sum()))
    };
    let (root, end) = (route.axes[0], route.axes[route.axes.len() - 1]);
    let is_slave = matches!(graph.axis(end).origin, AxisOrigin::Slave { .. });
    let held_back = shown.hold_back[graph.node_of(end)].filter(|_| is_slave);
    RouteSummary {
        root: name(root),
        end: name(end),
        way: route.axes.iter().map(|axis| name(*axis)).collect(),
        delay_ms: sum(|stage| stage.delay_ms),
        needed_ms: sum(|stage| stage.needed_ms),
        lag_ms: sum(|stage| stage.lag_ms),
        hold_back_ms: held_back.map(millis),
        present_after_ms: millis(stated_delay(graph, root)),
        shown: stages
            .iter()
            .map(|stage| stage.shown)
            .max()
            .unwrap_or(ShownAs::Local),
        stages,
    }
}

/// A sum of milliseconds without the errors of binary fractions, to a nanosecond.
fn rounded(sum: f64) -> f64 {
    (sum * 1e6).round() / 1e6
}

fn proposal_of(graph: &AxisGraph<'_>, proposed: &ProposedDelay) -> Proposal {
    let node = &graph.nodes[proposed.node];
    let names = proposed.roots.iter().map(|root| &graph.axis(*root).name);
    let reason = match (proposed.delay, proposed.need) {
        (Some(_), _) => None,
        (None, Need::UnknownWay) => Some("a way has no known delay"),
        (None, Need::Mutual) => {
            Some("nodes follow each other's slaves, and would wait for each other")
        }
        (None, Need::Is(_)) => Some(
            "a node on the way holds nothing back for its followers: an axis there is shown at once, or a lag is too short",
        ),
    };
    Proposal {
        node: node.name.to_string(),
        file: node.file.clone(),
        axes: names.cloned().collect(),
        stated_ms: millis(stated(graph, proposed)),
        present_after_ms: proposed.delay.map(millis),
        reason,
    }
}

fn stated(graph: &AxisGraph<'_>, proposed: &ProposedDelay) -> Span {
    let stated = proposed.roots.iter().map(|root| stated_delay(graph, *root));
    stated.min().unwrap_or_default()
}

/// Notes on delays that are shorter than what would do.
fn delay_notes(graph: &AxisGraph<'_>, proposed: &[ProposedDelay]) -> Vec<PlantFinding> {
    let note = |proposal: &ProposedDelay| {
        let (stated, delay) = (stated(graph, proposal), proposal.delay?);
        // Without a delay the newest values are moved to now, which is a choice.
        if stated == Span::ZERO || stated >= delay {
            return None;
        }
        let root = graph.axis(*proposal.roots.first()?);
        // Followers decide to the nanosecond, and a proposal is rounded up.
        let is_led = matches!(root.origin, AxisOrigin::Root { present_after: Some(range), .. } if range.is_led());
        if is_led && stated + ROUNDED_UP > delay {
            return None;
        }
        Some(PlantFinding {
            file: graph.nodes[proposal.node].file.clone(),
            field: format!("{}.present-after-ms", root.field),
            received: format!("{}", millis(stated)),
            expected: format!(
                "at least {}, for the longest chain of followers",
                millis(delay)
            ),
        })
    };
    proposed.iter().filter_map(note).collect()
}

/// Notes on nodes that use the whole delay although others follow their slaves.
fn lag_notes(graph: &AxisGraph<'_>, shown: &PlantLags) -> Vec<PlantFinding> {
    let needs = needs(graph);
    let mut notes: Vec<PlantFinding> = Vec::new();
    for axis in 0..graph.count() {
        let node = graph.node_of(axis);
        let (Some(far), Some(stage)) = (graph.far(axis), shown.stages[axis]) else {
            continue;
        };
        let is_later = stage.present_after.is_some_and(|delay| delay > Span::ZERO);
        let is_followed = needs[node] != Need::Is(Span::ZERO);
        let uses_all = far.showing == Showing::Later(LagRule::Full) && far.measured.is_none();
        if !(is_later && is_followed && uses_all && graph.leads(axis)) {
            continue;
        }
        let note = PlantFinding {
            file: graph.nodes[node].file.clone(),
            field: format!("{}.lag-ms", far.field),
            received: "\"full\"".to_owned(),
            expected: "\"auto\" or a figure: other nodes follow its axes, and nothing of the delay is left for them".to_owned(),
        };
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    notes
}
