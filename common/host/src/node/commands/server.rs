//! The command server: accepts requests and ensures a response to each.

use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::Thread;
use std::time::Duration;

use coaxle_clock::{Instant, Span};
use coaxle_node::circles::CIRCLE_CODE;
use coaxle_node::command::{CommandAnswer, CommandOrder, CommandVerdict, NotTaken};
use coaxle_node::keys::NodeName;
use coaxle_os::machine::{self, Machine};
use rtrb::{Consumer, Producer};

use super::MAX_WAITING;
use super::journal;
use super::queue::{QueuedOrder, ReturnedOrder};
use crate::network::transport::Request;
use crate::node::audit::Audit;
use crate::node::circles::CircleNames;

/// Time within which an order gets its response, even if the cycle hangs.
// Clients wait for three seconds, so that they hear the reason instead of silence.
const ANSWER_WITHIN: Span = Span::from_secs(1);

/// Longest sleep without a wake-up: due responses wait no longer.
// A hung order is answered later by this at most, which the client's three seconds bear.
const IDLE: Duration = Duration::from_millis(20);

/// Sends a reply with this response, as an error if no slave got the order.
pub(crate) fn answer(request: &dyn Request, answer: &CommandAnswer) {
    request.reply(answer.to_json(), answer.is_taken());
}

/// A request with its arrival and, if known, its operator.
pub(super) struct ArrivedRequest {
    arrival: Instant<Machine>,
    request: Box<dyn Request>,
    by: Option<NodeName>,
}

/// The sender that accepts requests. Never waits.
pub(crate) struct RequestSender {
    sender: SyncSender<ArrivedRequest>,
    server: Option<Thread>,
    audit: Audit,
}

pub(super) fn requests(most: usize, audit: &Audit) -> (RequestSender, Receiver<ArrivedRequest>) {
    let (sender, receiver) = sync_channel(most);
    // The thread does not exist yet when the ends are created.
    let sender = RequestSender {
        sender,
        server: None,
        audit: audit.clone(),
    };
    (sender, receiver)
}

impl RequestSender {
    /// Sets the thread that is woken when there is a request.
    pub(crate) fn attach(&mut self, server: Thread) {
        self.server = Some(server);
    }

    /// Queues a request, or replies at once that there are too many.
    pub(crate) fn send(
        &self,
        arrival: Instant<Machine>,
        request: Box<dyn Request>,
        by: Option<NodeName>,
    ) {
        let arrived = ArrivedRequest {
            arrival,
            request,
            by,
        };
        // `try_send`: the caller is the transport's thread, which receives frames as well.
        let (arrived, reason) = match self.sender.try_send(arrived) {
            Ok(()) => return self.wake(),
            Err(TrySendError::Full(arrived)) => (arrived, NotTaken::Busy),
            Err(TrySendError::Disconnected(arrived)) => (arrived, NotTaken::Stopped),
        };
        let refusal = CommandAnswer::not_taken(&reason);
        answer(&*arrived.request, &refusal);
        (self.audit).note(journal::unread(arrived.by.as_ref(), &refusal));
    }

    /// The audit of the node.
    pub(crate) const fn audit(&self) -> &Audit {
        &self.audit
    }

    fn wake(&self) {
        if let Some(server) = &self.server {
            server.unpark();
        }
    }
}

/// The server that handles the requests.
pub(crate) struct CommandServer {
    node: NodeName,
    requests: Receiver<ArrivedRequest>,
    orders: Producer<QueuedOrder>,
    outcomes: Consumer<ReturnedOrder>,
    waiting: Vec<Waiting>,
    taken: u64,
    circles: CircleNames,
    audit: Audit,
}

/// A request whose order is in the cycle.
struct Waiting {
    number: u64,
    arrival: Instant<Machine>,
    request: Box<dyn Request>,
}

impl CommandServer {
    pub(super) fn new(
        node: NodeName,
        requests: Receiver<ArrivedRequest>,
        orders: Producer<QueuedOrder>,
        outcomes: Consumer<ReturnedOrder>,
        audit: Audit,
    ) -> Self {
        Self {
            node,
            requests,
            orders,
            outcomes,
            // As many as can wait, so that the list never grows.
            waiting: Vec::with_capacity(MAX_WAITING),
            taken: 0,
            circles: CircleNames::default(),
            audit,
        }
    }

    /// The circles of slaves, shared with the circle search.
    pub(crate) fn circles(&self) -> CircleNames {
        self.circles.clone()
    }

    /// Serves requests until the cycle has ended.
    pub(crate) fn work(mut self) {
        loop {
            // Read before the outcomes are taken, so that the last ones are not missed.
            let last_round = self.outcomes.is_abandoned();
            self.round(machine::now());
            if last_round {
                break;
            }
            // A request that arrived since the round has set the flag: the park returns at once.
            std::thread::park_timeout(IDLE);
        }
        let stopped = CommandAnswer::not_taken(&NotTaken::Stopped);
        for waiting in &self.waiting {
            answer(&*waiting.request, &stopped);
        }
    }

    /// Responds to requests with an outcome, then to those past their timeout, then accepts new ones.
    pub(crate) fn round(&mut self, now: Instant<Machine>) {
        // Outcomes before timeouts: an order that was executed in time is never reported as unanswered.
        while let Ok(returned) = self.outcomes.pop() {
            self.finish(&returned);
        }
        self.waiting.retain(|waiting| {
            let in_time = now - waiting.arrival < ANSWER_WITHIN;
            if !in_time {
                answer(
                    &*waiting.request,
                    &CommandAnswer::not_taken(&NotTaken::NoAnswer),
                );
            }
            in_time
        });
        // Timeouts before new requests: their places are free for these.
        while let Ok(arrived) = self.requests.try_recv() {
            self.take(arrived);
        }
    }

    /// Responds to an executed order. Its memory is freed here.
    fn finish(&mut self, returned: &ReturnedOrder) {
        let ReturnedOrder { queued, outcome } = returned;
        let order = &queued.order;
        let Some(outcome) = outcome else {
            // The client has been answered by the timeout, or will be within a tenth of a second.
            let late = CommandAnswer::not_taken(&NotTaken::NoAnswer);
            return journal::log(&self.node, &self.audit, queued.by.as_ref(), order, &late);
        };
        let mut outcome = CommandAnswer::with_cargo(order, outcome, &queued.cargo);
        self.name_circle(order, &mut outcome);
        let is_it = |waiting: &Waiting| waiting.number == queued.number;
        // An order whose client was answered meanwhile is not in the list any more. It was executed nevertheless.
        if let Some(place) = self.waiting.iter().position(is_it) {
            let Waiting { request, .. } = self.waiting.remove(place);
            answer(&*request, &outcome);
        }
        // After the response: a log that is slow delays no client.
        journal::log(&self.node, &self.audit, queued.by.as_ref(), order, &outcome);
    }

    /// Adds the circle's text to a refusal: the cycle knows that there is a circle, but not the
    /// axes in it.
    fn name_circle(&self, order: &CommandOrder, answer: &mut CommandAnswer) {
        if let (CommandOrder::Slave(order), CommandVerdict::Refused { code, text, .. }) =
            (order, &mut answer.verdict)
            // The code in the form in which the response carries it.
            && *code == format!("{CIRCLE_CODE:#06x}")
            && let Some(circle) = self.circles.of(order.addressee.as_str())
        {
            text.push_str(": ");
            text.push_str(&circle);
        }
    }

    fn take(&mut self, arrived: ArrivedRequest) {
        let ArrivedRequest {
            arrival,
            request,
            by,
        } = arrived;
        let order = match CommandOrder::from_json(&request.payload()) {
            Ok(order) => order,
            Err(error) => {
                let refusal = CommandAnswer::malformed(&error);
                answer(&*request, &refusal);
                return self.audit.note(journal::unread(by.as_ref(), &refusal));
            }
        };
        // The number is used up only by an order that was pushed.
        let number = self.taken;
        // `waiting` may be full although the ring is not: the cycle has taken the orders, and not returned them yet.
        if self.waiting.len() < MAX_WAITING && !self.orders.is_full() {
            // Allocated here, since the cycle must not: points of a plate, or values that an order reads.
            let cargo = order.cargo();
            let queued = QueuedOrder {
                number,
                by,
                arrival,
                order,
                cargo,
            };
            let waiting = Waiting {
                number,
                arrival,
                request,
            };
            // There is room: no other thread pushes orders.
            if self.orders.push(queued).is_ok() {
                self.taken += 1;
                self.waiting.push(waiting);
            }
        } else {
            let refusal = CommandAnswer::not_taken(&NotTaken::Busy);
            answer(&*request, &refusal);
            journal::log(&self.node, &self.audit, by.as_ref(), &order, &refusal);
        }
    }
}
