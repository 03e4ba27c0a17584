//! Lag of each axis that is shown later, and the hold-back of each node: the rule of a receiver, over all nodes at once.

use coaxle_clock::{CycleTime, Span};
use serde::Serialize;

use crate::graph::{AxisGraph, AxisNumber};
use crate::plant::{AxisOrigin, FarReference, LagRule, PlantNode, Showing};

/// Greatest hold-back of a receiver, in its cycles (`coaxle_slave::MOST_HELD_BACK`).
const MOST_CYCLES: i64 = 1_000;

/// Values that a follower shows of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShownAs {
    /// In its own node.
    Local,
    /// Between two frames that have arrived.
    Interpolated,
    /// Newest values moved to now.
    Now,
    /// Newest values as they are.
    AsReceived,
    /// Unknown, because the way is.
    Unknown,
    /// Later by too little: in more than one of 1000 cycles a frame has not arrived yet, and is predicted.
    Extrapolated,
}

impl ShownAs {
    /// Returns its word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Local => "local",
            Self::Interpolated => "interpolated",
            Self::Now => "extrapolated to now",
            Self::AsReceived => "as received",
            Self::Unknown => "unknown",
            Self::Extrapolated => "extrapolated: too late",
        }
    }
}

/// Figures of an axis that follows another node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AxisStage {
    /// Delay that its frames state; none if it is unknown.
    pub(crate) present_after: Option<Span>,
    /// Part of it that the node waits for.
    pub(crate) lag: Option<Span>,
    pub(crate) shown: ShownAs,
}

/// Lags and hold-backs of all nodes.
pub(crate) struct PlantLags {
    /// Figures of each axis that follows another node.
    pub(crate) stages: Vec<Option<AxisStage>>,
    /// Hold-back of each node; none if it is unknown.
    pub(crate) hold_back: Vec<Option<Span>>,
}

/// Delays of the roots and rules of the lags: those of the configs, or others to be tried.
pub(crate) trait Settings {
    /// Time after its generation at which a root is shown.
    fn present_after(&self, axis: AxisNumber) -> Span;
    /// Rule for the lag of an axis that is shown later.
    fn rule(&self, axis: AxisNumber, stated: LagRule) -> LagRule;
    /// True if measured values count.
    fn is_real(&self) -> bool;
}

/// Settings of the configs.
pub(crate) struct Stated<'g>(pub(crate) &'g AxisGraph<'g>);

impl Settings for Stated<'_> {
    fn present_after(&self, axis: AxisNumber) -> Span {
        stated_delay(self.0, axis)
    }

    fn rule(&self, _: AxisNumber, stated: LagRule) -> LagRule {
        stated
    }

    fn is_real(&self) -> bool {
        true
    }
}

/// Delay that a root states, by its config or as its followers want it; zero without one.
pub(crate) fn stated_delay(graph: &AxisGraph<'_>, axis: AxisNumber) -> Span {
    let AxisOrigin::Root {
        present_after: Some(range),
        followers: named,
        ..
    } = &graph.axis(axis).origin
    else {
        return Span::ZERO;
    };
    // A running node does not say whom it listens to.
    let is_heard = |follower: &&AxisNumber| {
        let name = &graph.nodes[graph.node_of(**follower)].name;
        range.is_led() && (named.is_empty() || named.contains(name))
    };
    let followers = graph.followers(axis).iter().filter(is_heard);
    let wanted = followers.filter_map(|follower| asked(graph, *follower));
    range.nearest(wanted.max().unwrap_or_default())
}

/// Time that the way of an axis asks for under the rule `auto`: a quarter and a cycle more than needed, as in a receiver.
pub(crate) fn asked(graph: &AxisGraph<'_>, axis: AxisNumber) -> Option<Span> {
    let needed = graph.way(axis)?.needed;
    let node = &graph.nodes[graph.node_of(axis)];
    Some(needed + needed / 4 + node.cycle_time.map_or(Span::ZERO, CycleTime::span))
}

/// Whole cycles of a node.
pub(crate) fn whole_cycles(node: &PlantNode, time: Span, round: fn(i64, i64) -> i64) -> Span {
    let Some(cycle) = node.cycle_time.map(CycleTime::span) else {
        return time;
    };
    cycle * round(time.as_nanos(), cycle.as_nanos()).clamp(0, MOST_CYCLES)
}

/// Rounds a quotient down.
fn down(time: i64, cycle: i64) -> i64 {
    time.div_euclid(cycle)
}

impl PlantLags {
    pub(crate) fn of(graph: &AxisGraph<'_>, settings: &impl Settings) -> Self {
        let mut found = Self {
            stages: vec![None; graph.count()],
            hold_back: vec![Some(Span::ZERO); graph.nodes.len()],
        };
        // Hold-backs pass from node to node: after as many rounds as a chain has nodes they are settled. Nodes that follow
        // each other's slaves may never settle, and their last round stands.
        for _ in 0..=graph.nodes.len() {
            let before = found.hold_back.clone();
            for node in 0..graph.nodes.len() {
                found.hold_back[node] = found.hold_back_of(graph, settings, node);
            }
            if found.hold_back == before {
                break;
            }
        }
        for axis in 0..graph.count() {
            found.stages[axis] = graph
                .far(axis)
                .map(|far| found.stage(graph, settings, axis, far));
        }
        found
    }

    /// Delay in the frames with an axis of another node; none if it is unknown.
    fn delay_of(
        &self,
        graph: &AxisGraph<'_>,
        settings: &impl Settings,
        axis: AxisNumber,
        far: &FarReference,
    ) -> Option<Span> {
        if let Some(measured) = far.measured.filter(|_| settings.is_real()) {
            return Some(measured.present_after);
        }
        // Without its publisher nothing is known of it.
        let source = *graph.masters(axis).first()?;
        match graph.axis(source).origin {
            AxisOrigin::Root { .. } => Some(settings.present_after(source)),
            // Frames of slaves and of far axes state the hold-back of their node.
            _ => self.hold_back[graph.node_of(source)],
        }
    }

    /// Hold-back of a node: the least that its leading axes leave, in whole cycles.
    fn hold_back_of(
        &self,
        graph: &AxisGraph<'_>,
        settings: &impl Settings,
        node: usize,
    ) -> Option<Span> {
        let this = &graph.nodes[node];
        if let Some(measured) = this.hold_back.filter(|_| settings.is_real()) {
            return Some(measured);
        }
        let leading = graph.axes_of(node).filter(|axis| graph.leads(*axis));
        let spare: Vec<_> = leading
            .filter_map(|axis| self.spare(graph, settings, axis))
            .collect();
        // One that is shown now decides, whatever is unknown of the others.
        if spare.is_empty() || spare.contains(&Some(Span::ZERO)) {
            return Some(Span::ZERO);
        }
        let least = spare.into_iter().try_fold(Span::MAX, |least, spare| {
            let spare = spare?;
            Some(least.min(spare))
        })?;
        Some(whole_cycles(this, least, down))
    }

    /// Time that an axis leaves of the delay by which it is shown: inner none if unknown, outer none if it has no say.
    fn spare(
        &self,
        graph: &AxisGraph<'_>,
        settings: &impl Settings,
        axis: AxisNumber,
    ) -> Option<Option<Span>> {
        match &graph.axis(axis).origin {
            // A root of a sender has no slaves; one of a receiver leaves all of it.
            AxisOrigin::Root { .. } => Some(Some(settings.present_after(axis))),
            AxisOrigin::Far(far) => Some(match far.showing {
                Showing::Now | Showing::AsReceived => Some(Span::ZERO),
                Showing::Later(rule) => {
                    let delay = self.delay_of(graph, settings, axis, far);
                    delay.and_then(|delay| {
                        let asked = asked(graph, axis);
                        let lag = settings.rule(axis, rule).lag(delay, asked);
                        lag.map(|lag| delay - lag)
                    })
                }
            }),
            AxisOrigin::Slave { .. } | AxisOrigin::Output(_) => None,
        }
    }

    fn stage(
        &self,
        graph: &AxisGraph<'_>,
        settings: &impl Settings,
        axis: AxisNumber,
        far: &FarReference,
    ) -> AxisStage {
        let delay = self.delay_of(graph, settings, axis, far);
        let at_once = |shown| AxisStage {
            present_after: delay,
            lag: Some(Span::ZERO),
            shown,
        };
        match (far.showing, delay) {
            (Showing::AsReceived, _) => return at_once(ShownAs::AsReceived),
            (Showing::Now, _) | (_, Some(Span::ZERO)) => return at_once(ShownAs::Now),
            (Showing::Later(_), _) => {}
        }
        let measured = far.measured.filter(|_| settings.is_real());
        let lag = measured.and_then(|measured| measured.lag).or_else(|| {
            // All axes of a node wait for the same instant: what the slaves are not held back by.
            Some(delay? - self.hold_back[graph.node_of(axis)]?)
        });
        let shown = match (lag, graph.way(axis)) {
            (Some(lag), Some(way)) if lag >= way.needed => ShownAs::Interpolated,
            (Some(_), Some(_)) => ShownAs::Extrapolated,
            _ => ShownAs::Unknown,
        };
        AxisStage {
            present_after: delay,
            lag,
            shown,
        }
    }
}
