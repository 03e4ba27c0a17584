//! A far axis: its half of a far clock's correction ([`FarSync`]), its set values ([`FarAxis`]), its presentation and its plans.

use ::coaxle_axis::motion_plan::PlanFault;
use coaxle_clock::{CycleIndex, CycleTime, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_remote::{
    AxisPresentation, Continuity, ContinuityState, FarAxis, FarAxisOutput, FarCorrection, FarSync,
    FilterMode, FilterState, FrameDelay, KnownMotion, MasterCycle, PlanCoverage, PlannedAhead,
    PlannedMotion, PresentedNow, Reach, ReceivedPlan, ShownChange,
};

use crate::failure::{COAXLE_NOT_THERE, COAXLE_REJECTED, Failure, wrong_parameter};
use crate::far_axis_structs::{
    COAXLE_BRAKING, COAXLE_FOLLOWING, COAXLE_REJOINING, coaxle_awaited_position,
    coaxle_far_axis_parameters, coaxle_far_axis_state, coaxle_far_sample,
};
use crate::handle::{HandleHead, call, free, handle, make, plain};
use crate::memory::{check_if_any, finite, read, readable, writable, write, write_if_any};
use crate::phase::cycle_time;
use crate::plan::coaxle_plan;
use crate::wire::present_after;

/// A far axis made local: samples by the far cycle in, set values for the own cycle out, by the modes of TS5066 or a far clock.
///
/// Each cycle: `coaxle_far_axis_sample` and `coaxle_far_axis_plan` for what has arrived, then `coaxle_far_axis_cycle`. Its set values
/// are those of `FB_AxisSync`, and without steps if `is_continuous`.
#[repr(C)]
#[derive(Debug)]
pub struct coaxle_far_axis {
    head: HandleHead,
    mode: FilterMode,
    cycle: CycleTime,
    data_cycle: Span,
    /// The clock's half as it begins with another run of the node …
    fresh: FarSync,
    /// … and as it is.
    sync: FarSync,
    axis: FarAxis,
    newest: Option<NewestSample>,
    presentation: AxisPresentation,
    plan: PlannedMotion,
    coverage: PlanCoverage,
    contradictions: u32,
    /// None for an axis as `FB_AxisSync` has it.
    continuity: Option<Continuity>,
    /// Largest motion of the samples.
    reach: Reach,
    /// True if samples had been missing for too long in the newest cycle.
    was_lost: bool,
}

handle!(coaxle_far_axis, b"far axis");

/// The newest sample.
#[derive(Clone, Copy, Debug)]
struct NewestSample {
    count: u64,
    /// Time of the node's run.
    instant: Span,
    set: Kinematics,
    delay: Span,
}

/// Sets the parameters of a far axis to the defaults of the manual, but for `struct_size`, which the caller has set: mode observer, with
/// this own cycle time and that of the far node, ns.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_axis_parameters_init(
    parameters: *mut coaxle_far_axis_parameters,
    cycle_time_ns: i64,
    data_cycle_time_ns: i64,
) -> i32 {
    // SAFETY: as for this function.
    plain(|| unsafe {
        // Reads nothing but the size.
        let _ = writable(parameters, "parameters")?;
        let defaults = coaxle_far_axis_parameters::defaults(cycle_time_ns, data_cycle_time_ns);
        write(parameters, &defaults)
    })
}

/// Makes a far axis, and passes it out in `out`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_axis_new(
    parameters: *const coaxle_far_axis_parameters,
    out: *mut *mut coaxle_far_axis,
) -> i32 {
    // SAFETY: as for this function.
    unsafe { make(out, || coaxle_far_axis::new(&read(parameters)?)) }
}

/// Frees a far axis; `NULL` is left alone.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_axis_free(axis: *mut coaxle_far_axis) {
    // SAFETY: as for this function.
    unsafe { free(axis) }
}

/// Takes the sample of a frame. An older one than the newest counts for an axis that is shown later alone. Before the first one of
/// another run of the node (another epoch) call `coaxle_far_axis_restart`.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_axis_sample(
    axis: *mut coaxle_far_axis,
    sample: *const coaxle_far_sample,
) -> i32 {
    // SAFETY: as for this function.
    unsafe { call(axis, |axis| axis.sample(&read(sample)?)) }
}

/// Takes a plan of its node, which is used where samples are missing, once a sample has confirmed it and its renewals have reached far
/// enough for a second. An older one than the newest is left out.
///
/// # Errors
/// `COAXLE_REJECTED` and the reason: no motion that an axis can make, or a promise that is moved back or broken.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_axis_plan(
    axis: *mut coaxle_far_axis,
    plan: *const coaxle_plan,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(axis, |axis| {
            let given = readable(plan, "plan")?;
            let checked = given.checked()?;
            let received = ReceivedPlan {
                count: given.count,
                pieces: checked.pieces(),
                promised_until: checked.promised_until(),
            };
            (axis.plan.take(&received)).map_err(refused)
        })
    }
}

/// Runs a cycle, `elapsed` cycles after the one before. `state` may be `NULL`.
///
/// In mode observer `correction_s` is that of a far clock for the newest sample's count (`coaxle_far_clock_correction`): `NULL` while it
/// is not sure. The other modes count cycles, and do not read it.
///
/// # Errors
/// `COAXLE_NOT_THERE` before the first sample.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_axis_cycle(
    axis: *mut coaxle_far_axis,
    correction_s: *const f64,
    elapsed: u32,
    state: *mut coaxle_far_axis_state,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(axis, |axis| {
            check_if_any(state)?;
            let clock = match correction_s.is_null() {
                true => None,
                false => Some(*readable(correction_s, "correction_s")?),
            };
            let clock = clock
                .map(|clock| finite("correction_s", clock))
                .transpose()?;
            let shown = axis.cycle(clock.map(Seconds), elapsed)?;
            write_if_any(state, &shown)
        })
    }
}

/// Passes out the instant at which the axis will come to a position, by its plan: ns of the far node's run. It looks from `from_ns` on
/// until `until_ns`, or as far as the plan is promised.
///
/// # Errors
/// `COAXLE_NOT_THERE` if it does not come there as far as is known.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_axis_passage(
    axis: *mut coaxle_far_axis,
    awaited: *const coaxle_awaited_position,
    from_ns: i64,
    until_ns: i64,
    at_ns: *mut i64,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(axis, |axis| {
            let at_ns = writable(at_ns, "at_ns")?;
            let awaited = readable(awaited, "awaited")?.checked()?;
            let [from, until] = [from_ns, until_ns].map(Span::from_nanos);
            let passage = axis.plan.passage(from, until, &awaited);
            let none = "the axis does not come there as far as its plan is known";
            *at_ns = passage
                .ok_or_else(|| Failure::new(COAXLE_NOT_THERE, none))?
                .at
                .as_nanos();
            Ok(())
        })
    }
}

/// Forgets samples and plans: the next ones are of another run of the node. The set values go on from where they are. A latched error
/// is reset.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_far_axis_restart(axis: *mut coaxle_far_axis) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(axis, |axis| {
            axis.restart();
            Ok(())
        })
    }
}

fn refused(fault: PlanFault) -> Failure {
    let sentence = format_args!("the plan is refused: {}", fault.name());
    Failure::new(COAXLE_REJECTED, sentence)
}

impl coaxle_far_axis {
    fn new(given: &coaxle_far_axis_parameters) -> Result<Self, Failure> {
        let cycle = cycle_time(given.cycle_time_ns)?;
        let data_cycle = given.data_cycle_time(cycle)?;
        let parameters = given.checked(data_cycle)?;
        let sync = FarSync::start(cycle.span(), &parameters).map_err(wrong_parameter)?;
        Ok(Self {
            head: HandleHead::new::<Self>(),
            mode: given.mode()?,
            cycle,
            data_cycle,
            fresh: sync.clone(),
            sync,
            axis: FarAxis::start(cycle.span(), &parameters).map_err(wrong_parameter)?,
            newest: None,
            presentation: AxisPresentation::new(data_cycle),
            plan: PlannedMotion::default(),
            coverage: PlanCoverage::default(),
            contradictions: 0,
            continuity: (given.is_continuous != 0)
                .then(|| Continuity::new(cycle.span(), parameters.extrapolate.blending_time)),
            reach: Reach::default(),
            was_lost: false,
        })
    }

    fn sample(&mut self, given: &coaxle_far_sample) -> Result<(), Failure> {
        let most = i64::MAX.unsigned_abs() / self.data_cycle.as_nanos().unsigned_abs();
        if given.count > most {
            let expected = format_args!("at most {most} cycles");
            return Err(Failure::range("count", given.count, expected));
        }
        let sample = NewestSample {
            count: given.count,
            instant: self.data_cycle * given.count as i64,
            set: given.set()?,
            delay: present_after(given.present_after_ns)?.map_or(Span::ZERO, |delay| delay.span()),
        };
        self.presentation
            .take(sample.count, &sample.set, sample.delay);
        if self.newest.is_none_or(|newest| sample.count > newest.count) {
            self.see(&sample);
            self.newest = Some(sample);
        }
        if self.plan.check(sample.instant, &sample.set).is_err() {
            self.contradictions = self.contradictions.saturating_add(1);
        }
        Ok(())
    }

    fn cycle(
        &mut self,
        clock: Option<Seconds>,
        elapsed: u32,
    ) -> Result<coaxle_far_axis_state, Failure> {
        let none = || Failure::new(COAXLE_NOT_THERE, "no sample has come yet");
        let newest = self.newest.ok_or_else(none)?;
        let index = CycleIndex::of_count(newest.count);
        let correction = match self.mode {
            FilterMode::Observer => self.sync.update_by_clock(index, clock, elapsed),
            mode => self.sync.update(index, mode, elapsed),
        };
        let is_planned = self.uses_plan(&correction, newest.instant, elapsed);
        // Frames that are shown later outlast a silence, and so does a promise.
        let correction = match is_planned || self.presentation.covers(correction.of_clock()) {
            true => correction.despite_silence(),
            false => correction,
        };
        self.present(&newest, &correction, elapsed);
        let was_lost = core::mem::replace(&mut self.was_lost, correction.is_silent);
        if was_lost && !self.was_lost && self.continuity.is_some() {
            // The filters of the block hold values from before the loss.
            self.axis.begin_anew();
        }
        let known = KnownMotion {
            later: self.presentation.later(),
            planned: is_planned.then_some(PlannedAhead {
                motion: &self.plan,
                newest: newest.instant,
            }),
        };
        let mut moved = (self.axis).update(&newest.set, &correction, known, elapsed);
        if moved.re_initialised {
            // The block is a unit: its clock restarts with its axis.
            self.sync.restart(index);
        }
        self.carry_on(&mut moved, elapsed);
        Ok(self.state(&newest, &correction, &moved))
    }

    /// Takes a sample as one of the master's motion.
    fn see(&mut self, sample: &NewestSample) {
        let Kinematics {
            velocity,
            acceleration,
            ..
        } = sample.set;
        // The mean since the sample before: not all masters state their acceleration.
        let rate = self.newest.map_or(0.0, |before| {
            (velocity - before.set.velocity) / (sample.instant - before.instant).as_secs_f64()
        });
        let Reach {
            velocity: fastest,
            acceleration: hardest,
        } = &mut self.reach;
        *fastest = fastest.max(velocity.abs());
        *hardest = hardest.max(acceleration.abs()).max(rate.abs());
    }

    /// The next set values are unrelated to the ones before.
    fn rejoin(&mut self) {
        match &mut self.continuity {
            Some(continuity) => {
                // On top of the way back a blend would be a straight line.
                self.axis.begin_anew();
                continuity.rejoin();
            }
            None => self.axis.carry_on(),
        }
    }

    /// Takes the steps out of a cycle's set values, of an axis that is to have none.
    fn carry_on(&mut self, moved: &mut FarAxisOutput, elapsed: u32) {
        let Some(continuity) = &mut self.continuity else {
            return;
        };
        let cycle = MasterCycle {
            elapsed,
            reach: self.reach,
            shows_beats: moved.state == FilterState::Bypass,
            newest: None,
        };
        moved.set = match self.was_lost {
            true => continuity.brake(&cycle).unwrap_or(moved.set),
            false => continuity.follow(&moved.set, &cycle),
        };
        // A clock in sync says nothing about an axis that is still on its way back.
        moved.synced &= continuity.state() == ContinuityState::Following;
    }

    /// True if the plan is to be used: its promise has reached the instant shown for long enough.
    fn uses_plan(&mut self, correction: &FarCorrection, newest: Span, elapsed: u32) -> bool {
        let reaches =
            (self.shown_after(correction)).is_some_and(|after| self.plan.reaches(newest, after));
        self.coverage = self.coverage.after(self.passed(elapsed), reaches);
        self.coverage.suffices()
    }

    /// Follows the delay that the frames state.
    fn present(&mut self, newest: &NewestSample, correction: &FarCorrection, elapsed: u32) {
        let stated = FrameDelay {
            count: newest.count,
            delay: newest.delay,
            cycle: self.data_cycle,
        };
        let now = PresentedNow {
            passed: self.passed(elapsed),
            age: correction.time(correction.mode),
            held: Seconds::ZERO,
        };
        if self.presentation.follow(&stated, &now) != ShownChange::None {
            self.rejoin();
        }
    }

    /// Time from the newest sample to the instant shown, if the clock is known.
    fn shown_after(&self, correction: &FarCorrection) -> Option<Seconds> {
        let lag = (self.presentation.later()).map_or(Seconds::ZERO, |later| later.by);
        correction.of_clock().map(|age| age - lag)
    }

    fn passed(&self, elapsed: u32) -> Span {
        self.cycle.span() * i64::from(elapsed)
    }

    fn state(
        &self,
        newest: &NewestSample,
        correction: &FarCorrection,
        moved: &FarAxisOutput,
    ) -> coaxle_far_axis_state {
        let shown = (self.shown_after(correction)).map(|after| newest.instant + after.to_span());
        let ahead = (self.plan.known_until().zip(shown))
            .map_or(f64::NAN, |(until, shown)| (until - shown).as_secs_f64());
        coaxle_far_axis_state {
            is_silent: correction.is_silent.into(),
            warning: correction
                .warning
                .map_or(0, |warning| warning.code().into()),
            beats: correction.time_sync.beats,
            plan_contradictions: self.contradictions,
            shown_later_s: match self.presentation.is_shown() {
                true => self.presentation.lag().0,
                false => 0.0,
            },
            promised_ahead_s: ahead,
            continuity: match self.continuity.as_ref().map(Continuity::state) {
                None | Some(ContinuityState::Following) => COAXLE_FOLLOWING,
                Some(ContinuityState::Braking) => COAXLE_BRAKING,
                Some(ContinuityState::Rejoining) => COAXLE_REJOINING,
            },
            ..coaxle_far_axis_state::of(moved)
        }
    }

    fn restart(&mut self) {
        self.sync = self.fresh.clone();
        self.axis.re_initialise();
        self.rejoin();
        self.newest = None;
        self.presentation.clear();
        self.plan.clear();
        self.coverage = PlanCoverage::default();
    }
}
