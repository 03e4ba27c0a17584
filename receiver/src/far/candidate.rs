//! A node as source of the axes: its messages and its clock are evaluated while it is followed or
//! stands by.

use coaxle_axis::motion_plan::PlanFault;
use coaxle_clock::cycle::Tick;
use coaxle_clock::cycle_lock::FarPhase;
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::time_sync::WrongParameter;
use coaxle_clock::{CycleTime, Instant, Local, Seconds, Span};
use coaxle_node::{AxisSample, BeaconResponse, Frame, FrameHeader, PlannedPiece, Rejection};
use coaxle_remote::{AxisSyncParameters, FilterMode, NeededDelay};

use super::beacons::Beacons;
use super::clock::{Clock, ClockOutput, ClockSetup};
use super::clock_signals::show_observation;
use super::encoder::Encoder;
use super::frames::TakenFrame;
use super::inbox::Inbox;
use super::plans::Plans;
use super::take_over::{Presence, Standing};
use crate::arrivals::Arrivals;
use crate::config::FarConfig;
use crate::signals::FarNodeSignals;

/// A node that the axes can be read from.
#[derive(Debug)]
pub(crate) struct Candidate {
    pub(super) cycle_time: CycleTime,
    /// Number of the node among all received ones.
    pub(super) number: usize,
    pub(super) inbox: Inbox,
    pub(super) clock: Clock,
    presence: Presence,
    /// Configured timeout of its silence.
    configured_patience: Option<Span>,
    /// Newest frame used, by its run and count, and own cycles since.
    last: Option<(u64, u64)>,
    age_cycles: u32,
    /// True if its clock was known in the newest cycle.
    pub(super) synced: bool,
    /// Run of a second node with its name.
    rival: Option<u64>,
    /// Smoothing of its axes that are only measured, which continues on standby; none for those
    /// that the axes themselves have.
    encoders: Box<[Option<Box<Encoder>>]>,
    /// Presentation delay that its frames would need.
    pub(super) needed: Box<NeededDelay>,
    /// Age of its newest frame by its clock, at the ideal start of the newest cycle; none while that is not known.
    age: Option<Seconds>,
    /// Beacons, if it has a timing channel.
    beacons: Option<Box<Beacons>>,
    /// Plans of its axes, if they can be used.
    pub(super) plans: Option<Box<Plans>>,
    news: News,
}

/// Input of a cycle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct News {
    /// The input image; none before the first frame.
    pub(super) header: Option<FrameHeader>,
    /// Correction of its clock for the image; none if the cycle times do not fit.
    pub(super) following: Option<ClockOutput>,
    /// The clock was started, or restarted, for cycles of this length.
    pub(super) started: Option<CycleTime>,
    /// True if the image was renewed.
    pub(super) is_fresh: bool,
    /// True if it is the first of another run than the previous one.
    pub(super) is_new_run: bool,
}

/// Timeout without an age limit.
const PATIENCE: Span = Span::from_millis(100);
/// Lower limit of the timeout, in cycles of the node.
// Up to three lost frames in a row are no silence.
const LEAST_CYCLES: i64 = 4;

impl Candidate {
    pub(super) fn new(
        config: &FarConfig,
        cycle_time: CycleTime,
        number: usize,
        inbox: Inbox,
        setup: ClockSetup,
        encoders: Box<[Option<Box<Encoder>>]>,
    ) -> Result<Self, WrongParameter> {
        let configured = config.take_over_after_ms;
        Ok(Self {
            cycle_time,
            number,
            inbox,
            clock: Clock::new(setup)?,
            presence: Presence::default(),
            configured_patience: configured.map(|ms| Span::from_secs_f64(ms.get() * 1e-3)),
            last: None,
            age_cycles: 0,
            synced: false,
            rival: None,
            encoders,
            needed: Box::default(),
            age: None,
            beacons: None,
            plans: Plans::new(config).map(Box::new),
            news: News::default(),
        })
    }

    /// Adds a timing channel.
    pub(super) fn with_beacons(self, beacons: Option<Box<Beacons>>) -> Self {
        Self { beacons, ..self }
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

    /// Stores a piece of a plan that arrived at `at`.
    pub(crate) fn store_plan(&mut self, at: Instant<Local>, piece: &PlannedPiece) {
        if let Some(plans) = &mut self.plans {
            plans.store(at, piece);
        }
    }

    /// Counts a plan that was refused.
    pub(crate) const fn refuse_plan(&mut self, fault: PlanFault) {
        if let Some(plans) = &mut self.plans {
            plans.refuse(fault);
        }
    }

    /// Returns the number of the time request that is due, if any.
    pub(crate) fn ask(&mut self, tick: &Tick) -> Option<u32> {
        self.clock.request(tick.ideal_start)
    }

    /// Stores the response to a beacon that arrived at `at`.
    pub(crate) fn store_beacon(&mut self, at: Instant<Local>, response: &BeaconResponse) {
        if let Some(beacons) = &mut self.beacons {
            beacons.store(at, response);
        }
    }

    /// Counts a beacon that was refused.
    pub(crate) fn reject_beacon(&mut self) {
        if let Some(beacons) = &mut self.beacons {
            beacons.reject();
        }
    }

    /// Returns the number of the beacon that is due, if any: only to a node that has been received.
    pub(crate) fn due_beacon(&mut self, tick: &Tick) -> Option<u32> {
        self.news.header?;
        self.beacons.as_mut()?.due(tick.ideal_start)
    }

    /// Runs one cycle: its messages, its run, and the state of its clock.
    pub(super) fn cycle(&mut self, tick: &Tick, mut arrivals: Arrivals<'_>) {
        self.news = News::default();
        self.take_messages(tick, &mut arrivals);
        self.take_plans(tick);
        self.rival = self.inbox.rival(tick.ideal_start);
        let clock = &mut self.clock;
        if let Some(beacons) = &mut self.beacons {
            // Before the clock's cycle, which uses the exchanges.
            beacons.take(tick.ideal_start, |measured| clock.take_measured(&measured));
        }
        self.news.following = self.news.header.and_then(|header| {
            clock.cycle(&header, tick, |at, response| {
                arrivals.exchange(at, response);
            })
        });
        if let Some(following) = &mut self.news.following
            && following.enabled
            && self.inbox.is_pace_refused()
        {
            // A disabled clock passes everything through, and judges no pace.
            following.correction = following.correction.refused();
        }
        self.note_age(tick);
    }

    /// Takes the plans that have arrived, and compares them with the frames of this cycle.
    fn take_plans(&mut self, tick: &Tick) {
        let (header, inbox) = (self.news.header.as_ref(), &self.inbox);
        if let Some(plans) = &mut self.plans {
            plans.take(tick.ideal_start, header);
            for frame in inbox.taken_in() {
                if let Some(header) = header {
                    plans.check(&frame, header);
                }
            }
        }
    }

    /// Takes the age of the newest frame, by which a presentation delay would have to exceed none.
    fn note_age(&mut self, tick: &Tick) {
        if self.news.is_new_run {
            self.needed.clear();
        }
        let following = self.news.following.as_ref();
        let correction = following.map(|following| &following.correction);
        // The age of a node that is silent says nothing about its way, nor does one by a clock that is not known yet.
        let needs_no_sync = !self.clock.synchronises();
        let known = correction
            .filter(|correction| !correction.is_silent && (correction.synced || needs_no_sync));
        self.age = known.and_then(|correction| correction.time(correction.mode));
        if let Some(age) = self.age {
            let passed = self.cycle_time.span() * i64::from(tick.elapsed);
            self.needed.take(age.to_span(), passed);
        }
    }

    /// Cycle of the node in relation to the own one, in the newest cycle; none while its clock is not known.
    pub(super) fn phase(&self) -> Option<FarPhase> {
        let (age, header) = (self.age?, self.news.header?);
        FarPhase::of(self.clock.observation()?, age, header.cycle_time)
    }

    /// Takes the newest fresh frame; passes all messages to the clock.
    fn take_messages(&mut self, tick: &Tick, arrivals: &mut Arrivals<'_>) {
        let patience = self.patience();
        let Self {
            inbox,
            clock,
            presence,
            news,
            ..
        } = self;
        let image = inbox.image(tick.ideal_start, |at, header, begins| {
            // Recorded first and in any case: an estimator that runs over the record sees what this one saw.
            arrivals.message(at, header);
            if begins {
                clock.begin_run(header);
            }
            if clock.message(at, header) {
                news.started = Some(header.cycle_time);
            }
            // With cycle times that do not fit it counts as silent.
            if !clock.is_refused() {
                presence.heard(at, patience);
            }
        });
        let Some(image) = image else {
            return;
        };
        news.header = Some(image);
        let this = (inbox.run_of_image(), image.count);
        let before = self.last.replace(this);
        // Run and count together: the count of a restarted node may be the one of the last image.
        if before == Some(this) {
            self.age_cycles = self.age_cycles.saturating_add(tick.elapsed);
            return;
        }
        self.age_cycles = 0;
        news.is_fresh = true;
        news.is_new_run = before.is_some_and(|(run, _)| run != inbox.run_of_image());
    }

    /// Input of the newest cycle.
    pub(super) const fn news(&self) -> &News {
        &self.news
    }

    /// Axes of the frame that was new in the newest cycle.
    pub(super) fn fresh_axes(&self) -> &[Option<AxisSample>] {
        self.inbox.fresh_axes().unwrap_or_default()
    }

    /// Frames that the newest cycle took in, in any order.
    pub(super) fn frames(&self) -> impl Iterator<Item = TakenFrame<'_>> {
        self.inbox.taken_in()
    }

    /// Standing for the decision. `has_axes`: it has sent all that are needed.
    pub(super) fn standing(&self, has_axes: bool) -> Standing {
        Standing {
            presence: self.presence,
            patience: self.patience(),
            longest: self.longest_silence(),
            has_axes: has_axes && self.news.is_fresh && !self.has_error(),
            is_known: self.is_known(),
        }
    }

    /// True if it could take over with its next frame.
    pub(super) fn could_take_over(&self, now: Instant<Local>) -> bool {
        self.is_known() && self.presence.is_steady(now, self.patience())
    }

    /// True if the time that both nodes have in common contradicts what the ways between them leave open.
    pub(super) fn do_clocks_disagree(&self) -> bool {
        let observed = self.clock.observation();
        observed.is_some_and(|it| it.common_time.is_some_and(|it| it.is_contradicted()))
    }

    fn has_error(&self) -> bool {
        let following = self.news.following.as_ref();
        following.is_none_or(|following| following.correction.error.is_some())
    }

    /// True if its clock is known as well as its mode permits.
    fn is_known(&self) -> bool {
        self.news.following.is_some_and(|following| {
            let correction = &following.correction;
            let needs_no_clock = !following.enabled || !self.clock.synchronises();
            !self.has_error() && (needs_no_clock || correction.synced)
        })
    }

    /// Largest age of its messages.
    pub(super) fn age_limit(&self) -> Option<Span> {
        age_limit(self.clock.parameters(), self.clock.mode(), self.cycle_time)
    }

    /// Longest silence before its data are too old, with a margin.
    fn longest_silence(&self) -> Span {
        let limit = self.age_limit();
        let longest = limit.map_or(PATIENCE * 5, |limit| limit * 3 / 4);
        // A configured patience may exceed three quarters of the age limit.
        longest.max(self.patience())
    }

    /// Timeout of its silence.
    fn patience(&self) -> Span {
        let limit = self.age_limit();
        // Half of the age limit leaves the other half for the take-over before slaves lose their master.
        let by_limit = || limit.map_or(PATIENCE, |limit| limit / 2);
        let wished = self.configured_patience.unwrap_or_else(by_limit);
        let cycle = self.clock.data_cycle_time();
        let least = cycle.map_or(Span::ZERO, |cycle| cycle.span() * LEAST_CYCLES);
        wished.max(least)
    }

    /// Runs a cycle on standby: the smoothing of its axes continues.
    pub(super) fn stand_by(&mut self, elapsed: u32) {
        let Self {
            encoders,
            news,
            inbox,
            ..
        } = self;
        let (Some(header), Some(following)) = (&news.header, &news.following) else {
            return;
        };
        let samples = inbox.fresh_axes().unwrap_or_default();
        for (n, encoder) in encoders.iter_mut().enumerate() {
            let Some(encoder) = encoder else {
                continue;
            };
            if let Some(cycle) = news.started {
                encoder.restart(cycle);
            }
            if news.is_new_run {
                encoder.forget();
            }
            let sample = samples.get(n).copied().flatten();
            if let Some(sample) = sample.filter(|_| news.is_fresh) {
                encoder.take(&sample.set, header.count);
            }
            let correction = &following.correction;
            // By its own clock, in the mode that is in force, so that the exchange at a take-over continues the
            // motion.
            encoder.update(correction.time(correction.mode), elapsed);
        }
    }

    /// Smoothing of its axes, to be exchanged for that of another node.
    pub(super) fn encoders_mut(&mut self) -> &mut Box<[Option<Box<Encoder>>]> {
        &mut self.encoders
    }

    /// Own cycles since its newest frame.
    pub(super) const fn age_cycles(&self) -> u32 {
        self.age_cycles
    }

    /// Time since its newest frame.
    pub(super) fn silence(&self) -> Span {
        self.cycle_time.span() * i64::from(self.age_cycles)
    }

    /// True if a second node with its name is received.
    pub(super) const fn has_rival(&self) -> bool {
        self.rival.is_some()
    }

    /// Writes its signals.
    pub(super) fn show(&mut self, signals: &mut FarNodeSignals) {
        // A row that is reused would show values of a node that has none now.
        *signals = FarNodeSignals::default();
        self.synced = false;
        if let (Some(header), Some(following)) = (&self.news.header, &self.news.following) {
            signals.epoch = Some(header.epoch);
            signals.count = Some(header.count);
            signals.index = Some(header.index.0);
            signals.age_cycles = self.age_cycles;
            signals.present_after_us = header.present_after.map(|by| by.span().as_micros_f64());
            signals.frame_age_us = self.age.map(Seconds::as_micros);
            signals.needed_present_after_us = self.needed_delay().map(Span::as_micros_f64);
            following.show(signals);
            if let Some(observed) = self.clock.observation() {
                show_observation(observed, signals);
            }
            let offset = self.clock.parameters().time_sync.delay_time_offset;
            // A part of that time, and in force with it.
            signals.time_offset_us = signals.correction_us.map(|_| offset.as_micros());
            self.synced = signals.synced;
        }
        if let Some(plans) = &self.plans {
            plans.show(signals);
        }
        let cycle_time = self.clock.data_cycle_time();
        signals.cycle_time_us = cycle_time.map(|time| time.span().as_micros_f64());
        signals.enabled = self.clock.is_enabled();
        signals.mode = self.clock.mode();
        signals.rival_epoch = self.rival;
        self.inbox.show(signals);
        if let Some(beacons) = &self.beacons {
            beacons.show(signals);
        } else {
            // The observer states one in any case. Without a channel it means nothing.
            signals.timing_state = None;
        }
    }
}

/// Largest age of a message.
pub(super) fn age_limit(
    parameters: &AxisSyncParameters,
    mode: FilterMode,
    cycle_time: CycleTime,
) -> Option<Span> {
    let cycles = parameters.age_limit(mode, cycle_time.span())?;
    Some(cycle_time.span() * i64::from(cycles))
}
