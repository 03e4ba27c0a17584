//! The far axis made local: the blocks that know the sender's clock, started by its first message.

use coaxle_clock::cycle::Turn;
use coaxle_clock::delay::{Answer, DelayOutput};
use coaxle_clock::observer::{ObserverOutput, ObserverParameters, ObserverState, PhaseObserver};
use coaxle_clock::time_sync::{TimeSyncParameters, WrongParameter};
use coaxle_clock::{CycleTime, Instant, Local, Seconds};
use coaxle_motion::remote::{AxisSync, AxisSyncOutput, AxisSyncParameters};
use coaxle_node::Sample;

use crate::config::{DelayConfig, Mode};
use crate::delay::Delay;

/// How the far clock is to be followed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FarClockSetup {
    pub(crate) cycle_time: CycleTime,
    pub(crate) mode: Mode,
    pub(crate) sync: AxisSyncParameters,
    pub(crate) observer: ObserverParameters,
    pub(crate) delay: DelayConfig,
    /// This run of the node.
    pub(crate) run: u64,
}

/// The far clock. Each frame says how long the sender's cycle is, so it starts with the first one.
#[derive(Debug)]
pub(crate) struct FarClock {
    setup: FarClockSetup,
    state: State,
}

#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one, and boxing it would allocate in the cycle"
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
    block: AxisSync,
    observed: Option<Observed>,
}

/// The far clock as the observer has it.
#[derive(Debug)]
struct Observed {
    observer: PhaseObserver,
    delay: Delay,
    /// The observer was sure of the far clock when it last heard of it.
    sure: bool,
}

/// The far axis in one cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Far {
    pub(crate) axis: AxisSyncOutput,
    pub(crate) observer: Option<ObserverOutput>,
    pub(crate) delay: Option<DelayOutput>,
}

impl FarClock {
    /// Wrong parameters are refused now, not when the first message comes.
    pub(crate) fn new(setup: FarClockSetup) -> Result<Self, WrongParameter> {
        let _ = AxisSync::start(setup.cycle_time.span(), setup.sync)?;
        let _ = PhaseObserver::new(setup.cycle_time, setup.observer)?;
        Ok(Self {
            setup,
            state: State::Waiting,
        })
    }

    /// A message that arrived at `at`.
    pub(crate) fn hear(&mut self, at: Instant<Local>, sample: &Sample) {
        let header = &sample.header;
        self.start_for(header.cycle_time);
        if let Some(observed) = self.observed() {
            let stamp = header.send_stamp;
            observed
                .observer
                .observe(header.epoch, header.count, at, stamp);
        }
    }

    /// An answer that arrived at `at`.
    pub(crate) fn hear_answer(&mut self, at: Instant<Local>, answer: &Answer) {
        if let Some(observed) = self.observed() {
            observed.delay.hear(at, answer);
        }
    }

    /// The number of the question to ask in the cycle that ideally began at `now`, if one is due.
    pub(crate) fn ask(&mut self, now: Instant<Local>) -> Option<u32> {
        self.observed()?.delay.ask(now)
    }

    const fn observed(&mut self) -> Option<&mut Observed> {
        match &mut self.state {
            State::Running(running) => running.observed.as_mut(),
            State::Waiting | State::Refused { .. } => None,
        }
    }

    /// One cycle, with the newest message in the input image; none when the cycle times do not
    /// fit.
    ///
    /// Every answer that is taken in is shown to `heard`, with its arrival.
    pub(crate) fn update(
        &mut self,
        sample: &Sample,
        turn: &Turn,
        heard: impl FnMut(Instant<Local>, &Answer),
    ) -> Option<Far> {
        let mode = self.setup.mode;
        let State::Running(running) = &mut self.state else {
            return None;
        };
        let index = sample.header.index;
        let Some(observed) = &mut running.observed else {
            let axis = running
                .block
                .update(index, &sample.axis, mode.into(), turn.elapsed);
            return Some(Far {
                axis,
                observer: None,
                delay: None,
            });
        };
        let now = turn.ideal_start;
        let (seen, correction) = observed.cycle(now, sample.header.count, heard);
        let axis = running
            .block
            .update_by_clock(index, &sample.axis, correction, turn.elapsed);
        Some(Far {
            axis,
            observer: Some(seen),
            delay: Some(observed.delay.output(now)),
        })
    }

    /// Whether the sender's cycle time was refused.
    pub(crate) const fn is_refused(&self) -> bool {
        matches!(self.state, State::Refused { .. })
    }

    /// The sender's cycle time, as its frames tell it.
    pub(crate) const fn data_cycle_time(&self) -> Option<CycleTime> {
        match &self.state {
            State::Waiting => None,
            State::Running(Running { data, .. }) | State::Refused { data } => Some(*data),
        }
    }

    fn start_for(&mut self, data: CycleTime) {
        if self.data_cycle_time() != Some(data) {
            self.state = match self.start(data) {
                Some(running) => State::Running(running),
                None => State::Refused { data },
            };
        }
    }

    /// A config that contradicts the frames is wrong.
    fn start(&self, data: CycleTime) -> Option<Running> {
        let configured = self.setup.sync.time_sync.data_cycle_time;
        if configured != Seconds::ZERO && configured.to_span() != data.span() {
            return None;
        }
        let parameters = AxisSyncParameters {
            time_sync: TimeSyncParameters {
                data_cycle_time: data.span().into(),
                ..self.setup.sync.time_sync
            },
            ..self.setup.sync
        };
        let observed = match self.setup.mode {
            Mode::Observer => Some(Observed {
                observer: PhaseObserver::new(data, self.setup.observer).ok()?,
                delay: Delay::new(self.setup.delay, self.setup.run),
                sure: false,
            }),
            _ => None,
        };
        Some(Running {
            data,
            block: AxisSync::start(self.setup.cycle_time.span(), parameters).ok()?,
            observed,
        })
    }
}

impl Observed {
    /// One cycle: what the observer says, and by how much the message number `count` is to be moved
    /// in time, once that is sure.
    fn cycle(
        &mut self,
        now: Instant<Local>,
        count: u64,
        heard: impl FnMut(Instant<Local>, &Answer),
    ) -> (ObserverOutput, Option<Seconds>) {
        self.delay.steer(&mut self.observer, now, heard);
        let seen = self.observer.cycle(now);
        self.sure = is_sure(seen.state, self.sure);
        let sent = self.observer.far_time_of(count);
        let correction = match (self.sure, seen.far_time, sent) {
            (true, Some(now), Some(sent)) => Some(now.since(sent)),
            _ => None,
        };
        (seen, correction)
    }
}

/// Holding over, or with more uncertainty, the far time goes on as it did before: leaving it would be a step.
const fn is_sure(state: ObserverState, before: bool) -> bool {
    match state {
        ObserverState::Synced => true,
        ObserverState::Unsure | ObserverState::Holdover => before,
        ObserverState::Startup | ObserverState::Locking | ObserverState::Lost => false,
    }
}
