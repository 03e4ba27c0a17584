//! The cycle's end: takes orders, gives outcomes. Wait-free.

use std::thread::Thread;

use coaxle_clock::{Instant, Span};
use coaxle_node::command::{CommandOrder, CommandOutcome, OrderCargo};
use coaxle_os::machine::Machine;
use rtrb::{Consumer, Producer};

/// An order that is older is not executed: who sent it is told at that time, or a moment later, that
/// it will not be.
const EXECUTE_WITHIN: Span = Span::from_millis(900);

/// An order on its way to the cycle, with all the memory that it needs there.
#[derive(Debug)]
pub(super) struct QueuedOrder {
    pub(super) number: u64,
    pub(super) arrival: Instant<Machine>,
    pub(super) order: CommandOrder,
    pub(super) cargo: OrderCargo,
}

/// What became of one, on its way back: whole, so that whatever there is to free is freed outside the cycle.
#[derive(Debug)]
pub(super) struct ReturnedOrder {
    pub(super) queued: QueuedOrder,
    /// None if it has waited for too long, and was not executed.
    pub(super) outcome: Option<CommandOutcome>,
}

/// Where the cycle finds its orders.
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

    /// From now on this thread is woken when there is an outcome.
    pub(crate) fn attach(&mut self, server: Thread) {
        self.server = Some(server);
    }

    /// Has the orders that came until now executed, in a scan that began at `woke`. Those that
    /// have waited for too long go back as they came.
    pub(crate) fn execute_all(
        &mut self,
        woke: Instant<Machine>,
        mut execute: impl FnMut(&CommandOrder, &mut OrderCargo) -> CommandOutcome,
    ) {
        let mut any = false;
        // An order is executed only if there is room to say so.
        for _ in 0..self.orders.slots().min(self.outcomes.slots()) {
            let Ok(mut queued) = self.orders.pop() else {
                break;
            };
            let in_time = woke - queued.arrival < EXECUTE_WITHIN;
            let outcome = in_time.then(|| execute(&queued.order, &mut queued.cargo));
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
            server.unpark();
        }
    }
}

impl Drop for OrderQueue {
    /// The server must learn that no more outcomes will come. The ring shows it only once this value
    /// is gone, a moment later; the server's park has a timeout for that.
    fn drop(&mut self) {
        self.wake();
    }
}
