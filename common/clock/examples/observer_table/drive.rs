//! Feeds a run to a follower, as a receiver would: once per cycle it takes what has arrived, then reads the far time.

use coaxle_clock::observer::ObserverOutput;

use crate::peers::Follower;
use crate::world::Run;

/// A receiver cycle.
pub(crate) struct Cycle {
    pub(crate) number: usize,
    /// Local time, s.
    pub(crate) now: f64,
    /// Far time, s. None while the follower knows nothing yet.
    pub(crate) far: Option<f64>,
    /// Output of the observer, which only that follower has.
    pub(crate) output: Option<ObserverOutput>,
}

pub(crate) fn drive(
    follower: &mut dyn Follower,
    run: &Run,
    cycles: usize,
    mut each: impl FnMut(&Cycle),
) {
    // In whole nanoseconds, as the schedule of a receiver has it.
    let cycle = (run.cycle() * 1e9) as i64;
    let mut messages = run.messages.iter().peekable();
    let mut exchanges = run.exchanges.iter().peekable();
    for number in 0..cycles {
        let now = number as i64 * cycle;
        while let Some(message) = messages.next_if(|message| message.arrived <= now) {
            follower.observe(message);
        }
        // After the messages: a response is measured against the line that they make.
        while let Some(exchange) = exchanges.next_if(|exchange| exchange.t4 <= now) {
            follower.exchange(exchange);
        }
        let far = follower.far(now);
        each(&Cycle {
            number,
            now: now as f64 * 1e-9,
            far,
            output: follower.output(),
        });
    }
}
