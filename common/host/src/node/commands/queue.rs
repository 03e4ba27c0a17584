//! The cycle's end: takes orders, returns outcomes. Wait-free.

use std::thread::Thread;

use coaxle_clock::{Instant, Span};
use coaxle_node::command::{CommandOrder, CommandOutcome, OrderCargo};
use coaxle_node::keys::NodeName;
use coaxle_os::machine::Machine;
use rtrb::{Consumer, Producer};

/// Greatest age of an order that is still executed. The client gets the response that an older one
/// is not executed at that time, or a moment later.
// Shorter than the server's second: an order is never executed after its client heard that it was not.
const EXECUTE_WITHIN: Span = Span::from_millis(900);

/// An order on its way to the cycle, with all the memory that it needs there.
#[derive(Debug)]
pub(super) struct QueuedOrder {
    pub(super) number: u64,
    /// The operator, if known.
    pub(super) by: Option<NodeName>,
    pub(super) arrival: Instant<Machine>,
    pub(super) order: CommandOrder,
    pub(super) cargo: OrderCargo,
}

/// An order on its way back, whole, so that its memory is freed outside the cycle.
#[derive(Debug)]
pub(super) struct ReturnedOrder {
    pub(super) queued: QueuedOrder,
    /// Outcome; none if the order waited for too long and was not executed.
    pub(super) outcome: Option<CommandOutcome>,
}

/// The queue from which the cycle takes its orders.
pub(crate) struct OrderQueue {
    orders: Consumer<QueuedOrder>,
    outcomes: Producer<ReturnedOrder>,
    server: Option<Thread>,
}

impl OrderQueue {
    pub(super) const fn new(
        orders: Consumer<QueuedOrder>,
        outcomes: Producer<ReturnedOrder>,
    ) -> Self {
        Self {
            orders,
            outcomes,
            server: None,
        }
    }

    /// Sets the thread that is woken when there is an outcome.
    pub(crate) fn attach(&mut self, server: Thread) {
        self.server = Some(server);
    }

    /// Executes the orders that arrived until now, in a scan that began at `woke`. Orders that
    /// waited for too long go back unexecuted.
    pub(crate) fn execute_all(
        &mut self,
        woke: Instant<Machine>,
        mut execute: impl FnMut(&CommandOrder, &mut OrderCargo) -> CommandOutcome,
    ) {
        let mut any = false;
        // An order is executed only if there is room for its outcome.
        // Counted once: orders that arrive while these are executed wait for the next scan.
        for _ in 0..self.orders.slots().min(self.outcomes.slots()) {
            let Ok(mut queued) = self.orders.pop() else {
                break;
            };
            let in_time = woke - queued.arrival < EXECUTE_WITHIN;
            let outcome = in_time.then(|| execute(&queued.order, &mut queued.cargo));
            // `any` is set by orders that expired as well: their memory is freed by the server.
            any |= self
                .outcomes
                .push(ReturnedOrder { queued, outcome })
                .is_ok();
        }
        if any {
            self.wake();
        }
    }

    fn wake(&self) {
        if let Some(server) = &self.server {
            // A futex on Linux: `unpark` takes no lock.
            server.unpark();
        }
    }
}

impl Drop for OrderQueue {
    /// Wakes the server: no more outcomes follow. The ring shows it only once this value is gone, a
    /// moment later; the server's park has a timeout for that.
    fn drop(&mut self) {
        self.wake();
    }
}
