//! A scenario's events as what happens to its nodes, in the order of time, for both worlds.

use coaxle_clock::Span;

use crate::scenario::{Action, Scenario};
use crate::topology::Topology;

/// Something that happens to a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Change {
    /// When, since the start.
    pub(crate) at: Span,
    /// Number of the node.
    pub(crate) node: usize,
    /// What.
    pub(crate) what: What,
}

/// What can happen to a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// It dies at once.
    Kill,
    /// It starts anew.
    Start,
    /// It stands still.
    Stop,
    /// It goes on.
    Resume,
}

/// Every event of the scenario: the node goes away, and comes back.
pub(crate) fn changes_of(scenario: &Scenario, topology: &Topology) -> Vec<Change> {
    let mut changes = Vec::new();
    for event in &scenario.events {
        let Some(node) = topology.node(&event.node) else {
            continue;
        };
        let from = event.at_s.span();
        let until = from + event.for_s.span();
        let (away, back) = match event.action {
            Action::Restart => (What::Kill, What::Start),
            Action::Freeze => (What::Stop, What::Resume),
        };
        changes.extend([(from, away), (until, back)].map(|(at, what)| Change { at, node, what }));
    }
    changes.sort_by_key(|change| change.at);
    changes
}
