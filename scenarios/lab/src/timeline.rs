//! A scenario's events as changes of its nodes, in the order of time, for both worlds.

use coaxle_clock::Span;

use crate::event::{Action, Happening};
use crate::scenario::Scenario;
use crate::topology::Topology;

/// A change of a node or a router.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// Time since the start.
    pub at: Span,
    /// The node or router concerned.
    pub whom: Whom,
    /// Kind of the change.
    pub what: What,
}

/// The node or router that a change concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whom {
    /// A node, by its index; duplicates come after all others.
    Node(usize),
    /// A router, by its index among routers; real processes have none.
    Router(usize),
}

/// Kind of change of a node, or a router.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
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
pub fn changes_of(scenario: &Scenario, topology: &Topology) -> Vec<Change> {
    let mut changes = Vec::new();
    for (number, event) in scenario.events.iter().enumerate() {
        let node = topology.node(&event.node).map(Whom::Node);
        let router = || scenario.router(&event.node).map(Whom::Router);
        let Some(whom) = node.or_else(router) else {
            continue;
        };
        let from = event.at_s.span();
        let mut add = |at, whom, what| changes.push(Change { at, whom, what });
        match event.what {
            Happening::Command(_) => add(from, whom, What::Command(number)),
            Happening::Away { action, for_s } => {
                let (whom, first, then) = match action {
                    Action::Restart => (whom, What::Kill, What::Start),
                    Action::Freeze => (whom, What::Stop, What::Resume),
                    Action::Stop => (whom, What::Stop, What::ResumeInPieces),
                    Action::Twin => {
                        let twin = scenario.twin_of(&event.node).map(Whom::Node);
                        (twin.unwrap_or(whom), What::Start, What::Kill)
                    }
                };
                add(from, whom, first);
                add(from + for_s.span(), whom, then);
            }
        }
    }
    changes.sort_by_key(|change| change.at);
    changes
}
