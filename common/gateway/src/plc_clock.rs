//! The clock of the PLC as observed by the gateway: starts of its cycles, and its time for responses.
//!
//! A gateway reads a PLC somewhat later than its cycle begins, by a varying delay. Its own [`FarClock`]
//! finds the line on which the PLC's cycles lie, and the send stamp of each frame is relative to that
//! line: the jitter of reading stays here. The constant part of the reading delay counts as part of the
//! PLC.

use coaxle_clock::cycle::Tick;
use coaxle_clock::far_clock::DelaySource;
use coaxle_clock::observer::ObserverParameters;
use coaxle_clock::{CycleTime, FarClock, Instant, Local, Span};
use coaxle_node::{Outgoing, TimeRequest, TimeServer, TimeServerCounters};

/// Follows the clock of one run of a PLC, and responds to requests about it.
#[derive(Clone, Debug)]
pub struct PlcClock {
    cycle_time: CycleTime,
    sender: u32,
    /// Epoch of run 0; the others follow it.
    epoch: u64,
    run: u64,
    clock: FarClock,
    server: TimeServer,
    /// Counters of the previous runs.
    counted: TimeServerCounters,
    /// The line in the newest cycle.
    line: Option<ClockLine>,
    drift_ppm: f64,
    /// Cycle start of the newest responses.
    answered_in: Instant<Local>,
}

/// Ideal start `start` of the PLC's cycle `count`, and rate of its clock, `rate` times the own one's.
#[derive(Clone, Copy, Debug)]
struct ClockLine {
    count: u64,
    start: Instant<Local>,
    rate: f64,
}

impl PlcClock {
    /// Makes the clock of a PLC with this cycle time, published by node `sender`; its first run has the
    /// epoch `epoch`.
    #[must_use]
    pub fn new(sender: u32, epoch: u64, cycle_time: CycleTime) -> Self {
        Self {
            cycle_time,
            sender,
            epoch,
            run: 0,
            clock: far_clock(cycle_time, epoch),
            server: TimeServer::new(sender, epoch, Instant::EPOCH, cycle_time),
            counted: TimeServerCounters::default(),
            line: None,
            drift_ppm: 0.0,
            answered_in: Instant::EPOCH,
        }
    }

    /// Begins a new run of the PLC: all knowledge of its clock is discarded.
    pub fn begin(&mut self, run: u64) {
        let past = self.server.counters();
        // The server of the new run counts from 0, and the signals go on.
        self.counted.answered += past.answered;
        self.counted.dropped += past.dropped;
        self.run = run;
        let epoch = self.epoch();
        self.clock = far_clock(self.cycle_time, epoch);
        self.server = TimeServer::new(self.sender, epoch, Instant::EPOCH, self.cycle_time);
        self.line = None;
    }

    /// Returns the epoch of the run.
    #[must_use]
    pub const fn epoch(&self) -> u64 {
        // Wrapping, as an epoch is random: each run of the PLC has another one.
        self.epoch.wrapping_add(self.run)
    }

    /// Takes the arrival of the axes of cycle `count` at `at`.
    pub fn observe(&mut self, count: u64, at: Instant<Local>) {
        // No send stamp: the reading delay is unknown.
        self.clock.message(self.epoch(), count, at, None);
    }

    /// Runs the own cycle that ideally begins at `now`, with all samples up to then; the newest of the
    /// run is of cycle `newest`.
    pub fn cycle(&mut self, now: Instant<Local>, newest: Option<u64>) {
        let output = self.clock.cycle(now, |_, _| {});
        self.drift_ppm = output.observer.drift_ppm;
        // Seconds of the PLC per second of the gateway.
        let rate = 1.0 + self.drift_ppm * 1e-6;
        self.line = newest.and_then(|count| {
            // The correction is a time of the PLC's clock since the start of its cycle: divided by the rate it is local.
            let since = self.clock.correction(count)?.0 / rate;
            let start = now - Span::from_secs_f64(since);
            Some(ClockLine { count, start, rate })
        });
    }

    /// Returns the ideal start of the cycle `count` of the PLC; none as long as the clock is not known.
    #[must_use]
    pub fn start_of(&self, count: u64) -> Option<Instant<Local>> {
        let line = self.line?;
        // As signed: a cycle before that of the line lies before it.
        let cycles = count.wrapping_sub(line.count) as i64 as f64;
        let later = cycles * self.cycle_time.as_secs_f64() / line.rate;
        Some(line.start + Span::from_secs_f64(later))
    }

    /// Returns the drift of its clock against the clock of the gateway, ppm; none as long as that is not
    /// known.
    #[must_use]
    pub fn drift_ppm(&self) -> Option<f64> {
        self.line.map(|_| self.drift_ppm)
    }

    /// Takes a time request. As long as the clock is not known, there is no response.
    pub fn receive_request(&mut self, at: Instant<Local>, request: &TimeRequest) {
        // Without a known clock any response would be wrong. The requester asks again.
        if let Some(at) = self.time_at(at) {
            self.server.receive(at, request);
        }
    }

    /// Responds to the requests received before `now`, in the cycle of the newest frame.
    pub fn respond(&mut self, now: Instant<Local>) {
        let (Some(line), Some(time)) = (self.line, self.time_at(now)) else {
            return;
        };
        self.answered_in = line.start;
        let tick = Tick {
            count: line.count,
            ideal_start: self.time_of_cycle(line.count),
            elapsed: 1,
        };
        self.server.respond(&tick, time);
    }

    /// Returns the responses, once.
    pub fn transmit(&mut self) -> Option<Outgoing<'_>> {
        let ideal_start = self.answered_in;
        let outgoing = self.server.transmit()?;
        Some(Outgoing {
            ideal_start,
            ..outgoing
        })
    }

    /// Counters of the requests.
    #[must_use]
    pub fn counters(&self) -> TimeServerCounters {
        let now = self.server.counters();
        TimeServerCounters {
            answered: self.counted.answered + now.answered,
            dropped: self.counted.dropped + now.dropped,
        }
    }

    /// Returns the time of the PLC's clock at a local instant, since the ideal start of its cycle 0.
    fn time_at(&self, at: Instant<Local>) -> Option<Instant<Local>> {
        let line = self.line?;
        // Local time since the line, in seconds of the PLC.
        let passed = (at - line.start).as_secs_f64() * line.rate;
        Some(self.time_of_cycle(line.count) + Span::from_secs_f64(passed))
    }

    /// Returns the time of the PLC's clock at the ideal start of a cycle.
    fn time_of_cycle(&self, count: u64) -> Instant<Local> {
        Instant::EPOCH + self.cycle_time.span() * count as i64
    }
}

fn far_clock(cycle_time: CycleTime, run: u64) -> FarClock {
    FarClock::new(
        cycle_time,
        ObserverParameters::default(),
        // A PLC answers no time requests: the delay of reading stays in the constant part.
        DelaySource::Off,
        run,
    )
    .expect("the default parameters are in their ranges")
}
