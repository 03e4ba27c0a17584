//! The machine's clock: what it reads, and sleeping until it reads something.

use std::cell::Cell;
use std::time::SystemTime;

use coaxle_clock::{Domain, Instant, Local, Span};

use crate::{Os, System};

/// The operating system's monotonic clock: `CLOCK_MONOTONIC` of Linux.
///
/// All processes of one machine read the same one, so their records can be laid side by side.
pub enum Machine {}

impl Domain for Machine {
    const NAME: &'static str = "machine";
}

/// What the machine's clock reads now.
#[must_use]
pub fn now() -> Instant<Machine> {
    Instant::from_nanos(Os::clock_ns())
}

/// The same instant in the clock of a node that keeps the machine's time: nodes of the simulation alone, and those with faults of a
/// clock, have another.
#[must_use]
pub const fn local(at: Instant<Machine>) -> Instant<Local> {
    Instant::from_nanos(at.as_nanos())
}

/// What the machine takes the time of day for. For certificates, and for where the rows of a recording lie in the day: it
/// may jump.
#[must_use]
#[expect(
    clippy::disallowed_methods,
    reason = "certificates hold from one day to another, recordings are of a day; this crate reads the machine's clocks"
)]
pub fn wall_clock() -> SystemTime {
    SystemTime::now()
}

/// What the wall clock shows when this machine's clock shows 0, ns since 1970: where the rows of a recording lie in the day.
#[must_use]
pub fn wall_clock_offset_ns() -> i64 {
    let since_1970 = wall_clock().duration_since(SystemTime::UNIX_EPOCH);
    let wall = since_1970.unwrap_or_default().as_nanos() as i64;
    wall - now().as_nanos()
}

thread_local! {
    static CYCLE_START: Cell<Option<Instant<Machine>>> = const { Cell::new(None) };
}

/// The ideal start of the cycle that this thread is in; on a thread that runs no node, now.
#[must_use]
pub fn cycle_start() -> Instant<Machine> {
    CYCLE_START.get().unwrap_or_else(now)
}

/// From now on this thread is in the cycle that ideally started then.
pub fn begin_cycle(ideal_start: Instant<Machine>) {
    CYCLE_START.set(Some(ideal_start));
}

/// Sleeps until the clock reads `deadline`, and returns at once if it has passed.
///
/// The deadline is absolute, so neither an interrupting signal nor the time between reading the
/// clock and going to sleep adds to it.
pub fn sleep_until(deadline: Instant<Machine>) {
    Os::sleep_until_ns(deadline.as_nanos());
}

/// Sleeps like [`sleep_until`], but spends the last `spin` before the deadline awake: at the price
/// of a busy processor the deadline is met to a fraction of a microsecond.
pub fn sleep_then_spin_until(deadline: Instant<Machine>, spin: Span) {
    sleep_until(deadline - spin);
    while now() < deadline {
        std::hint::spin_loop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_never_wakes_early() {
        for spin in [Span::ZERO, Span::from_micros(60)] {
            let deadline = now() + Span::from_millis(3);
            sleep_then_spin_until(deadline, spin);
            assert!(now() >= deadline);
        }
    }

    #[test]
    fn a_deadline_in_the_past_or_before_the_epoch_is_no_sleep() {
        sleep_until(now() - Span::from_secs(1));
        sleep_until(Instant::from_nanos(-5));
    }
}
