//! The cycle's end: takes orders, gives outcomes. Wait-free.

use std::thread::Thread;

use coaxle_clock::Instant;
use coaxle_node::command::{CommandOrder, CommandOutcome};
use rtrb::{Consumer, Producer};

use super::{Done, EXECUTE_WITHIN, Ticket};
use crate::machine::Machine;

/// Where the cycle finds its orders.
pub(crate) struct Desk {
    orders: Consumer<Ticket>,
    outcomes: Producer<Done>,
    clerk: Option<Thread>,
}

impl Desk {
    pub(super) const fn new(orders: Consumer<Ticket>, outcomes: Producer<Done>) -> Self {
        Self {
            orders,
            outcomes,
            clerk: None,
        }
    }

    /// From now on this thread is woken when there is an outcome.
    pub(crate) fn attach(&mut self, clerk: Thread) {
        self.clerk = Some(clerk);
    }

    /// Has the orders that came until now executed, in a scan that began at `woke`. Those that
    /// have waited for too long are thrown away.
    pub(crate) fn serve(
        &mut self,
        woke: Instant<Machine>,
        mut execute: impl FnMut(&CommandOrder) -> CommandOutcome,
    ) {
        let mut any = false;
        // An order is executed only if there is room to say so.
        for _ in 0..self.orders.slots().min(self.outcomes.slots()) {
            let Ok(ticket) = self.orders.pop() else {
                break;
            };
            if woke - ticket.arrival >= EXECUTE_WITHIN {
                continue;
            }
            let outcome = execute(&ticket.order);
            let number = ticket.number;
            any |= self.outcomes.push(Done { number, outcome }).is_ok();
        }
        if any {
            self.wake();
        }
    }

    fn wake(&self) {
        if let Some(clerk) = &self.clerk {
            clerk.unpark();
        }
    }
}

impl Drop for Desk {
    /// The clerk must learn that no more outcomes will come. The ring shows it only once this value
    /// is gone, a moment later; the clerk's park has a timeout for that.
    fn drop(&mut self) {
        self.wake();
    }
}
