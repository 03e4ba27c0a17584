//! A far clock, started by the first message: each frame says how long the sender's cycle is.

use coaxle_clock::cycle::Tick;
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::far_clock::{FarClock, FarClockOutput};
use coaxle_clock::observer::ObserverParameters;
use coaxle_clock::time_sync::{TimeSyncParameters, TimeSyncState, WrongParameter};
use coaxle_clock::{CycleTime, Instant, Local, Seconds, Span};
use coaxle_node::FrameHeader;
use coaxle_remote::{AxisSyncParameters, FarCorrection, FarSync};

use super::micros;
use crate::config::{DelayConfig, FarConfig, Mode};
use crate::signals::FarNodeSignals;

/// How a far clock is to be followed.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClockSetup {
    cycle_time: CycleTime,
    mode: Mode,
    sync: AxisSyncParameters,
    observer: ObserverParameters,
    delay: DelayConfig,
    run: u64,
}

/// The far clock.
#[derive(Debug)]
pub(super) struct Clock {
    setup: ClockSetup,
    state: State,
}

#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there are few, and boxing it would allocate in the cycle"
)]
enum State {
    Waiting,
    Running(Running),
    /// The sender's cycle time fits neither the own one nor the config.
    Refused {
        data: CycleTime,
    },
}

#[derive(Debug)]
struct Running {
    data: CycleTime,
    sync: FarSync,
    /// None unless the mode is observer.
    observed: Option<FarClock>,
}

/// A far clock in one cycle.
pub(super) struct Following {
    pub(super) correction: FarCorrection,
    /// None unless the mode is observer.
    pub(super) observed: Option<FarClockOutput>,
}

impl ClockSetup {
    /// `run` is this run of the own node.
    pub(super) const fn of(config: &FarConfig, cycle_time: CycleTime, run: u64) -> Self {
        Self {
            cycle_time,
            mode: config.mode,
            sync: config.sync,
            observer: config.observer,
            delay: config.delay,
            run,
        }
    }
}

impl Clock {
    /// Wrong parameters are refused now, not when the first message comes.
    pub(super) fn new(setup: ClockSetup) -> Result<Self, WrongParameter> {
        let own = setup.cycle_time;
        let _ = FarSync::start(own.span(), &setup.sync)?;
        let _ = FarClock::new(own, setup.observer, setup.delay.into(), setup.run)?;
        Ok(Self {
            setup,
            state: State::Waiting,
        })
    }

    /// A message that arrived at `at`. Gives whether the clock was started by it, or started anew.
    pub(super) fn message(&mut self, at: Instant<Local>, header: &FrameHeader) -> bool {
        let started = self.start_for(header.cycle_time);
        if let Some(observed) = self.observed() {
            observed.message(header.epoch, header.count, at, header.send_stamp);
        }
        started
    }

    /// A response that arrived at `at`.
    pub(super) fn response(&mut self, at: Instant<Local>, response: &TimeResponse) {
        if let Some(observed) = self.observed() {
            observed.response(at, response);
        }
    }

    /// The number of the time request to send in the cycle that ideally began at `now`, if one is due.
    pub(super) fn request(&mut self, now: Instant<Local>) -> Option<u32> {
        self.observed()?.request(now)
    }

    const fn observed(&mut self) -> Option<&mut FarClock> {
        match &mut self.state {
            State::Running(running) => running.observed.as_mut(),
            State::Waiting | State::Refused { .. } => None,
        }
    }

    /// One cycle, with the newest frame in the input image; none when the cycle times do not fit.
    ///
    /// Every response that is taken in is shown to `used`, with its arrival.
    pub(super) fn cycle(
        &mut self,
        header: &FrameHeader,
        tick: &Tick,
        used: impl FnMut(Instant<Local>, &TimeResponse),
    ) -> Option<Following> {
        let State::Running(running) = &mut self.state else {
            return None;
        };
        let Running { sync, observed, .. } = running;
        let Some(observed) = observed else {
            let mode = self.setup.mode.into();
            return Some(Following {
                correction: sync.update(header.index, mode, tick.elapsed),
                observed: None,
            });
        };
        let output = observed.cycle(tick.ideal_start, used);
        let clock = observed.correction(header.count);
        Some(Following {
            correction: sync.update_by_clock(header.index, clock, tick.elapsed),
            observed: Some(output),
        })
    }

    /// Whether the sender's cycle time was refused.
    pub(super) const fn is_refused(&self) -> bool {
        matches!(self.state, State::Refused { .. })
    }

    /// The sender's cycle time, as its frames tell it.
    pub(super) const fn data_cycle_time(&self) -> Option<CycleTime> {
        match &self.state {
            State::Waiting => None,
            State::Running(Running { data, .. }) | State::Refused { data } => Some(*data),
        }
    }

    /// Own cycles after which data are too old; none where nothing watches it.
    pub(super) fn age_limit(&self) -> Option<u32> {
        match &self.state {
            State::Running(running) => running.sync.age_limit(),
            State::Waiting | State::Refused { .. } => None,
        }
    }

    fn start_for(&mut self, data: CycleTime) -> bool {
        let is_other = self.data_cycle_time() != Some(data);
        if is_other {
            self.state = match self.start(data) {
                Some(running) => State::Running(running),
                None => State::Refused { data },
            };
        }
        is_other
    }

    /// A config that contradicts the frames is wrong.
    fn start(&self, data: CycleTime) -> Option<Running> {
        let setup = &self.setup;
        let configured = setup.sync.time_sync.data_cycle_time;
        if configured != Seconds::ZERO && configured.to_span() != data.span() {
            return None;
        }
        let parameters = AxisSyncParameters {
            time_sync: TimeSyncParameters {
                data_cycle_time: data.span().into(),
                ..setup.sync.time_sync
            },
            ..setup.sync
        };
        let observed = match setup.mode {
            Mode::Observer => {
                Some(FarClock::new(data, setup.observer, setup.delay.into(), setup.run).ok()?)
            }
            _ => None,
        };
        Some(Running {
            data,
            sync: FarSync::start(setup.cycle_time.span(), &parameters).ok()?,
            observed,
        })
    }
}

impl Following {
    /// What signals say of it.
    pub(super) fn show(&self, signals: &mut FarNodeSignals) {
        let correction = &self.correction;
        let time_sync = &correction.time_sync;
        let diagnostic = &time_sync.diagnostic;
        signals.synced = correction.synced && correction.error.is_none();
        signals.error = correction.error.map_or(0, |error| error.code());
        signals.warning = correction.warning.map_or(0, |warning| warning.code());
        signals.beats = time_sync.beats;
        signals.drift_ppm = Some(diagnostic.drift_ppm);
        signals.correction_us = micros(correction.time(correction.mode));
        signals.time_sync_correction_us = micros(time_sync.correction_time);
        signals.time_mode_correction_us = micros(time_sync.time_mode_correction);
        signals.time_mode = time_sync.state == TimeSyncState::StartUp;
        signals.cycle_index_diff = diagnostic.cycle_index_diff;
        signals.total_equal_data = diagnostic.total_equal_data;
        signals.consecutive_equal_data = diagnostic.consecutive_equal_data;
        if let Some(observed) = &self.observed {
            show_observed(observed, signals);
        }
    }
}

fn show_observed(observed: &FarClockOutput, signals: &mut FarNodeSignals) {
    let FarClockOutput {
        observer, delay, ..
    } = observed;
    let seconds = |at: Instant<Local>| at.since_epoch().as_secs_f64();
    signals.drift_ppm = Some(observer.drift_ppm);
    signals.observer = Some(observer.state);
    signals.observer_line = Some(observer.line);
    signals.offset_sigma_us = Some(observer.offset_sigma.as_micros());
    signals.drift_sigma_ppm = Some(observer.drift_sigma_ppm);
    signals.slew_remaining_us = Some(observer.slew_remaining.as_micros());
    signals.normal_jitter_us = Some(observer.normal_jitter.as_micros());
    signals.exponential_jitter_us = Some(observer.exponential_jitter.as_micros());
    signals.random_walk_ppm = Some(observer.random_walk_ppm);
    signals.block_length = Some(observer.block_length);
    signals.shifts = observer.shifts;
    signals.last_shift_s = observer.last_shift.map(seconds);
    signals.relocks = observer.relocks;
    signals.last_relock_s = observer.last_relock.map(seconds);
    signals.delay = Some(delay.state);
    signals.delay_us = micros(delay.delay);
    signals.delay_uncertainty_us = micros(delay.uncertainty);
    signals.delay_jitter_us = micros(delay.jitter);
    signals.delay_age_s = delay.age.map(Span::as_secs_f64);
    signals.exchanges = delay.exchanges;
    signals.responses_refused = delay.refused;
}
