//! A far axis: its newest values, moved in time by the clock of its node.

mod planned;
mod presented;
mod received;
mod restarts;
mod shown;

use coaxle_axis::TravelDirection;
use coaxle_clock::time_sync::{SyncError, WrongParameter};
use coaxle_clock::{CycleTime, Instant, Remote, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::{AxisSample, FrameHeader};
use coaxle_remote::{
    CheckedParameters, Continuity, ContinuityState, ExtrapolateDiagnostic, ExtrapolateParameters,
    FarAxis, FarAxisOutput, FarCorrection, FilterState, MasterCycle, PlannedAhead, ReceivedMotion,
};

use self::planned::{PlanUse, known};
use self::presented::Presented;
use self::shown::far_time;
use super::course::{Advance, FarTimeCourse};
use super::encoder::Encoder;
use super::limited::Limited;
use super::seen::{LARGEST_BEAT, ObservedMotion};
use super::steps::{Blending, FarCycle, StepWatch, shows_what_comes};
use super::unwrapping::{Unwrapping, Wraps};
use crate::config::{FarAxisConfig, FarConfig, FarLimits, Positions, Present};
use crate::signals::FarAxisSignals;
use crate::slaves::Master;

/// A far axis.
#[derive(Debug)]
pub(super) struct Axis {
    block: FarAxis,
    /// Unwrapping of positions within a modulo period.
    turns: Option<Box<Unwrapping>>,
    /// Unconfigured wraps of continuous positions.
    wraps: Wraps,
    /// Conditioning of an axis that is only measured.
    encoder: Option<Box<Encoder>>,
    /// Frames, if they may be shown later: not those of an axis that is only measured, or shown now on purpose.
    presented: Option<Box<Presented>>,
    plan: PlanUse,
    /// True if the axis or its node was silent for too long in the newest cycle.
    is_lost: bool,
    continuity: Continuity,
    /// Limits of its own, if it has any.
    limited: Option<Box<Limited>>,
    /// Course of the far time of its set values.
    course: FarTimeCourse,
    /// Observed motion, and steps that no mode explains.
    seen: ObservedMotion,
    steps: StepWatch,
    blending: Blending,
    /// True if the observer led in the newest cycle.
    leads: bool,
    /// True if more of its cycles are missing before the newest than a step of a mode without a
    /// clock can be.
    has_gap: bool,
    cycle_time: Span,
    /// Newest sample; none until the first.
    sample: Option<AxisSample>,
    /// The sender's cycle count of that sample.
    count: u64,
    /// Own cycles for which it has been missing from the frames.
    missing_cycles: u32,
    missing: u64,
    error: Option<SyncError>,
}

/// Continuation of an axis's set values in a cycle.
#[derive(Clone, Copy, Debug)]
struct Continuation {
    /// Own cycles since the previous one.
    elapsed: u32,
    /// Velocity by their positions, u/s.
    velocity: f64,
    /// Cycles of the sender without new data, in a mode that shows values as received.
    silence: u64,
    /// The newest frame, in such a mode.
    newest: Option<ReceivedMotion>,
    /// True if their position is unknown.
    is_lost: bool,
}

/// A cycle of an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisScan<'a> {
    /// Own cycles since the previous one.
    pub(super) elapsed: u32,
    /// Own cycles without new data of it.
    pub(super) age: u32,
    /// True if without new data for too long.
    pub(super) is_lost: bool,
    /// Hold-back of the slaves, in the far clock's time.
    pub(super) held: Seconds,
    /// The standard deviation of the far time, s, if known.
    pub(super) time_sigma: Option<Seconds>,
    /// The motion that its node has promised, if it is to be used.
    pub(super) planned: Option<PlannedAhead<'a>>,
}

impl Axis {
    pub(super) fn new(
        cycle_time: CycleTime,
        far: &FarConfig,
        config: &FarAxisConfig,
    ) -> Result<Self, WrongParameter> {
        let parameters = &far.sync;
        let modulo = config.modulo.or(far.modulo);
        // Continuous positions count through: their period matters to displays and commands only.
        let turns = modulo.filter(|_| config.position == Positions::WithinTurn);
        let limited = |limits: FarLimits| Box::new(Limited::new(*limits.get(), cycle_time));
        let encoder = config
            .encoder
            .map(|encoder| Encoder::new(cycle_time, encoder).map(Box::new));
        Ok(Self {
            turns: turns.map(|modulo| Box::new(Unwrapping::new(modulo))),
            wraps: Wraps::default(),
            encoder: encoder.transpose()?,
            presented: (far.present == Present::Auto && config.encoder.is_none())
                .then(|| Box::new(Presented::new(cycle_time))),
            plan: PlanUse::default(),
            is_lost: false,
            block: FarAxis::start(cycle_time.span(), parameters)?,
            continuity: Continuity::new(cycle_time.span(), parameters.extrapolate.blending_time),
            limited: config.limits.map(limited),
            course: FarTimeCourse::default(),
            seen: ObservedMotion::default(),
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

    /// True if it has been received.
    pub(super) const fn has_come(&self) -> bool {
        self.sample.is_some()
    }

    /// Changes the parameters; the set values continue from their current state.
    pub(super) fn set_parameters(&mut self, parameters: &CheckedParameters) {
        self.block.set_parameters(parameters);
        self.blending = blending(parameters.extrapolate(), self.cycle_time);
        self.course.forget();
    }

    /// The sender's cycle count of its last sample.
    pub(super) const fn count(&self) -> u64 {
        self.count
    }

    /// Own cycles for which it has been missing from the frames.
    pub(super) const fn missing_cycles(&self) -> u32 {
        self.missing_cycles
    }

    /// Runs one cycle; none before the first sample.
    pub(super) fn cycle(
        &mut self,
        header: &FrameHeader,
        correction: &FarCorrection,
        scan: AxisScan<'_>,
        signals: &mut FarAxisSignals,
    ) -> Option<Master> {
        let AxisScan {
            elapsed, is_lost, ..
        } = scan;
        // The filters of the block hold values from before the loss.
        if self.is_lost && !is_lost {
            self.begin_anew();
        }
        self.is_lost = is_lost;
        // Modes with a clock extrapolate over a gap. These show all of it in one cycle.
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
            // The axis is brought back anyway, along a curve: a blend would add a straight line to that.
            self.begin_anew();
            self.rejoin();
        }
        self.follow_presentation(header, correction, &scan);
        let age = correction
            .time(correction.mode)
            .map_or(0.0, |Seconds(age)| age);
        let credible = self.seen.credible(&sample.set, age);
        let known = known(self.presented.as_deref(), &scan);
        let mut moved = (self.block).update(&credible, correction, known, elapsed);
        if let Some(presented) = &mut self.presented {
            let is_by_clock = moved.correction_time.is_some();
            let is_predicted = is_by_clock && !moved.is_interpolated && !moved.is_planned;
            presented.note(moved.is_interpolated, is_predicted, elapsed);
        }
        self.note_plan(&moved, elapsed);
        self.condition(&sample, &mut moved, elapsed);
        self.leads = moved.state == FilterState::Observer;
        let passed = self.cycle_time * i64::from(elapsed);
        self.seen.pass(passed.as_secs_f64());
        if self.encoder.is_some() {
            // Differences of whole increments look like accelerations that no axis has.
            self.seen.take_smoothed(&moved.set);
        }
        let far_time = far_time(header, self.count, &moved);
        // The way of a lost axis is braked by its own plan, which follows no far time.
        let far = far_time.filter(|_| !is_lost);
        let (way, mut moved) = self.without_step(&credible, moved, correction, far, &scan);
        let shows = shows_what_comes(moved.state) && self.encoder.is_none();
        let silence = cycles_of_silence(header, self.cycle_time, scan.age);
        let continuation = Continuation {
            elapsed,
            // A scan without time passed has no quotient.
            velocity: if elapsed == 0 {
                0.0
            } else {
                way / passed.as_secs_f64()
            },
            silence: if shows { silence } else { 0 },
            newest: shows.then_some(ReceivedMotion {
                set: sample.set,
                age: (self.cycle_time * i64::from(scan.age)).as_secs_f64(),
            }),
            is_lost,
        };
        let is_known = self.has_settled();
        let set = self.carried_on(&moved, is_known, &continuation);
        moved.set = set.unwrap_or(moved.set);
        // A clock in sync says nothing about an axis that is still on its way back.
        moved.synced &= is_known && self.follows();
        self.error = moved.error;
        *signals = self.show(&sample, &moved, far_time);
        self.show_plan(signals);
        signals.prediction_sigma = self.prediction_sigma(&moved, scan.time_sigma);
        if set.is_none() && is_known {
            // Received only once, and too long ago, the position of the axis is unknown. Wide schedule 200456: a first frame that is 3.2 s old.
            (signals.corrected_position, signals.corrected_velocity) = (None, None);
        }
        // After the signals, which show in any case why there are no set values.
        set?;
        let error = moved.error.map_or(0, |error| error.code().into());
        let error_code = if error == 0 { sample.error_code } else { error };
        Some(Master {
            set: moved.set,
            travel: self.travel(),
            is_sound: error_code == 0,
            is_ready: false,
            // Its own error first: with it the set values are no longer those of the sender.
            error_code,
        })
    }

    /// Way of the set values, u, and the set values: 0 in a step that neither their mode nor the master explains, from
    /// which the axis is brought back.
    fn without_step(
        &mut self,
        received: &Kinematics,
        moved: FarAxisOutput,
        correction: &FarCorrection,
        far: Option<Instant<Remote>>,
        scan: &AxisScan<'_>,
    ) -> (f64, FarAxisOutput) {
        let elapsed = scan.elapsed;
        let passed = self.cycle_time * i64::from(elapsed);
        let advance = self.course.advance(moved.state, far, passed);
        let before = self.steps.position();
        let is_step = self.is_step(received, &moved, advance, passed);
        let state = self.continuity.state();
        // On top of the way back a blend would be a straight line: the way back would be planned with its velocity, which ends at once.
        let is_in_the_way = self.block.is_blending() && state != ContinuityState::Following;
        if !(is_step || is_in_the_way) {
            let way = before.map_or(0.0, |before| moved.set.position - before);
            return (way, moved);
        }
        if is_step || state == ContinuityState::Rejoining {
            self.continuity.rejoin();
        }
        if !self.block.is_blending() {
            return (0.0, moved);
        }
        let known = known(self.presented.as_deref(), scan);
        let unblended = (self.block).without_blend(received, correction, known, &moved, elapsed);
        if self.encoder.is_some() {
            return (0.0, moved);
        }
        self.steps.go_on_from(&unblended.set);
        (0.0, unblended)
    }

    /// The set values without steps and within limits; none before any are known that are not too old.
    fn carried_on(
        &mut self,
        moved: &FarAxisOutput,
        is_known: bool,
        continuation: &Continuation,
    ) -> Option<Kinematics> {
        let cycle = MasterCycle {
            elapsed: continuation.elapsed,
            reach: self.seen.reach(),
            shows_beats: moved.state == FilterState::Bypass,
            newest: continuation.newest,
        };
        // Between two beats it stands, and follows its master on average. On its way back it is
        // braked once the silence exceeds a beat: relative to a master that stands and jumps, it
        // reached twice its velocity.
        let is_silent = continuation.silence > LARGEST_BEAT && !self.follows();
        // Both ways go through the continuity, so that a change between them continues one motion.
        let set = match is_known && !continuation.is_lost && !is_silent {
            true => Some(self.continuity.follow(&moved.set, &cycle)),
            false => self.continuity.brake(&cycle),
        };
        let mut set = set?;
        if continuation.silence > 1 && self.continuity.state() == ContinuityState::Following {
            // The positions stand: so do velocity and acceleration.
            set.velocity = continuation.velocity;
            set.acceleration = 0.0;
        }
        let beat = (continuation.newest).map_or(0.0, |_| self.seen.received_way());
        Some(match &mut self.limited {
            // Last of all: neither a blend nor the way back can exceed the limits behind it.
            Some(limited) => limited.keep(&set, continuation.elapsed, beat),
            None => set,
        })
    }

    /// True if neither their mode nor the master explains its set values.
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
        let course = FarCycle {
            mode: moved.state,
            is_blending: self.block.is_blending(),
            far,
            received: received.position,
            passed: passed.as_secs_f64(),
            cycle_time: self.cycle_time.as_secs_f64(),
            // A mode without a correction shows values as they came, not moved on.
            age: moved.correction_time.map_or(0.0, |Seconds(age)| age),
            predicted: predicted(moved),
        };
        let is_step = (self.steps).is_step(&moved.set, &course, &self.blending, &self.seen);
        // Increments have jumps of their own, and their smoothing leaves none.
        advance == Advance::Jump || (is_step && self.encoder.is_none())
    }

    /// Standard deviation of the set values from the master, while its motion stays within the
    /// observed one: from the time, and from the extrapolation.
    fn prediction_sigma(&self, moved: &FarAxisOutput, time: Option<Seconds>) -> Option<f64> {
        let is_by_clock = moved.state == FilterState::Observer && self.follows();
        // Only then both parts are known: a braked axis departs by its plan, and a smoothed one has sigmas of its
        // own.
        let Seconds(time) = time.filter(|_| is_by_clock && self.encoder.is_none())?;
        let age = moved.correction_time.map(|_| predicted(moved))?;
        // Within its time error it is accelerated too.
        let velocity = moved.set.velocity.abs() + moved.set.acceleration.abs() * time;
        Some(time * velocity + self.seen.prediction_error(age))
    }

    /// Replaces the set values of an axis that is only measured by those from its increments, moved
    /// by its correction.
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

    /// True if the position by its increments is known.
    fn has_settled(&self) -> bool {
        (self.encoder.as_ref()).is_none_or(|encoder| encoder.set().is_some())
    }

    /// Direction by its increments, as long as it follows them.
    fn travel(&self) -> Option<TravelDirection> {
        let encoder = self.encoder.as_ref()?;
        // On its way back the axis moves by a plan, whatever its increments do.
        encoder.travel().filter(|_| self.follows())
    }

    /// State of its motion; an axis that its own limits keep from its position is rejoining.
    fn state(&self) -> ContinuityState {
        let is_at_target = (self.limited.as_ref()).is_none_or(|limited| limited.is_at_target());
        match self.continuity.state() {
            ContinuityState::Following if !is_at_target => ContinuityState::Rejoining,
            state => state,
        }
    }

    fn follows(&self) -> bool {
        self.state() == ContinuityState::Following
    }

    /// True while a change of mode is being blended.
    pub(super) fn is_blending(&self) -> bool {
        self.block.is_blending()
    }

    /// Error of the newest cycle, including the clock's.
    pub(super) const fn error(&self) -> Option<SyncError> {
        self.error
    }
}

fn blending(parameters: &ExtrapolateParameters, cycle_time: Span) -> Blending {
    Blending {
        time: parameters.blending_time.0,
        // TS5066 states the time constant of its PT1 in cycles of the receiver.
        filter_time: parameters.t1_factor_pos * cycle_time.as_secs_f64(),
    }
}

/// Time by which set values are predicted beyond the newest frame, s: none between two frames, and by a plan.
fn predicted(moved: &FarAxisOutput) -> f64 {
    match moved.correction_time {
        Some(Seconds(age)) if !moved.is_interpolated && !moved.is_planned => age,
        _ => 0.0,
    }
}

/// Whole cycles of the sender since the newest frame.
fn cycles_of_silence(header: &FrameHeader, cycle_time: Span, age: u32) -> u64 {
    let in_cycle = header.cycle_time.span().as_nanos() / cycle_time.as_nanos().max(1);
    // A sender with shorter cycles than the own ones has a ratio of 0: each own cycle then counts as one.
    u64::from(age) / in_cycle.max(1) as u64
}
