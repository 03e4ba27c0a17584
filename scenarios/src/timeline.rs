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
    /// Number of the node; twins come after all others.
    pub(crate) node: usize,
    /// What.
    pub(crate) what: What,
}

/// What can happen to a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// It dies at once.
    Kill,
    /// It starts, anew if it was there before.
    Start,
    /// It stands still.
    Stop,
    /// It goes on.
    Resume,
    /// One of its slaves is commanded, by the scenario's event with this number.
    Command(usize),
}

/// Every event of the scenario. A node that goes away comes back, and a twin goes away.
pub(crate) fn changes_of(scenario: &Scenario, topology: &Topology) -> Vec<Change> {
    let mut changes = Vec::new();
    for (number, event) in scenario.events.iter().enumerate() {
        let Some(node) = topology.node(&event.node) else {
            continue;
        };
        let from = event.at_s.span();
        let mut add = |at, node, what| changes.push(Change { at, node, what });
        match event.what {
            Happening::Command(_) => add(from, node, What::Command(number)),
            Happening::Away { action, for_s } => {
                let (node, first, then) = match action {
                    Action::Restart => (node, What::Kill, What::Start),
                    Action::Freeze => (node, What::Stop, What::Resume),
                    Action::Twin => {
                        let twin = scenario.twin_of(&event.node).unwrap_or(node);
                        (twin, What::Start, What::Kill)
                    }
                };
                add(from, node, first);
                add(from + for_s.span(), node, then);
            }
        }
    }
    changes.sort_by_key(|change| change.at);
    changes
}
