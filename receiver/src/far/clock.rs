//! A far clock, started by the first message: each frame states the length of the sender's cycle.

use coaxle_clock::cycle::Tick;
use coaxle_clock::delay::{Asymmetry, TimeResponse};
use coaxle_clock::far_clock::{DelaySource, FarClock, FarClockOutput};
use coaxle_clock::observer::ObserverParameters;
use coaxle_clock::time_sync::{TimeSyncParameters, WrongParameter};
use coaxle_clock::{CycleTime, Instant, Local, Seconds};
use coaxle_node::FrameHeader;
use coaxle_remote::{AxisSyncParameters, CheckedParameters, FarCorrection, FarSync, FilterMode};

use super::beacons::BeaconMeasurement;
use crate::config::FarConfig;

/// Settings for following a far clock.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClockSetup {
    cycle_time: CycleTime,
    mode: FilterMode,
    sync: AxisSyncParameters,
    observer: ObserverParameters,
    delay: DelaySource,
    asymmetry: Option<Asymmetry>,
    run: u64,
}

/// The far clock.
#[derive(Debug)]
pub(super) struct Clock {
    setup: ClockSetup,
    enabled: bool,
    /// Epoch of the run that is followed, and of the previous one: messages of that one are taken
    /// for stragglers.
    epoch: Option<u64>,
    epoch_before: Option<u64>,
    state: FarClockState,
}

#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there are few, and boxing it would allocate in the cycle"
)]
enum FarClockState {
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
    /// Observer; none until observer mode. It continues in other modes, to be ready when the mode
    /// returns.
    observed: Option<FarClock>,
}

/// A far clock in one cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClockOutput {
    pub(super) correction: FarCorrection,
    pub(super) enabled: bool,
    /// True if the correction is unrelated to that of the previous cycle.
    pub(super) is_remapped: bool,
}

impl ClockSetup {
    /// `run` is this run of the own node.
    pub(super) fn of(config: &FarConfig, cycle_time: CycleTime, run: u64) -> Self {
        Self {
            cycle_time,
            mode: config.mode,
            sync: config.sync,
            observer: config.observer,
            delay: config.delay,
            asymmetry: config.asymmetry.map(Into::into),
            run,
        }
    }
}

impl Clock {
    /// Creates the clock; wrong parameters are refused now, not at the first message.
    pub(super) fn new(setup: ClockSetup) -> Result<Self, WrongParameter> {
        let own = setup.cycle_time;
        // Both are created for their checks only: the sender's cycle time is not known yet.
        let _ = FarSync::start(own.span(), &setup.sync)?;
        let _ = FarClock::new(own, setup.observer, setup.delay, setup.run)?;
        Ok(Self {
            setup,
            enabled: true,
            epoch: None,
            epoch_before: None,
            state: FarClockState::Waiting,
        })
    }

    /// Begins another run of the node, with this message. The epoch distinguishes its counts from
    /// those of the previous run; if it is unchanged, or that of a run that returns, all learned
    /// values are void.
    pub(super) fn begin_run(&mut self, header: &FrameHeader) {
        // A new epoch separates its counts from the earlier ones by itself.
        let is_known = [self.epoch, self.epoch_before].contains(&Some(header.epoch));
        if let FarClockState::Running(running) = &self.state
            && is_known
            && running.data == header.cycle_time
        {
            self.start_with(header.cycle_time);
        }
        self.epoch_before = self.epoch.replace(header.epoch);
    }

    /// Takes a message that arrived at `at`. Returns true if it started or restarted the clock.
    pub(super) fn message(&mut self, at: Instant<Local>, header: &FrameHeader) -> bool {
        // Before the observer takes the message, so that the first one of a clock is not lost.
        let started = self.start_for(header.cycle_time);
        if let Some(observed) = self.observed() {
            observed.message(header.epoch, header.count, at, header.send_stamp);
        }
        started
    }

    /// Takes a response that arrived at `at`.
    pub(super) fn response(&mut self, at: Instant<Local>, response: &TimeResponse) {
        if let Some(observed) = self.observed() {
            observed.response(at, response);
        }
    }

    /// Takes what a response of the timing channel has brought.
    pub(super) fn take_measured(&mut self, measured: &BeaconMeasurement) {
        let Some(observed) = self.observed() else {
            return;
        };
        match *measured {
            BeaconMeasurement::Exchange(at, exchange) => observed.timing_exchange(at, &exchange),
            BeaconMeasurement::CommonTime { here, own, far } => {
                observed.common_time(here, own, far)
            }
        }
    }

    /// Returns the number of the time request to send in the cycle that ideally began at `now`, if
    /// one is due.
    pub(super) fn request(&mut self, now: Instant<Local>) -> Option<u32> {
        self.observed()?.request(now)
    }

    /// The observer, if it runs and is enabled: only then it receives and sends.
    const fn observed(&mut self) -> Option<&mut FarClock> {
        match &mut self.state {
            FarClockState::Running(running) if self.enabled => running.observed.as_mut(),
            FarClockState::Running(_) | FarClockState::Waiting | FarClockState::Refused { .. } => {
                None
            }
        }
    }

    /// Runs one cycle, with the newest frame in the input image; none if the cycle times do not fit.
    ///
    /// Passes every accepted response to `used`, with its arrival.
    pub(super) fn cycle(
        &mut self,
        header: &FrameHeader,
        tick: &Tick,
        used: impl FnMut(Instant<Local>, &TimeResponse),
    ) -> Option<ClockOutput> {
        // Before the state: a disabled clock passes axes through even if the cycle times do not fit.
        if !self.enabled {
            return Some(ClockOutput {
                correction: FarCorrection::disabled(),
                enabled: false,
                is_remapped: false,
            });
        }
        let FarClockState::Running(Running { sync, observed, .. }) = &mut self.state else {
            return None;
        };
        // In every mode, so that its line is there when the mode returns to it.
        let output = (observed.as_mut()).map(|clock| clock.cycle(tick.ideal_start, used));
        let is_remapped = output.is_some_and(FarClockOutput::is_mapped_anew);
        let (index, elapsed) = (header.index, tick.elapsed);
        let correction = match (self.setup.mode, observed) {
            (FilterMode::Observer, Some(clock)) => {
                sync.update_by_clock(index, clock.correction(header.count), elapsed)
            }
            (mode, _) => sync.update(index, mode, elapsed),
        };
        // In other modes the remapped observer moves no axis.
        let by_observer = self.setup.mode == FilterMode::Observer;
        Some(ClockOutput {
            correction,
            enabled: true,
            is_remapped: by_observer && is_remapped,
        })
    }

    /// Output of its observer in the newest cycle; none without one.
    pub(super) fn observation(&self) -> Option<&FarClockOutput> {
        match &self.state {
            FarClockState::Running(running) if self.enabled => running.observed.as_ref()?.newest(),
            FarClockState::Running(_) | FarClockState::Waiting | FarClockState::Refused { .. } => {
                None
            }
        }
    }

    /// Standard deviation of the far time, s; none without an observer.
    pub(super) fn time_sigma(&self) -> Option<Seconds> {
        let observed = self.observation()?;
        let delay = observed.delay.sigma.unwrap_or(Seconds::ZERO);
        let offset = observed.observer.offset_sigma;
        // Independent errors add by their squares.
        Some(Seconds(libm::hypot(offset.0, delay.0)))
    }

    /// True if it is enabled.
    pub(super) const fn is_enabled(&self) -> bool {
        self.enabled
    }

    /// Mode in force while enabled.
    pub(super) const fn mode(&self) -> FilterMode {
        self.setup.mode
    }

    /// True if it can synchronise with these parameters.
    pub(super) const fn synchronises(&self) -> bool {
        self.setup.mode.synchronises(&self.setup.sync)
    }

    /// Parameters in force.
    pub(super) const fn parameters(&self) -> &AxisSyncParameters {
        &self.setup.sync
    }

    /// Source of the delay.
    pub(super) const fn delay(&self) -> DelaySource {
        self.setup.delay
    }

    /// Checks parameters against the cycle times that are known.
    pub(super) fn check(
        &self,
        parameters: &AxisSyncParameters,
    ) -> Result<CheckedParameters, WrongParameter> {
        let task_cycle_time = self.setup.cycle_time.span();
        let FarClockState::Running(Running { data, .. }) = &self.state else {
            return parameters.checked(task_cycle_time);
        };
        // Refused here, with the field. Accepted, it would stop the clock at its next message.
        if contradicts(parameters, *data) {
            return Err(WrongParameter {
                parameter: "data-cycle-time-s",
                received: parameters.time_sync.data_cycle_time.0,
                expected: "0, or the cycle time that the node's frames say",
            });
        }
        // The limits of some parameters depend on the ratio of both cycle times.
        for_data(parameters, *data).checked(task_cycle_time)
    }

    /// Passes the axes through as received from now on.
    pub(super) fn disable(&mut self) {
        self.enabled = false;
    }

    /// Restarts, enabled.
    pub(super) fn re_initialise(&mut self) {
        self.enabled = true;
        if let Some(data) = self.data_cycle_time() {
            self.start_with(data);
        }
    }

    /// Changes the method of calculating the set values. All learned values are kept.
    pub(super) fn set_mode(&mut self, mode: FilterMode) {
        self.setup.mode = mode;
        let setup = &self.setup;
        if let FarClockState::Running(running) = &mut self.state
            && mode == FilterMode::Observer
            && running.observed.is_none()
        {
            running.observed = setup.observer(running.data);
        }
    }

    /// Changes the parameters to these, valid as `checked`.
    pub(super) fn set_parameters(
        &mut self,
        parameters: &AxisSyncParameters,
        checked: &CheckedParameters,
    ) {
        self.setup.sync = *parameters;
        match &mut self.state {
            FarClockState::Running(running) => running.sync.set_parameters(checked),
            // The new parameters may fit.
            FarClockState::Refused { .. } => self.state = FarClockState::Waiting,
            FarClockState::Waiting => {}
        }
    }

    /// Changes the source of the delay; the resulting change is slewed.
    pub(super) fn set_delay(&mut self, delay: DelaySource) {
        self.setup.delay = delay;
        if let FarClockState::Running(Running { observed, .. }) = &mut self.state
            && let Some(observed) = observed
        {
            observed.set_delay(delay);
        }
    }

    /// True if the sender's cycle time was refused.
    pub(super) const fn is_refused(&self) -> bool {
        matches!(self.state, FarClockState::Refused { .. })
    }

    /// The sender's cycle time, as in its frames.
    pub(super) const fn data_cycle_time(&self) -> Option<CycleTime> {
        match &self.state {
            FarClockState::Waiting => None,
            FarClockState::Running(Running { data, .. }) | FarClockState::Refused { data } => {
                Some(*data)
            }
        }
    }

    /// Own cycles after which data are too old; none if they are not monitored.
    pub(super) fn age_limit(&self) -> Option<u32> {
        match &self.state {
            FarClockState::Running(running) if self.enabled => {
                running.sync.age_limit(self.setup.mode)
            }
            FarClockState::Running(_) | FarClockState::Waiting | FarClockState::Refused { .. } => {
                None
            }
        }
    }

    fn start_for(&mut self, data: CycleTime) -> bool {
        let is_other = self.data_cycle_time() != Some(data);
        if is_other {
            self.start_with(data);
        }
        is_other
    }

    fn start_with(&mut self, data: CycleTime) {
        self.state = match self.start(data) {
            Some(running) => FarClockState::Running(running),
            None => FarClockState::Refused { data },
        };
    }

    /// A config that contradicts the frames is wrong.
    fn start(&self, data: CycleTime) -> Option<Running> {
        let setup = &self.setup;
        if contradicts(&setup.sync, data) {
            return None;
        }
        let parameters = for_data(&setup.sync, data);
        Some(Running {
            data,
            sync: FarSync::start(setup.cycle_time.span(), &parameters).ok()?,
            observed: match setup.mode {
                FilterMode::Observer => Some(setup.observer(data)?),
                // Without observer mode the node neither sends time requests nor pays for the filters.
                _ => None,
            },
        })
    }
}

impl ClockSetup {
    /// Creates a phase observer; its parameters were checked at the start.
    fn observer(&self, data: CycleTime) -> Option<FarClock> {
        let mut clock = FarClock::new(data, self.observer, self.delay, self.run).ok()?;
        clock.state_asymmetry(self.asymmetry);
        Some(clock)
    }
}

/// True if they state another cycle time of the sender than its frames.
fn contradicts(parameters: &AxisSyncParameters, data: CycleTime) -> bool {
    let configured = parameters.time_sync.data_cycle_time;
    // 0 is the default: as the frames say.
    configured != Seconds::ZERO && configured.to_span() != data.span()
}

/// The parameters with the cycle time of the frames.
fn for_data(parameters: &AxisSyncParameters, data: CycleTime) -> AxisSyncParameters {
    AxisSyncParameters {
        time_sync: TimeSyncParameters {
            data_cycle_time: data.span().into(),
            ..parameters.time_sync
        },
        ..*parameters
    }
}
