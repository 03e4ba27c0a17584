//! The clerk: takes queries in, and sees to it that each gets its answer.

use std::borrow::Cow;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::Duration;

use coaxle_clock::Instant;
use coaxle_node::command::{CommandAnswer, CommandOrder, NotTaken};
use rtrb::{Consumer, Producer};

use super::{ANSWER_WITHIN, Done, MAX_WAITING, Ticket};
use crate::machine::{self, Machine};

/// How long it sleeps at most when nobody wakes it: answers that are due wait no longer.
const IDLE: Duration = Duration::from_millis(20);

/// Somebody who asks for a command.
pub(crate) trait Asker {
    /// The order, as it was sent.
    fn order(&self) -> Cow<'_, [u8]>;

    /// Says what became of it.
    fn answer(&self, answer: &CommandAnswer);
}

/// A query with its arrival.
pub(crate) struct Incoming<A> {
    pub(crate) arrival: Instant<Machine>,
    pub(crate) asker: A,
}

/// Where queries are handed in. Never waits.
pub(crate) struct Counter<A>(SyncSender<Incoming<A>>);

pub(super) fn counter<A>() -> (Counter<A>, Receiver<Incoming<A>>) {
    let (sender, receiver) = sync_channel(MAX_WAITING);
    (Counter(sender), receiver)
}

impl<A: Asker> Counter<A> {
    /// Takes a query, or says at once that there are too many.
    pub(crate) fn hand_in(&self, query: Incoming<A>) {
        let (query, reason) = match self.0.try_send(query) {
            Ok(()) => return,
            Err(TrySendError::Full(query)) => (query, NotTaken::Busy),
            Err(TrySendError::Disconnected(query)) => (query, NotTaken::Stopped),
        };
        query.asker.answer(&CommandAnswer::not_taken(&reason));
    }
}

/// Who deals with the queries.
pub(crate) struct Clerk<A> {
    incoming: Receiver<Incoming<A>>,
    orders: Producer<Ticket>,
    outcomes: Consumer<Done>,
    waiting: Vec<Waiting<A>>,
    taken: u64,
}

/// A query whose order is with the cycle.
struct Waiting<A> {
    ticket: Ticket,
    asker: A,
}

impl<A: Asker> Clerk<A> {
    pub(super) fn new(
        incoming: Receiver<Incoming<A>>,
        orders: Producer<Ticket>,
        outcomes: Consumer<Done>,
    ) -> Self {
        Self {
            incoming,
            orders,
            outcomes,
            waiting: Vec::with_capacity(MAX_WAITING),
            taken: 0,
        }
    }

    /// Works until the cycle has ended.
    pub(crate) fn work(mut self) {
        loop {
            // Asked before the outcomes are taken, so that the last ones are not missed.
            let last_round = self.outcomes.is_abandoned();
            self.round(machine::now());
            if last_round {
                break;
            }
            std::thread::park_timeout(IDLE);
        }
        let stopped = CommandAnswer::not_taken(&NotTaken::Stopped);
        for waiting in &self.waiting {
            waiting.asker.answer(&stopped);
        }
    }

    /// Answers what has an outcome, then what has waited too long, then takes in what is new.
    pub(crate) fn round(&mut self, now: Instant<Machine>) {
        while let Ok(done) = self.outcomes.pop() {
            self.answer(&done);
        }
        self.waiting.retain(|waiting| {
            let in_time = now - waiting.ticket.arrival < ANSWER_WITHIN;
            if !in_time {
                waiting
                    .asker
                    .answer(&CommandAnswer::not_taken(&NotTaken::NoAnswer));
            }
            in_time
        });
        while let Ok(query) = self.incoming.try_recv() {
            self.take(query);
        }
    }

    fn answer(&mut self, done: &Done) {
        let found = self
            .waiting
            .iter()
            .position(|waiting| waiting.ticket.number == done.number);
        if let Some(place) = found {
            let waiting = self.waiting.remove(place);
            let answer = CommandAnswer::new(&waiting.ticket.order, &done.outcome);
            waiting.asker.answer(&answer);
        }
    }

    fn take(&mut self, query: Incoming<A>) {
        let Incoming { arrival, asker } = query;
        let order = match CommandOrder::from_json(&asker.order()) {
            Ok(order) => order,
            Err(error) => return asker.answer(&CommandAnswer::malformed(&error)),
        };
        let ticket = Ticket {
            number: self.taken,
            arrival,
            order,
        };
        if self.waiting.len() < MAX_WAITING && self.orders.push(ticket).is_ok() {
            self.taken += 1;
            self.waiting.push(Waiting { ticket, asker });
        } else {
            asker.answer(&CommandAnswer::not_taken(&NotTaken::Busy));
        }
    }
}
