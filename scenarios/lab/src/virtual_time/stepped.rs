//! A scenario whose virtual time is advanced by its caller, step by step.

use std::collections::VecDeque;

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::Node;
use coaxle_receiver::{Receiver, SignalRow};
use coaxle_sim::{CycleSeen, Observer, World};

use super::any_node::AnyNode;
use super::populated::{GivenMotion, apply, populate};
use crate::scenario::Scenario;
use crate::timeline::{NodeChange, changes_of};
use crate::topology::Topology;

/// A scenario under way. Its nodes, links and events are those of [`run`](super::run), but nothing is judged, and its duration is
/// that of its steps.
pub struct SteppedScenario {
    scenario: Scenario,
    world: World<AnyNode>,
    /// Events to come.
    changes: VecDeque<NodeChange>,
}

/// A receiver after a cycle.
#[derive(Clone, Copy)]
pub struct ReceiverSeen<'a> {
    /// Number among the receivers.
    pub number: usize,
    /// Ideal start of the cycle, ns of true time.
    pub at_ns: i64,
    /// Actual beginning of the cycle, ns of true time.
    pub woke_ns: i64,
    /// The receiver.
    pub receiver: &'a Receiver,
}

impl SteppedScenario {
    /// Starts a checked scenario. `motion` moves the axes of its senders in place of their own sources, if there is one.
    ///
    /// # Errors
    /// A node that cannot be built.
    pub fn new(scenario: Scenario, motion: Option<&GivenMotion>) -> anyhow::Result<Self> {
        let topology = Topology::of(&scenario).map_err(|wrong| wrong.in_file("scenario"))?;
        Ok(Self {
            world: populate(&scenario, &topology, motion)?,
            changes: changes_of(&scenario, &topology).into(),
            scenario,
        })
    }

    /// Reading of the clock of a sender now, by its number.
    pub fn sender_time(&mut self, number: usize) -> Instant<Local> {
        self.world.local_now(number)
    }

    /// Lets virtual time flow until `end`, which belongs to the next step. Each cycle of a receiver is passed to `seen`.
    ///
    /// # Errors
    /// A node that breaks its contract.
    pub fn advance(
        &mut self,
        end: Span,
        seen: &mut dyn FnMut(&ReceiverSeen<'_>),
    ) -> anyhow::Result<()> {
        let mut observer = StepObserver {
            senders: self.scenario.senders.len(),
            receivers: self.scenario.receivers.len(),
            seen,
        };
        while let Some(change) = self.changes.front().copied().filter(|it| it.at < end) {
            self.changes.pop_front();
            let at = Instant::EPOCH + change.at;
            self.world.run_until(at, &mut observer)?;
            apply(&mut self.world, &self.scenario, &change);
        }
        Ok(self.world.run_until(Instant::EPOCH + end, &mut observer)?)
    }
}

struct StepObserver<'a> {
    senders: usize,
    receivers: usize,
    seen: &'a mut dyn FnMut(&ReceiverSeen<'_>),
}

impl Observer<AnyNode> for StepObserver<'_> {
    fn cycle_seen(&mut self, seen: &CycleSeen<'_, AnyNode>) {
        let number = seen.index.checked_sub(self.senders);
        // Duplicates of nodes come after all others, and are not observed.
        let Some(number) = number.filter(|number| *number < self.receivers) else {
            return;
        };
        if let AnyNode::Receiver(receiver) = seen.node {
            (self.seen)(&ReceiverSeen {
                number,
                at_ns: seen.ideal_start.as_nanos(),
                woke_ns: seen.woke.as_nanos(),
                receiver,
            });
        }
    }
}

impl ReceiverSeen<'_> {
    /// Signals of the receiver in the cycle.
    #[must_use]
    pub fn signals(&self) -> &SignalRow {
        &self.receiver.snapshot().signals
    }
}
