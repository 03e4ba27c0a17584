//! The machine's clock: reading it, and sleeping until a time.

use std::cell::Cell;
use std::time::SystemTime;

use coaxle_clock::{Domain, Instant, Local, Span};

use crate::{ClockPair, Os, System};

/// The operating system's monotonic clock: `CLOCK_MONOTONIC` of Linux.
///
/// All processes of one machine read the same clock, so their records can be compared.
pub enum Machine {}

impl Domain for Machine {
    const NAME: &'static str = "machine";
}

/// Returns the present time of the machine's clock.
#[must_use]
pub fn now() -> Instant<Machine> {
    Instant::from_nanos(Os::clock_ns())
}

/// Converts an instant to the clock of a node that keeps the machine's time. Only nodes of the
/// simulation, and those with injected clock faults, have another one.
#[must_use]
pub const fn local(at: Instant<Machine>) -> Instant<Local> {
    Instant::from_nanos(at.as_nanos())
}

/// Time of day of the machine, for certificates, and for the times of the rows of a recording. It may
/// jump.
#[must_use]
#[expect(
    clippy::disallowed_methods,
    reason = "certificates hold from one day to another, recordings are of a day; this crate reads the machine's clocks"
)]
pub fn wall_clock() -> SystemTime {
    SystemTime::now()
}

/// Returns the wall clock at time 0 of this machine's clock, ns since 1970: the offset of the rows of a
/// recording.
#[must_use]
pub fn wall_clock_offset_ns() -> i64 {
    let since_1970 = wall_clock().duration_since(SystemTime::UNIX_EPOCH);
    // 584 years of nanoseconds fit u64, half of them i64: enough until 2262.
    let wall = since_1970.unwrap_or_default().as_nanos() as i64;
    // Read directly after each other: the time between the two readings is in the offset.
    wall - now().as_nanos()
}

/// Returns the machine's clock and International Atomic Time (TAI) at one instant; none if the system does not know it.
#[must_use]
pub fn with_tai() -> Option<ClockPair> {
    // Known or not, once and for all.
    Os::tai_ns()?;
    Some(ClockPair::read(Os::clock_ns, || {
        Os::tai_ns().unwrap_or_default()
    }))
}

/// Returns the offset of TAI from UTC as the system has it, s: 0 if nobody has set it, 37 since 2017; none if the system does not
/// know TAI.
#[must_use]
pub fn tai_offset_s() -> Option<i64> {
    let tai = Os::tai_ns()?;
    let utc = wall_clock().duration_since(SystemTime::UNIX_EPOCH);
    let utc = utc.unwrap_or_default().as_nanos() as i64;
    // Read one after the other: nearest to whole seconds.
    Some((tai - utc + 500_000_000).div_euclid(1_000_000_000))
}

thread_local! {
    static CYCLE_START: Cell<Option<Instant<Machine>>> = const { Cell::new(None) };
}

/// Returns the ideal start of this thread's present cycle; on a thread that runs no node, now.
#[must_use]
pub fn cycle_start() -> Instant<Machine> {
    CYCLE_START.get().unwrap_or_else(now)
}

/// Sets the ideal start of this thread's present cycle.
pub fn begin_cycle(ideal_start: Instant<Machine>) {
    CYCLE_START.set(Some(ideal_start));
}

/// Sleeps until the clock reaches `deadline`, and returns at once if it has passed.
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
    // Wake-ups of the kernel are late by tens of microseconds (p50 44 under FIFO), which the spin absorbs.
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
