//! A node of the simulation: a sender or a receiver.

use coaxle_clock::cycle::Tick;
use coaxle_clock::{Instant, Local};
use coaxle_node::command::OrderCargo;
use coaxle_node::{Arrival, Channel, CommandOrder, CommandOutcome, Message, Node, Outgoing};
use coaxle_receiver::Receiver;
use coaxle_sender::Sender;

/// A node of either kind, so that one world holds both.
pub(super) enum AnyNode {
    Sender(Box<Sender>),
    Receiver(Box<Receiver>),
}

impl Node for AnyNode {
    /// The watcher reads the nodes themselves.
    type Snapshot = ();

    fn receive(&mut self, at: Instant<Local>, subscription: usize, message: &Message<'_>) {
        match self {
            Self::Sender(node) => node.receive(at, subscription, message),
            Self::Receiver(node) => node.receive(at, subscription, message),
        }
    }

    fn execute_with(&mut self, order: &CommandOrder, cargo: &mut OrderCargo) -> CommandOutcome {
        match self {
            Self::Sender(node) => node.execute_with(order, cargo),
            Self::Receiver(node) => node.execute_with(order, cargo),
        }
    }

    fn cycle(&mut self, now: Instant<Local>) -> Tick {
        match self {
            Self::Sender(node) => node.cycle(now),
            Self::Receiver(node) => node.cycle(now),
        }
    }

    fn set_subscribed(&mut self, channel: Channel, is_subscribed: bool) {
        match self {
            Self::Sender(node) => node.set_subscribed(channel, is_subscribed),
            Self::Receiver(node) => node.set_subscribed(channel, is_subscribed),
        }
    }

    fn transmit(&mut self) -> Option<Outgoing<'_>> {
        match self {
            Self::Sender(node) => node.transmit(),
            Self::Receiver(node) => node.transmit(),
        }
    }

    fn arrival(&mut self) -> Option<Arrival> {
        match self {
            Self::Sender(node) => node.arrival(),
            Self::Receiver(node) => node.arrival(),
        }
    }

    fn next_cycle(&self) -> Instant<Local> {
        match self {
            Self::Sender(node) => node.next_cycle(),
            Self::Receiver(node) => node.next_cycle(),
        }
    }

    fn snapshot(&self) -> &() {
        &()
    }
}
