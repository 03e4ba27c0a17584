//! A node that is followed: which run of it, its clock, and its axes made local.

mod axis;
mod clock;
mod course;
mod encoder;
mod frames;
mod inbox;
mod orders;
mod run;

use coaxle_clock::cycle::Tick;
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::time_sync::{SyncError, WrongParameter};
use coaxle_clock::{CycleTime, Instant, Local, Seconds, Span};
use coaxle_node::config::LinkConfig;
use coaxle_node::{Frame, FrameHeader, Rejection};
use coaxle_remote::{AxisSyncParameters, FarCorrection};

use crate::arrivals::Arrivals;
use crate::config::{FarAxisConfig, FarConfig};
use crate::signals::{FarAxisSignals, FarNodeSignals};
use crate::slaves::Master;
use crate::snapshot::Health;
use axis::Axis;
use clock::{Clock, ClockSetup, Following};
use inbox::Inbox;
use orders::OrderCounters;

/// One far node.
#[derive(Debug)]
pub(crate) struct FarNode {
    cycle_time: CycleTime,
    inbox: Inbox,
    clock: Clock,
    axes: Box<[Axis]>,
    /// The newest frame that was used, by its run and count, and own cycles since.
    last: Option<(u64, u64)>,
    age_cycles: u32,
    /// Whether its clock was known in the newest cycle.
    synced: bool,
    /// The run of a second node of the same name.
    rival: Option<u64>,
    orders: OrderCounters,
}

/// What one cycle of a far node leaves for others, slices in the order of its axes.
pub(crate) struct FarOutputs<'a> {
    /// Its axes as masters of slaves.
    pub(crate) masters: &'a mut [Option<Master>],
    /// Its own signals.
    pub(crate) signals: &'a mut FarNodeSignals,
    /// Those of its axes.
    pub(crate) axes: &'a mut [FarAxisSignals],
}

/// A node that says nothing for so long is never reported healthy, whatever the age limit.
const SILENCE: Span = Span::from_secs(1);

/// Frames whose axes can wait for their cycle …
const FRAMES: usize = 8;
/// … and where injected faults hold them back.
const FRAMES_OF_FAULTS: usize = 128;

impl FarNode {
    /// `run` is this run of the own node.
    pub(crate) fn new(
        config: &FarConfig,
        cycle_time: CycleTime,
        run: u64,
    ) -> Result<Self, WrongParameter> {
        let frames = if config.faults == LinkConfig::default() {
            FRAMES
        } else {
            FRAMES_OF_FAULTS
        };
        let axis = |axis: &FarAxisConfig| Axis::new(cycle_time, &config.sync, axis.encoder);
        let setup = ClockSetup::of(config, cycle_time, run);
        Ok(Self {
            cycle_time,
            inbox: Inbox::new(
                age_limit(&config.sync, cycle_time),
                frames,
                config.axes.count(),
            ),
            clock: Clock::new(setup)?,
            axes: config.axes.iter().map(axis).collect::<Result<_, _>>()?,
            last: None,
            age_cycles: 0,
            synced: false,
            rival: None,
            orders: OrderCounters::default(),
        })
    }

    /// Stores a frame that arrived at `at`. The next cycle begins at `due`, or later.
    pub(crate) fn store(&mut self, at: Instant<Local>, frame: &Frame<'_>, due: Instant<Local>) {
        self.inbox.store(at, frame, due);
    }

    /// Counts a frame or a response that was refused.
    pub(crate) fn reject(&mut self, reason: Rejection) {
        self.inbox.reject(reason);
    }

    /// Stores a response that arrived at `at`.
    pub(crate) fn store_response(&mut self, at: Instant<Local>, response: &TimeResponse) {
        self.clock.response(at, response);
    }

    /// The number of the time request that is due, if one is.
    pub(crate) fn ask(&mut self, tick: &Tick) -> Option<u32> {
        self.clock.request(tick.ideal_start)
    }

    /// One cycle: which run, what its clock shows, and where its axes are. Gives what the receiver thinks
    /// of it.
    pub(crate) fn scan(
        &mut self,
        tick: &Tick,
        arrivals: &mut Arrivals<'_>,
        out: FarOutputs<'_>,
    ) -> Health {
        let image = self.take_messages(tick, arrivals);
        self.rival = self.inbox.rival(tick.ideal_start);
        let followed = image.and_then(|header| {
            let following = self.clock.cycle(&header, tick, |at, response| {
                arrivals.exchange(at, response);
            })?;
            Some((header, following))
        });
        let health = match &followed {
            None => {
                out.masters.fill(None);
                self.without_master(out.axes)
            }
            Some((header, following)) => {
                if following.is_mapped_anew {
                    self.axes.iter_mut().for_each(Axis::rejoin);
                }
                let correction = &following.correction;
                let error = self.correct_axes(header, correction, tick, out.masters, out.axes);
                self.health(correction, error)
            }
        };
        self.inbox.end_cycle(tick.ideal_start);
        self.show(
            image.as_ref(),
            followed.as_ref().map(|(_, f)| f),
            out.signals,
        );
        out.signals.health = health.name();
        health
    }

    /// The newest fresh frame; the clock hears of all.
    fn take_messages(&mut self, tick: &Tick, arrivals: &mut Arrivals<'_>) -> Option<FrameHeader> {
        let Self {
            inbox, clock, axes, ..
        } = self;
        let image = inbox.image(tick.ideal_start, |at, header, begins| {
            arrivals.message(at, header);
            if begins {
                clock.begin_run(header);
            }
            if clock.message(at, header) {
                (axes.iter_mut()).for_each(|axis| axis.restart(header.cycle_time));
            }
        })?;
        let this = (inbox.run_of_image(), image.count);
        let before = self.last.replace(this);
        if before == Some(this) {
            self.age_cycles = self.age_cycles.saturating_add(tick.elapsed);
            return Some(image);
        }
        self.age_cycles = 0;
        let is_new_run = before.is_some_and(|(run, _)| run != inbox.run_of_image());
        let samples = inbox.fresh_axes().unwrap_or_default();
        for (n, axis) in axes.iter_mut().enumerate() {
            if is_new_run {
                axis.forget();
            }
            axis.take(samples.get(n).copied().flatten(), image.count);
        }
        Some(image)
    }

    /// Every axis, moved in time by the same clock. Gives the first error.
    fn correct_axes(
        &mut self,
        header: &FrameHeader,
        correction: &FarCorrection,
        tick: &Tick,
        masters: &mut [Option<Master>],
        signals: &mut [FarAxisSignals],
    ) -> Option<SyncError> {
        let age_limit = self.clock.age_limit();
        let longest = (SILENCE.as_nanos() / self.cycle_time.span().as_nanos()) as u32;
        let mut first = None;
        for ((axis, master), signals) in self.axes.iter_mut().zip(masters).zip(signals) {
            let own;
            let (age, correction) = if axis.count() == header.count {
                (self.age_cycles, correction)
            } else {
                own = axis.catch_up(correction, header, tick.elapsed, age_limit);
                (axis.missing_cycles(), &own)
            };
            let is_lost = correction.is_silent || age > longest;
            *master = axis.cycle(header, correction, tick.elapsed, is_lost, signals);
            signals.age_cycles = age;
            if let Some(master) = master {
                master.is_sound &= age <= longest;
                let needs_no_clock = self.clock.is_enabled() && !self.clock.synchronises();
                let is_there = signals.synced || needs_no_clock;
                // A blend is a straight line between two modes: its velocity steps where it begins and ends.
                master.is_ready = master.is_sound && is_there && !axis.is_blending();
                first = first.or(axis.error());
            }
        }
        first
    }

    fn health(&self, correction: &FarCorrection, error_of_axis: Option<SyncError>) -> Health {
        if let Some(error) = correction.error.or(error_of_axis) {
            return Health::Error(error);
        }
        if self.silence() > SILENCE {
            return Health::MasterSilent;
        }
        if self.rival.is_some() {
            return Health::TwoSenders;
        }
        if !self.clock.is_enabled() {
            return Health::Disabled;
        }
        if self.clock.synchronises() && !correction.synced {
            return Health::StartingUp;
        }
        Health::Ok
    }

    fn without_master(&self, axes: &mut [FarAxisSignals]) -> Health {
        axes.fill(FarAxisSignals::default());
        if self.clock.is_refused() {
            Health::CycleTimesDoNotFit
        } else {
            Health::WaitingForMaster
        }
    }

    fn silence(&self) -> Span {
        self.cycle_time.span() * i64::from(self.age_cycles)
    }

    fn show(
        &mut self,
        image: Option<&FrameHeader>,
        following: Option<&Following>,
        signals: &mut FarNodeSignals,
    ) {
        *signals = FarNodeSignals::default();
        self.synced = false;
        if let (Some(header), Some(following)) = (image, following) {
            signals.epoch = Some(header.epoch);
            signals.count = Some(header.count);
            signals.index = Some(header.index.0);
            signals.age_cycles = self.age_cycles;
            following.show(signals);
            self.synced = signals.synced;
        }
        let cycle_time = self.clock.data_cycle_time();
        signals.cycle_time_us = cycle_time.map(|time| time.span().as_micros_f64());
        signals.enabled = self.clock.is_enabled();
        signals.mode = self.clock.mode().into();
        signals.rival_epoch = self.rival;
        self.orders.show(signals);
        self.inbox.show(signals);
    }

    /// The far node's cycle time that the clock was started for.
    pub(crate) const fn data_cycle_time(&self) -> Option<CycleTime> {
        self.clock.data_cycle_time()
    }
}

/// How old a message may be.
fn age_limit(parameters: &AxisSyncParameters, cycle_time: CycleTime) -> Option<Span> {
    match parameters.time_sync.age_of_data_limit {
        0 => None,
        cycles => Some(cycle_time.span() * i64::from(cycles)),
    }
}

/// As signals show it.
pub(super) fn micros(seconds: Option<Seconds>) -> Option<f64> {
    seconds.map(Seconds::as_micros)
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::AxisSample;

    #[test]
    fn a_far_axis_takes_less_than_a_kilobyte() {
        let kept = FRAMES * size_of::<Option<AxisSample>>();
        let shown = size_of::<FarAxisSignals>() + size_of::<Option<Master>>();
        let bytes = size_of::<Axis>() + kept + shown;
        assert!(bytes <= 1024, "{bytes}");
    }
}
