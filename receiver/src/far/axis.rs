//! One far axis: its newest values, moved in time by what the clock of its node says.

mod shown;

use coaxle_axis::TravelDirection;
use coaxle_clock::time_sync::{SyncError, WrongParameter};
use coaxle_clock::{CycleTime, Instant, Remote, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::{AxisSample, FrameHeader};
use coaxle_remote::{
    CheckedParameters, Continuity, ContinuityState, ExtrapolateDiagnostic, ExtrapolateParameters,
    FarAxis, FarAxisOutput, FarCorrection, FilterState, Reach,
};

use self::shown::far_time;
use super::course::{Advance, FarTimeCourse};
use super::encoder::Encoder;
use super::limited::Limited;
use super::seen::{LARGEST_BEAT, SeenMotion};
use super::steps::{Blending, Course, StepWatch, shows_what_comes};
use super::turns::{Turns, Wraps};
use crate::config::{FarAxisConfig, FarConfig, FarLimits, Positions};
use crate::signals::FarAxisSignals;
use crate::slaves::Master;

/// A far axis.
#[derive(Debug)]
pub(super) struct Axis {
    block: FarAxis,
    /// Of an axis whose positions are within the turn.
    turns: Option<Box<Turns>>,
    /// Of one whose positions are not, and yet wrap.
    wraps: Wraps,
    /// Of an axis that is only measured.
    encoder: Option<Box<Encoder>>,
    /// Nothing of it, or of its node, came for too long in the newest cycle.
    is_lost: bool,
    continuity: Continuity,
    /// Of an axis that has limits of its own.
    limited: Option<Box<Limited>>,
    /// The far time that it stands for.
    course: FarTimeCourse,
    /// What it was seen to do, and what no mode explains.
    seen: SeenMotion,
    steps: StepWatch,
    blending: Blending,
    /// The observer led in the newest cycle.
    leads: bool,
    /// More of its cycles are missing before the newest than a step of a mode without a clock can be.
    has_gap: bool,
    cycle_time: Span,
    /// None until it comes.
    sample: Option<AxisSample>,
    /// The sender's cycle count that it came with.
    count: u64,
    /// Own cycles since it was to come and did not.
    missing_cycles: u32,
    missing: u64,
    error: Option<SyncError>,
}

/// How the set values of an axis go on in a cycle.
#[derive(Clone, Copy, Debug)]
struct Going {
    /// Own cycles since the one before.
    elapsed: u32,
    /// By their positions, u/s.
    velocity: f64,
    /// Cycles of the sender without news, in a mode that shows what comes.
    silence: u64,
    /// Nobody knows where they are.
    is_lost: bool,
}

/// A cycle of an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisScan {
    /// Own cycles since the one before.
    pub(super) elapsed: u32,
    /// Own cycles without news of it.
    pub(super) age: u32,
    /// Without news for too long.
    pub(super) is_lost: bool,
    /// The standard deviation of the far time, s, where it is known.
    pub(super) time_sigma: Option<Seconds>,
}

impl Axis {
    pub(super) fn new(
        cycle_time: CycleTime,
        far: &FarConfig,
        config: &FarAxisConfig,
    ) -> Result<Self, WrongParameter> {
        let parameters = &far.sync;
        let modulo = config.modulo.or(far.modulo);
        let turns = modulo.filter(|_| config.position == Positions::WithinTurn);
        let limited = |limits: FarLimits| Box::new(Limited::new(*limits.get(), cycle_time));
        let encoder = config
            .encoder
            .map(|encoder| Encoder::new(cycle_time, encoder).map(Box::new));
        Ok(Self {
            turns: turns.map(|modulo| Box::new(Turns::new(modulo))),
            wraps: Wraps::default(),
            encoder: encoder.transpose()?,
            is_lost: false,
            block: FarAxis::start(cycle_time.span(), parameters)?,
            continuity: Continuity::new(cycle_time.span(), parameters.extrapolate.blending_time),
            limited: config.limits.map(limited),
            course: FarTimeCourse::default(),
            seen: SeenMotion::default(),
            steps: StepWatch::default(),
            blending: blending(&parameters.extrapolate, cycle_time.span()),
            leads: false,
            has_gap: false,
            cycle_time: cycle_time.span(),
            sample: None,
            count: 0,
            missing_cycles: 0,
            missing: 0,
            error: None,
        })
    }

    /// Its node's clock was started anew, for cycles of this length.
    pub(super) fn restart(&mut self, data: CycleTime) {
        self.block.restart();
        if let Some(encoder) = &mut self.encoder {
            encoder.restart(data);
        }
        self.rejoin();
    }

    /// What its node's clock says next has nothing to do with what it said: the axis is brought there.
    pub(super) const fn rejoin(&mut self) {
        self.continuity.rejoin();
        self.course.forget();
        self.steps.forget();
    }

    /// Another run of its node: what it was before says nothing of where it is now.
    pub(super) fn forget(&mut self) {
        self.sample = None;
        self.begin_run();
        self.begin_anew();
        self.rejoin();
    }

    /// Another node takes over: the axis is brought to where that has it. `encoder` is what has smoothed it of that
    /// one's increments, and then what has smoothed those of the one before.
    pub(super) fn take_over(&mut self, encoder: &mut Option<Box<Encoder>>) {
        self.sample = None;
        self.begin_run();
        self.block.begin_anew();
        std::mem::swap(&mut self.encoder, encoder);
        self.rejoin();
    }

    /// Whether it has come at all.
    pub(super) const fn has_come(&self) -> bool {
        self.sample.is_some()
    }

    fn begin_run(&mut self) {
        if let Some(turns) = &mut self.turns {
            turns.begin_run();
        }
    }

    fn begin_anew(&mut self) {
        self.block.begin_anew();
        if let Some(encoder) = &mut self.encoder {
            encoder.forget();
        }
    }

    /// Its node's clock starts anew by an order; the set values go on from where they are.
    pub(super) const fn re_initialise(&mut self) {
        self.block.re_initialise();
        self.course.forget();
    }

    /// The set values go on from where they are, whatever an order changes.
    pub(super) const fn carry_on(&mut self) {
        self.block.carry_on();
        self.course.forget();
    }

    /// Changes the parameters; the set values go on from where they are.
    pub(super) fn set_parameters(&mut self, parameters: &CheckedParameters) {
        self.block.set_parameters(parameters);
        self.blending = blending(parameters.extrapolate(), self.cycle_time);
        self.course.forget();
    }

    /// What the newest frame, with this header, says of it.
    pub(super) fn take(&mut self, sample: Option<AxisSample>, header: &FrameHeader) {
        let count = header.count;
        if let Some(mut sample) = sample {
            let has_come = self.sample.is_some();
            let missed = count.saturating_sub(self.count) * u64::from(has_come);
            let passed = header.cycle_time.as_secs_f64() * missed as f64;
            if let Some(turns) = &mut self.turns {
                sample.set = turns.unwrapped(&sample.set, passed);
            }
            if let Some(encoder) = &mut self.encoder {
                encoder.take(&sample.set, count);
            }
            let before = self.sample.as_ref().map(|before| &before.set);
            let neighbour = before.map(|before| (before, passed, missed));
            self.seen.take(&sample.set, neighbour);
            self.has_gap = before.is_some() && missed > LARGEST_BEAT;
            if let Some(before) = before.filter(|_| !self.has_gap) {
                self.wraps.take(before, &sample.set, passed);
            }
            self.sample = Some(sample);
            self.count = count;
            self.missing_cycles = 0;
        } else {
            self.missing += 1;
        }
    }

    /// The sender's cycle count that it came with last.
    pub(super) const fn count(&self) -> u64 {
        self.count
    }

    /// Own cycles since it was to come and did not.
    pub(super) const fn missing_cycles(&self) -> u32 {
        self.missing_cycles
    }

    /// What the clock says to an axis that was missing in the newest frame.
    pub(super) fn catch_up(
        &mut self,
        correction: &FarCorrection,
        header: &FrameHeader,
        elapsed: u32,
        age_limit: Option<u32>,
    ) -> FarCorrection {
        self.missing_cycles = self.missing_cycles.saturating_add(elapsed);
        let behind = header.count.wrapping_sub(self.count) as f64;
        let older = correction.for_older(Seconds(behind * header.cycle_time.as_secs_f64()));
        match age_limit {
            Some(limit) if self.missing_cycles > limit => older.for_silent(),
            _ => older,
        }
    }

    /// One cycle; none as long as it has not come.
    pub(super) fn cycle(
        &mut self,
        header: &FrameHeader,
        correction: &FarCorrection,
        scan: AxisScan,
        signals: &mut FarAxisSignals,
    ) -> Option<Master> {
        let AxisScan {
            elapsed, is_lost, ..
        } = scan;
        if self.is_lost && !is_lost {
            self.begin_anew();
        }
        self.is_lost = is_lost;
        let has_gap = std::mem::take(&mut self.has_gap) && shows_what_comes(correction.mode);
        if has_gap {
            self.begin_anew();
            self.rejoin();
        }
        let Some(sample) = self.sample else {
            *signals = FarAxisSignals {
                missing: self.missing,
                ..FarAxisSignals::default()
            };
            return None;
        };
        if correction.mode == FilterState::Observer && !self.leads && !self.follows() {
            // It is brought back anyway, along a curve: a blend would be a straight line on top of that.
            self.begin_anew();
            self.rejoin();
        }
        let mut moved = self.block.update(&sample.set, correction, elapsed);
        self.condition(&sample, &mut moved, elapsed);
        self.leads = moved.state == FilterState::Observer;
        let passed = self.cycle_time * i64::from(elapsed);
        self.seen.pass(passed.as_secs_f64());
        self.continuity.set_reach(self.reach(&moved.set));
        let far_time = far_time(header, self.count, &moved);
        let known = far_time.filter(|_| !is_lost);
        let way = self.way_without_step(&sample.set, &moved, known, passed);
        let shows = shows_what_comes(moved.state) && self.encoder.is_none();
        let silence = cycles_of_silence(header, self.cycle_time, scan.age);
        let going = Going {
            elapsed,
            velocity: if elapsed == 0 {
                0.0
            } else {
                way / passed.as_secs_f64()
            },
            silence: if shows { silence } else { 0 },
            is_lost,
        };
        let is_known = self.has_settled();
        let set = self.carried_on(&moved, is_known, &going);
        moved.set = set.unwrap_or(moved.set);
        moved.synced &= is_known && self.follows();
        self.error = moved.error;
        *signals = self.show(&sample, &moved, far_time);
        signals.prediction_sigma = self.prediction_sigma(&moved, scan.time_sigma);
        set?;
        let error = moved.error.map_or(0, |error| error.code().into());
        let error_code = if error == 0 { sample.error_code } else { error };
        Some(Master {
            set: moved.set,
            travel: self.travel(),
            is_sound: error_code == 0,
            is_ready: false,
            error_code: error,
        })
    }

    /// How far the set values went, u: nowhere in a step that neither their mode nor the master explains, from which the axis is
    /// brought back.
    fn way_without_step(
        &mut self,
        received: &Kinematics,
        moved: &FarAxisOutput,
        known: Option<Instant<Remote>>,
        passed: Span,
    ) -> f64 {
        let advance = self.course.advance(moved.state, known, passed);
        let before = self.steps.position();
        if !self.is_step(received, moved, advance, passed) {
            return before.map_or(0.0, |before| moved.set.position - before);
        }
        if self.block.is_blending() {
            // On top of the way back, it would be a straight line.
            self.block.begin_anew();
        }
        self.continuity.rejoin();
        0.0
    }

    /// The set values without steps and within limits; none before any are known.
    fn carried_on(
        &mut self,
        moved: &FarAxisOutput,
        is_known: bool,
        going: &Going,
    ) -> Option<Kinematics> {
        self.continuity
            .show_beats(moved.state == FilterState::Bypass);
        // Between two beats it stands, and on the whole goes as its master does. On its way back it is braked as soon as it is no
        // beat: relative to a master that stands and jumps, it came to twice its velocity.
        let is_silent = going.silence > LARGEST_BEAT && !self.follows();
        let set = match is_known && !going.is_lost && !is_silent {
            true => Some(self.continuity.follow(&moved.set, going.elapsed)),
            false => self.continuity.brake(going.elapsed),
        };
        // One that was never known stands where it was received, unless that is noise.
        let mut set = set.or(is_known.then_some(moved.set))?;
        if going.silence > 1 && self.continuity.state() == ContinuityState::Following {
            // Its positions stand: so do velocity and acceleration.
            set.velocity = going.velocity;
            set.acceleration = 0.0;
        }
        Some(match &mut self.limited {
            Some(limited) => limited.keep(&set, going.elapsed),
            None => set,
        })
    }

    /// Whether its set values do what neither their mode nor its master explains.
    fn is_step(
        &mut self,
        received: &Kinematics,
        moved: &FarAxisOutput,
        advance: Advance,
        passed: Span,
    ) -> bool {
        let far = match advance {
            Advance::By(far) => Some(far),
            Advance::Jump | Advance::Unknown => None,
        };
        let course = Course {
            mode: moved.state,
            is_blending: self.block.is_blending(),
            far,
            received: received.position,
            passed: passed.as_secs_f64(),
            cycle_time: self.cycle_time.as_secs_f64(),
            age: moved.correction_time.map_or(0.0, |Seconds(age)| age),
        };
        let is_step = (self.steps).is_step(&moved.set, &course, &self.blending, &self.seen);
        // Increments have jumps of their own, and what smooths them leaves none.
        advance == Advance::Jump || (is_step && self.encoder.is_none())
    }

    /// What the master was seen to do: increments say it once they are smoothed.
    fn reach(&self, set: &Kinematics) -> Reach {
        if self.encoder.is_none() {
            return self.seen.reach();
        }
        let Reach {
            velocity,
            acceleration,
        } = self.continuity.reach();
        Reach {
            velocity: velocity.max(set.velocity.abs()),
            acceleration: acceleration.max(set.acceleration.abs()),
        }
    }

    /// How far the set values may be from the master, while it moves as it was seen to: by the time, and by what
    /// extrapolation does not know yet.
    fn prediction_sigma(&self, moved: &FarAxisOutput, time: Option<Seconds>) -> Option<f64> {
        let is_by_clock = moved.state == FilterState::Observer && self.follows();
        let Seconds(time) = time.filter(|_| is_by_clock && self.encoder.is_none())?;
        let Seconds(age) = moved.correction_time?;
        // In the time that it may be off, it is accelerated too.
        let velocity = moved.set.velocity.abs() + moved.set.acceleration.abs() * time;
        Some(time * velocity + self.seen.prediction_error(age))
    }

    /// Set values of an axis that is only measured come from its increments, moved by the same correction.
    fn condition(&mut self, sample: &AxisSample, moved: &mut FarAxisOutput, elapsed: u32) {
        let Some(encoder) = &mut self.encoder else {
            return;
        };
        encoder.update(moved.correction_time, elapsed);
        if let Some(set) = encoder.set() {
            moved.set = set;
            moved.diagnostic = ExtrapolateDiagnostic {
                position_diff: sample.set.position - set.position,
                velocity_diff: sample.set.velocity - set.velocity,
            };
        }
    }

    /// Whether its increments say where it is.
    fn has_settled(&self) -> bool {
        (self.encoder.as_ref()).is_none_or(|encoder| encoder.set().is_some())
    }

    /// Where its increments say that it goes, as long as it goes where they say.
    fn travel(&self) -> Option<TravelDirection> {
        let encoder = self.encoder.as_ref()?;
        encoder.travel().filter(|_| self.follows())
    }

    /// What it does; one that its own limits keep away from where it should be is brought there.
    fn state(&self) -> ContinuityState {
        let is_tracking = (self.limited.as_ref()).is_none_or(|limited| limited.is_tracking());
        match self.continuity.state() {
            ContinuityState::Following if !is_tracking => ContinuityState::Rejoining,
            state => state,
        }
    }

    fn follows(&self) -> bool {
        self.state() == ContinuityState::Following
    }

    /// A change of mode is being blended over.
    pub(super) fn is_blending(&self) -> bool {
        self.block.is_blending()
    }

    /// Its error in the newest cycle, its clock's included.
    pub(super) const fn error(&self) -> Option<SyncError> {
        self.error
    }
}

fn blending(parameters: &ExtrapolateParameters, cycle_time: Span) -> Blending {
    Blending {
        time: parameters.blending_time.0,
        filter_time: parameters.t1_factor_pos * cycle_time.as_secs_f64(),
    }
}

/// The whole cycles of the sender since the newest frame.
fn cycles_of_silence(header: &FrameHeader, cycle_time: Span, age: u32) -> u64 {
    let in_cycle = header.cycle_time.span().as_nanos() / cycle_time.as_nanos().max(1);
    u64::from(age) / in_cycle.max(1) as u64
}
