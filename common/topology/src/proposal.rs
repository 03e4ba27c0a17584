//! PlantLags delays that would do: for each node that generates axes, the time that its longest chain of followers needs.

use std::collections::BTreeSet;

use coaxle_clock::Span;

use crate::graph::{AxisGraph, AxisNumber};
use crate::plant::{AxisOrigin, LagRule, PlantNode, Showing};
use crate::presentation::{PlantLags, Settings, ShownAs, asked, stated_delay, whole_cycles};
use crate::routes::AxisRoute;

/// Time that the followers of a node need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Need {
    /// At least this time; zero without followers that are shown later.
    Is(Span),
    /// A way without a known delay.
    UnknownWay,
    /// Nodes that follow each other's slaves: each would have to wait for the other.
    Mutual,
}

impl Need {
    fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Is(one), Self::Is(other)) => Self::Is(one.max(other)),
            (Self::Mutual, _) | (_, Self::Mutual) => Self::Mutual,
            (Self::UnknownWay, _) | (_, Self::UnknownWay) => Self::UnknownWay,
        }
    }

    fn plus(self, more: Span) -> Self {
        match self {
            Self::Is(time) => Self::Is(time + more),
            other => other,
        }
    }
}

/// Delay that would do for the axes of a node that are roots.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ProposedDelay {
    pub(crate) node: usize,
    /// Its roots with routes to other nodes, or to slaves that wait for other nodes.
    pub(crate) roots: Vec<AxisNumber>,
    pub(crate) need: Need,
    /// Delay to be written; none where none would do.
    pub(crate) delay: Option<Span>,
}

/// Proposes a delay for each node with generated roots that others follow.
pub(crate) fn proposals(graph: &AxisGraph<'_>, routes: &[AxisRoute]) -> Vec<ProposedDelay> {
    let needs = needs(graph);
    let leads_away = |route: &&AxisRoute| route.axes.iter().any(|axis| graph.far(*axis).is_some());
    let away = routes.iter().filter(leads_away);
    let away: BTreeSet<_> = away.map(|route| route.axes[0]).collect();
    let mut proposed: Vec<_> = (0..graph.nodes.len())
        .filter_map(|node| proposal_of(graph, &away, &needs, node))
        .collect();
    check(graph, routes, &needs, &mut proposed);
    proposed
}

fn proposal_of(
    graph: &AxisGraph<'_>,
    away: &BTreeSet<AxisNumber>,
    needs: &[Need],
    node: usize,
) -> Option<ProposedDelay> {
    let roots = graph.axes_of(node).filter(|axis| {
        let origin = &graph.axis(*axis).origin;
        matches!(origin, AxisOrigin::Root { motion, .. } if motion.is_generated())
    });
    let roots: Vec<_> = roots.filter(|root| away.contains(root)).collect();
    if roots.is_empty() || needs[node] == Need::Is(Span::ZERO) {
        return None;
    }
    let delay = match needs[node] {
        Need::Is(need) => Some(rounded(&graph.nodes[node], need)),
        Need::UnknownWay | Need::Mutual => None,
    };
    Some(ProposedDelay {
        node,
        roots,
        need: needs[node],
        delay,
    })
}

/// Time that the followers of each node need, by the rule that a node has one hold-back for all of its axes.
pub(crate) fn needs(graph: &AxisGraph<'_>) -> Vec<Need> {
    let mut needs = vec![Need::Is(Span::ZERO); graph.nodes.len()];
    // A chain has as many nodes as there are: needs that still grow after as many rounds grow for ever.
    for _ in 0..graph.nodes.len() {
        let next = all_needs(graph, &needs);
        if next == needs {
            return needs;
        }
        needs = next;
    }
    let next = all_needs(graph, &needs);
    let pairs = needs.iter().zip(&next);
    let mut settled: Vec<_> = pairs
        .map(|(need, next)| if need == next { *need } else { Need::Mutual })
        .collect();
    // A node that leads to such nodes has no delay either.
    for _ in 0..graph.nodes.len() {
        settled = all_needs(graph, &settled)
            .into_iter()
            .zip(&settled)
            .map(|(next, before)| {
                if *before == Need::Mutual {
                    Need::Mutual
                } else {
                    next
                }
            })
            .collect();
    }
    settled
}

fn all_needs(graph: &AxisGraph<'_>, needs: &[Need]) -> Vec<Need> {
    let mut next = vec![Need::Is(Span::ZERO); needs.len()];
    for axis in 0..graph.count() {
        let Some(source) = graph
            .masters(axis)
            .first()
            .filter(|_| graph.far(axis).is_some())
        else {
            continue;
        };
        let from = graph.node_of(*source);
        next[from] = next[from].and(need_of(graph, axis, needs));
    }
    for (node, need) in next.iter_mut().enumerate() {
        if let Need::Is(time) = need {
            // Set values are held back by whole cycles.
            *time = whole_cycles(&graph.nodes[node], *time, up).max(*time);
        }
    }
    next
}

/// Time that an axis of another node needs: for its own way, and for the followers of its node.
fn need_of(graph: &AxisGraph<'_>, axis: AxisNumber, needs: &[Need]) -> Need {
    let Some(far) = graph.far(axis) else {
        return Need::Is(Span::ZERO);
    };
    let node = graph.node_of(axis);
    let Showing::Later(rule) = far.showing else {
        // Shown at once: no delay is of any use to it.
        return Need::Is(Span::ZERO);
    };
    let own = match rule {
        LagRule::Fixed(lag) => Some(lag),
        LagRule::Full | LagRule::Auto => asked(graph, axis),
    };
    match own {
        None => Need::UnknownWay,
        Some(own) if graph.leads(axis) => needs[node].plus(own),
        Some(own) => Need::Is(own),
    }
}

/// Settings that are proposed.
struct Proposed<'g> {
    graph: &'g AxisGraph<'g>,
    delays: &'g [ProposedDelay],
    needs: &'g [Need],
}

impl Settings for Proposed<'_> {
    fn present_after(&self, axis: AxisNumber) -> Span {
        let mut delays = self.delays.iter();
        let own = delays.find(|delay| delay.roots.contains(&axis));
        let stated = || stated_delay(self.graph, axis);
        own.and_then(|own| own.delay).unwrap_or_else(stated)
    }

    fn rule(&self, axis: AxisNumber, stated: LagRule) -> LagRule {
        match (stated, self.needs[self.graph.node_of(axis)]) {
            // Its followers need a part.
            (LagRule::Full, Need::Is(need)) if need > Span::ZERO => LagRule::Auto,
            _ => stated,
        }
    }

    fn is_real(&self) -> bool {
        false
    }
}

/// Takes back what would not do: a node that shows another axis at once holds nothing back.
fn check(
    graph: &AxisGraph<'_>,
    routes: &[AxisRoute],
    needs: &[Need],
    proposed: &mut [ProposedDelay],
) {
    let settings = Proposed {
        graph,
        delays: proposed,
        needs,
    };
    let shown = PlantLags::of(graph, &settings);
    let is_late = |axis: &AxisNumber| {
        let stage = shown.stages[*axis];
        stage.is_some_and(|stage| match stage.shown {
            ShownAs::Extrapolated | ShownAs::Unknown => true,
            // Now although it would be shown later: nothing is left of the delay.
            ShownAs::Now => {
                let far = graph.far(*axis);
                far.is_some_and(|far| matches!(far.showing, Showing::Later(_)))
            }
            ShownAs::Local | ShownAs::Interpolated | ShownAs::AsReceived => false,
        })
    };
    let late = routes.iter().filter(|route| route.axes.iter().any(is_late));
    let late: BTreeSet<_> = late.map(|route| route.axes[0]).collect();
    for proposal in proposed {
        if proposal.roots.iter().any(|root| late.contains(root)) {
            proposal.delay = None;
        }
    }
}

/// Longest presentation delay of a config (`PresentAfterMs`).
const LONGEST: Span = Span::from_millis(4_000);

/// Greatest time by which a proposal is rounded up.
pub(crate) const ROUNDED_UP: Span = Span::from_millis(1);

/// A figure that a person would write: tenths of a millisecond below ten, whole ones above.
fn rounded(node: &PlantNode, need: Span) -> Span {
    let cycle = node.cycle_time.map_or(Span::ZERO, |cycle| cycle.span());
    let need = need.max(cycle);
    let unit = match need < Span::from_millis(10) {
        true => Span::from_micros(100),
        false => ROUNDED_UP,
    };
    (unit * up(need.as_nanos(), unit.as_nanos())).min(LONGEST)
}

/// Rounds a quotient up.
fn up(time: i64, unit: i64) -> i64 {
    -(-time).div_euclid(unit)
}
