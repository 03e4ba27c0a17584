//! A scenario's events as what happens to its nodes, in the order of time, for both worlds.

use coaxle_clock::Span;

use crate::event::{Action, Happening};
use crate::scenario::Scenario;
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
    /// One of its slaves is commanded, by the scenario's event with this number.
    Command(usize),
}

/// Every event of the scenario. A node that goes away comes back.
pub(crate) fn changes_of(scenario: &Scenario, topology: &Topology) -> Vec<Change> {
    let mut changes = Vec::new();
    for (number, event) in scenario.events.iter().enumerate() {
        let Some(node) = topology.node(&event.node) else {
            continue;
        };
        let from = event.at_s.span();
        let mut add = |at, what| changes.push(Change { at, node, what });
        match event.what {
            Happening::Command(_) => add(from, What::Command(number)),
            Happening::Away { action, for_s } => {
                let (away, back) = match action {
                    Action::Restart => (What::Kill, What::Start),
                    Action::Freeze => (What::Stop, What::Resume),
                };
                add(from, away);
                add(from + for_s.span(), back);
            }
        }
    }
    changes.sort_by_key(|change| change.at);
    changes
}
