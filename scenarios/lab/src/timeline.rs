//! A scenario's events as changes of its nodes, in the order of time, for both worlds.

use coaxle_clock::Span;

use crate::event::{Action, EventKind};
use crate::scenario::Scenario;
use crate::topology::Topology;

/// A change of a node or a router.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeChange {
    /// Time since the start.
    pub at: Span,
    /// The node or router concerned.
    pub target: ChangeTarget,
    /// Kind of the change.
    pub what: ChangeKind,
}

/// The node or router that a change concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangeTarget {
    /// A node, by its index; duplicates come after all others.
    Node(usize),
    /// A router, by its index among routers; real processes have none.
    Router(usize),
}

/// Kind of change of a node, or a router.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangeKind {
    /// Dies at once.
    Kill,
    /// Starts, or restarts.
    Start,
    /// Stands still.
    Stop,
    /// Continues.
    Resume,
    /// Continues, with waiting messages in pieces.
    ResumeInPieces,
    /// A command to one of its slaves, by the scenario's event with this index.
    Command(usize),
}

/// Changes of all events of the scenario. A node that goes away comes back, and a duplicate goes away.
pub fn changes_of(scenario: &Scenario, topology: &Topology) -> Vec<NodeChange> {
    let mut changes = Vec::new();
    for (number, event) in scenario.events.iter().enumerate() {
        let node = topology.node(&event.node).map(ChangeTarget::Node);
        let router = || scenario.router(&event.node).map(ChangeTarget::Router);
        let Some(target) = node.or_else(router) else {
            continue;
        };
        let from = event.at_s.span();
        let mut add = |at, target, what| changes.push(NodeChange { at, target, what });
        match event.what {
            EventKind::Command(_) => add(from, target, ChangeKind::Command(number)),
            EventKind::Away { action, for_s } => {
                let (target, first, then) = match action {
                    Action::Restart => (target, ChangeKind::Kill, ChangeKind::Start),
                    Action::Freeze => (target, ChangeKind::Stop, ChangeKind::Resume),
                    Action::Stop => (target, ChangeKind::Stop, ChangeKind::ResumeInPieces),
                    Action::Twin => {
                        let twin = scenario.twin_of(&event.node).map(ChangeTarget::Node);
                        (twin.unwrap_or(target), ChangeKind::Start, ChangeKind::Kill)
                    }
                };
                add(from, target, first);
                add(from + for_s.span(), target, then);
            }
        }
    }
    // Stable: events of one instant keep the order of the file.
    changes.sort_by_key(|change| change.at);
    changes
}
