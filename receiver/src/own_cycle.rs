//! Schedule of the own cycle, which may be locked to that of a far node.

use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleLock, CycleTime, Instant, Local, Schedule, Seconds};

use crate::config::ReceiverConfig;
use crate::far::FarNode;
use crate::signals::NodeSignals;

/// Schedule of the own cycle.
#[derive(Debug)]
pub(crate) struct OwnCycle {
    schedule: Schedule,
    /// Lock, and the number of the far node.
    lock: Option<(usize, CycleLock)>,
}

impl OwnCycle {
    /// Creates the schedule of a receiver whose first cycle is due at `start`.
    pub(crate) fn new(config: &ReceiverConfig, start: Instant<Local>) -> Self {
        let (first, cycle_time) = (config.clock.first_count.get(), config.cycle_time_us.0);
        let lock = config.locked_to();
        Self {
            schedule: Schedule::counting_from(first, start, cycle_time),
            lock: lock.map(|to| (to.far, CycleLock::new(cycle_time, to.offset))),
        }
    }

    /// Nominal cycle time.
    pub(crate) const fn cycle_time(&self) -> CycleTime {
        self.schedule.cycle_time()
    }

    /// Start of cycle 0, if all cycles had been as long as the nominal one up to the newest.
    pub(crate) const fn start(&self) -> Instant<Local> {
        self.schedule.start()
    }

    /// True if that start moves.
    pub(crate) const fn is_locked(&self) -> bool {
        self.lock.is_some()
    }

    /// Ideal start of the next cycle.
    pub(crate) fn next_start(&self) -> Instant<Local> {
        self.schedule.next_start()
    }

    /// Cycles skipped so far.
    pub(crate) const fn overruns(&self) -> u64 {
        self.schedule.overruns()
    }

    /// Takes the cycle that is due.
    pub(crate) fn take(&mut self, now: Instant<Local>) -> Tick {
        self.schedule.take(now)
    }

    /// Ideal start of the cycle that would be taken at this instant.
    pub(crate) fn ideal_start(&self, now: Instant<Local>) -> Instant<Local> {
        // On a copy: the question alone must not count a cycle.
        let mut schedule = self.schedule;
        schedule.take(now).ideal_start
    }

    /// Moves the next cycle by the phase of the far one in the newest, which really began at `now`, if it is locked.
    pub(crate) fn follow(&mut self, tick: &Tick, now: Instant<Local>, far: &[FarNode]) {
        let Some((number, lock)) = &mut self.lock else {
            return;
        };
        let phase = far[*number].phase();
        let moved = lock.advance(phase.as_ref(), tick.elapsed);
        // A cycle that began nearly a whole one late leaves no time to move the next: it would be over. The phase shows what is missing.
        if self.schedule.next_start() + moved > now {
            self.schedule.shift(moved);
        }
    }

    /// Writes the signals of the lock.
    pub(crate) fn show(&self, signals: &mut NodeSignals) {
        if let Some((_, lock)) = &self.lock {
            signals.cycle_lock = Some(lock.state());
            signals.cycle_phase_us = lock.phase().map(Seconds::as_micros);
            signals.cycle_period_ppm = Some(lock.period_ppm());
        }
    }
}
