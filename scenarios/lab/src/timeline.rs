//! A scenario's events as what happens to its nodes, in the order of time, for both worlds.

use coaxle_clock::Span;

use crate::event::{Action, Happening};
use crate::scenario::Scenario;
use crate::topology::Topology;

/// Something that happens to a node or a router.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// When, since the start.
    pub at: Span,
    /// To whom.
    pub whom: Whom,
    /// What.
    pub what: What,
}

/// To whom something happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whom {
    /// A node, by its number; twins come after all others.
    Node(usize),
    /// A router, by its number among routers; real processes have none.
    Router(usize),
}

/// What can happen to a node, or a router.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// It dies at once.
    Kill,
    /// It starts, anew if it was there before.
    Start,
    /// It stands still.
    Stop,
    /// It goes on.
    Resume,
    /// It goes on, and what waited for it comes in pieces.
    ResumeInPieces,
    /// One of its slaves is commanded, by the scenario's event with this number.
    Command(usize),
}

/// Every event of the scenario. A node that goes away comes back, and a twin goes away.
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
