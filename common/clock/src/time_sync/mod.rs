//! `FB_TimeSync`: a correction time from nothing but the cycle index received.
//!
//! TS5066, chapter 3.2. The receiver reads one index per cycle of its own. Where both clocks run
//! alike the index grows by one each time; where they drift apart it now and then repeats or skips
//! one: a *beat*. From the distance between beats the block learns the drift, and spreads the whole
//! cycle that each beat is worth over the time until the next one.
//!
//! # How the manual is read where it is terse
//!
//! * Everything is counted in *ticks*, the shorter of the two cycle times; the other is a whole
//!   multiple of it. The far clock then gains or loses one tick per beat for every ratio.
//! * The *offset* is the received index minus the own cycle count, in ticks. It is looked at in
//!   cycles that brought new data; a cycle without says nothing, as it may be a lost message.
//! * A *plateau* is an offset that stays constant for `end_of_transition_limit` cycles. A beat is the
//!   change from one plateau to another, dated at the first cycle of the new one. A beat of several
//!   ticks counts as that many periods.
//! * Sync mode begins once the time-mode blending after the beat that made the drift known is over
//!   and the correction is inside `threshold_for_sync`. That blending leads straight onto the ramp
//!   where the ramp is still inside the threshold then, so that the switch is no bump at all.
//! * The correction time is compared with `threshold_for_sync` before `delay_time_offset` is added,
//!   or no offset above the threshold would ever let it synchronise.
//! * While no new data come the index difference grows with the age. Where the age limit is on, both are counted in
//!   whole cycles then, and of two limits that are exceeded in the same cycle the age is named: with the fraction that
//!   the ramp adds, the manual's defaults (7 and 7) would never name it.
//! * A plateau that lies further away than the manual's largest index difference is no beat but a
//!   loss of sync for an unknown reason, should `max_cycle_index_difference` not have caught it.

mod beats;
mod line;
mod outcome;
mod parameters;

pub use outcome::{SyncError, SyncWarning, TimeSyncDiagnostic, TimeSyncOutput, TimeSyncState};
pub use parameters::{AGE_LIMIT, CheckedTimeSync, TimeSyncParameters, WrongParameter};

use crate::cycle::CycleIndex;
use crate::instant::{Seconds, Span};
use beats::{Beat, Beats};
use line::{Blend, Line};
use parameters::Ticks;

/// The largest step between two plateaus that can still be a beat, in indices: the manual's
/// default for the largest index difference.
const LARGEST_BEAT: i64 = 7;

/// `FB_TimeSync`, enabled. To disable it, drop it; to restart it, make a new one.
#[doc(alias = "FB_TimeSync")]
#[derive(Clone, Debug)]
pub struct TimeSync {
    parameters: TimeSyncParameters,
    ticks: Ticks,
    status: Status,
    warning: Option<SyncWarning>,
    /// Own time since the first data, in ticks.
    own: i64,
    /// Own cycles since the first data.
    cycle: i64,
    /// The newest index, and the same unwrapped; none until the first data.
    received: Option<Received>,
    /// After a fault, the index that stood then: old data start nothing.
    stale: Option<CycleIndex>,
    beats: Beats,
    /// Offset that time mode follows: the plateaus, each blended into the next.
    level: Blend,
    /// Offset in force: as time mode until the drift is known, then the ramps from beat to beat.
    course: Blend,
    diagnostic: TimeSyncDiagnostic,
}

#[derive(Clone, Copy, Debug)]
struct Received {
    index: CycleIndex,
    unwrapped: i64,
}

/// Corrected minus received index, in ticks.
#[derive(Clone, Copy, Debug, Default)]
struct Corrections {
    in_force: f64,
    time_mode: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Status {
    StartUp,
    Synced,
    Failed(SyncError),
}

impl TimeSync {
    /// The rising edge of `bEnable`. `task_cycle_time` is the receiver's nominal cycle time.
    ///
    /// # Errors
    /// [`WrongParameter`] (0x4b56) names the parameter that is out of its range.
    pub fn start(
        task_cycle_time: Span,
        parameters: TimeSyncParameters,
    ) -> Result<Self, WrongParameter> {
        let CheckedTimeSync { parameters, ticks } = parameters.checked(task_cycle_time)?;
        Ok(Self {
            ticks,
            status: Status::StartUp,
            warning: None,
            own: 0,
            cycle: 0,
            received: None,
            stale: None,
            beats: Beats::new(
                i64::from(parameters.end_of_transition_limit),
                parameters.no_of_periods_for_mean_drift,
            ),
            level: Blend::new(Line::level(0)),
            course: Blend::new(Line::level(0)),
            diagnostic: TimeSyncDiagnostic::default(),
            parameters,
        })
    }

    /// Runs one cycle. `index` is what the input image holds now; `elapsed` counts the own cycles since the previous
    /// call: 1, or more when some were skipped.
    pub fn update(&mut self, index: CycleIndex, elapsed: u32) -> TimeSyncOutput {
        let corrections = match self.status {
            // TS5066: a fault stays until the rising edge of `bEnable`, unless `bAutomaticReInit` is set.
            Status::Failed(_) if !self.parameters.automatic_re_init => None,
            Status::Failed(_) => {
                self.restart(index);
                self.advance(index, elapsed)
            }
            _ => self.advance(index, elapsed),
        };
        self.output(corrections)
    }

    /// Forgets fault and drift and starts up again with the next data that are newer than `index`;
    /// the counters go on. `automatic_re_init` does this one cycle after a fault.
    pub fn restart(&mut self, index: CycleIndex) {
        self.status = Status::StartUp;
        self.warning = None;
        self.received = None;
        self.stale = Some(index);
        self.own = 0;
        self.cycle = 0;
        self.beats.restart();
        self.level = Blend::new(Line::level(0));
        self.course = self.level;
        self.diagnostic.cycle_index_diff = 0;
        self.diagnostic.consecutive_equal_data = 0;
        self.diagnostic.drift_ppm = 0.0;
    }

    /// Changes `fDelayTimeOffset` while running. It acts at once: slew it.
    pub fn set_delay_time_offset(&mut self, offset: Seconds) {
        self.parameters.delay_time_offset = offset;
    }

    /// Changes the parameters while running. Everything learnt is kept: limits hold from now on, parameters that
    /// shape a ramp or a blend from the next beat on. Forced into time mode, it leaves sync mode. `parameters` are
    /// checked for the same two cycle times as those it was started with.
    pub fn set_parameters(&mut self, parameters: &CheckedTimeSync) {
        self.parameters = parameters.parameters;
        let CheckedTimeSync { parameters, .. } = parameters;
        self.beats.set(
            i64::from(parameters.end_of_transition_limit),
            parameters.no_of_periods_for_mean_drift,
        );
        if parameters.force_time_mode && self.status == Status::Synced {
            self.status = Status::StartUp;
            let cycles = parameters.time_mode_blending_cycles;
            self.course.aim(self.plateau(), self.cycle, cycles);
        }
    }

    /// Changes the limits of both monitors while running: own cycles without new data, and the difference of the indices; 0: not watched. They hold from
    /// the next cycle on, as they are.
    pub const fn set_limits(&mut self, age_of_data: u16, cycle_index_difference: f64) {
        self.parameters.age_of_data_limit = Some(age_of_data);
        self.parameters.max_cycle_index_difference = cycle_index_difference;
    }

    /// Parameters in force, with the limits raised as the ratio of the cycle times requires.
    #[must_use]
    pub const fn parameters(&self) -> &TimeSyncParameters {
        &self.parameters
    }

    /// Runs one cycle of a block that is not in error.
    fn advance(&mut self, index: CycleIndex, elapsed: u32) -> Option<Corrections> {
        // The index that stood when the block failed may be of a sender that is gone.
        if self.stale.is_some_and(|stale| stale == index) {
            return None;
        }
        self.stale = None;
        let Some(received) = self.received else {
            self.begin(index);
            return Some(Corrections::default());
        };
        self.count(elapsed);
        let unwrapped = self.take_index(received, index, elapsed);
        // Whole ticks of 64 bits: neither count loses anything over the years, as a float would.
        let offset = unwrapped * self.ticks.per_data_cycle - self.own;
        let arrived = self.diagnostic.cycle_index_diff != 0;
        if let Some(beat) = self.beats.observe(arrived.then_some(offset), self.cycle) {
            self.follow(beat);
        }
        self.try_to_synchronise(offset);
        let corrections = self.corrections(offset);
        if let Some(error) = self.fault(corrections.in_force) {
            self.status = Status::Failed(error);
            return None;
        }
        Some(corrections)
    }

    fn begin(&mut self, index: CycleIndex) {
        self.received = Some(Received {
            index,
            unwrapped: 0,
        });
        let _ = self.beats.observe(Some(0), self.cycle);
    }

    fn count(&mut self, elapsed: u32) {
        self.cycle += i64::from(elapsed);
        self.own += i64::from(elapsed) * self.ticks.per_task_cycle;
    }

    fn take_index(&mut self, received: Received, index: CycleIndex, elapsed: u32) -> i64 {
        // Indices wrap at 16 bits, so a step is the nearest of all that fit.
        let step = index.steps_since(received.index);
        let unwrapped = received.unwrapped + i64::from(step);
        self.received = Some(Received { index, unwrapped });
        let diagnostic = &mut self.diagnostic;
        diagnostic.cycle_index_diff = i32::from(step);
        if step == 0 {
            diagnostic.total_equal_data += u64::from(elapsed);
            diagnostic.consecutive_equal_data =
                diagnostic.consecutive_equal_data.saturating_add(elapsed);
        } else {
            diagnostic.consecutive_equal_data = 0;
        }
        unwrapped
    }

    /// Aims both lines at a new plateau.
    fn follow(&mut self, beat: Beat) {
        let before = self.diagnostic.drift_ppm;
        self.diagnostic.drift_ppm = self.drift_ppm();
        if let Beat::Counted { .. } = beat {
            self.warning = drift_warning(before, self.diagnostic.drift_ppm);
        }
        let synced = self.status == Status::Synced;
        // Before both lines are aimed at the new plateau, which would be followed for one cycle.
        if synced && beat.size() > LARGEST_BEAT * self.ticks.per_data_cycle {
            self.status = Status::Failed(SyncError::UnknownSyncLoss);
            return;
        }
        let cycles = self.parameters.time_mode_blending_cycles;
        self.level.aim(self.plateau(), self.cycle, cycles);
        if synced {
            let cycles = self.parameters.new_drift_bending_cycles;
            self.course
                .aim(self.ramp_from_last_beat(), self.cycle, cycles);
        } else {
            self.course.aim(self.approach(), self.cycle, cycles);
        }
    }

    /// Line to which the beats of the start-up lead. With the drift known, straight onto the ramp, if that is still
    /// inside the threshold when it is reached; otherwise to the plateau, as time mode.
    fn approach(&self) -> Line {
        let plateau = self.plateau();
        if self.parameters.force_time_mode || !self.beats.mean_is_known() {
            return plateau;
        }
        let ramp = self.ramp_from_last_beat();
        // The correction at the end of the blending decides: that is when sync mode may begin.
        let reached = self.cycle + i64::from(self.parameters.time_mode_blending_cycles);
        let correction = ramp.at(reached) - plateau.at(reached);
        if correction.abs() < self.threshold() {
            ramp
        } else {
            plateau
        }
    }

    fn plateau(&self) -> Line {
        Line::level(self.beats.plateau().unwrap_or(0))
    }

    fn threshold(&self) -> f64 {
        self.parameters.threshold_for_sync * self.ticks.per_task_cycle as f64
    }

    fn ramp_from_last_beat(&self) -> Line {
        Line::ramp(
            self.beats.plateau().unwrap_or(0),
            self.beats.last().unwrap_or(self.cycle),
            self.beats.ticks_per_cycle(),
            self.parameters.slopes(),
        )
    }

    fn drift_ppm(&self) -> f64 {
        1e6 * self.beats.ticks_per_cycle() / self.ticks.per_task_cycle as f64
    }

    /// Corrected minus received index, in ticks.
    fn corrections(&self, offset: i64) -> Corrections {
        Corrections {
            in_force: self.course.at(self.cycle) - offset as f64,
            time_mode: self.level.at(self.cycle) - offset as f64,
        }
    }

    /// Begins sync mode when the approach is over and the correction inside the threshold: then the switch itself
    /// changes nothing.
    fn try_to_synchronise(&mut self, offset: i64) {
        if self.status == Status::StartUp
            && !self.parameters.force_time_mode
            && self.beats.mean_is_known()
            && self.course.has_arrived(self.cycle)
            && self.corrections(offset).in_force.abs() < self.threshold()
        {
            self.status = Status::Synced;
            let cycles = self.parameters.new_drift_bending_cycles;
            self.course
                .aim(self.ramp_from_last_beat(), self.cycle, cycles);
        }
    }

    fn fault(&self, correction: f64) -> Option<SyncError> {
        if let Status::Failed(error) = self.status {
            return Some(error);
        }
        let age_limit = u32::from(self.parameters.age_limit());
        // Age before difference, as in a silence both grow and the cause is the age.
        if age_limit > 0 && self.diagnostic.consecutive_equal_data > age_limit {
            return Some(SyncError::MaxDataAgeExceeded);
        }
        let index_limit = self.parameters.max_cycle_index_difference;
        (index_limit > 0.0 && self.index_difference(correction) > index_limit)
            .then_some(SyncError::MaxCycleIndexDiffExceeded)
    }

    /// The difference between corrected and received index, in data cycles. In a silence that the age limit watches, too,
    /// it is the age.
    fn index_difference(&self, correction: f64) -> f64 {
        let age = self.diagnostic.consecutive_equal_data;
        let ticks = if age > 0 && self.parameters.age_limit() > 0 {
            f64::from(age) * self.ticks.per_task_cycle as f64
        } else {
            correction.abs()
        };
        ticks / self.ticks.per_data_cycle as f64
    }

    fn output(&self, corrections: Option<Corrections>) -> TimeSyncOutput {
        let state = match self.status {
            Status::StartUp => TimeSyncState::StartUp,
            Status::Synced => TimeSyncState::Synced,
            Status::Failed(error) => TimeSyncState::Failed(error),
        };
        let offset = self.parameters.delay_time_offset;
        let time = |ticks: f64| Seconds(ticks * self.ticks.seconds) + offset;
        TimeSyncOutput {
            state,
            warning: self.warning,
            correction_time: corrections.map(|ticks| time(ticks.in_force)),
            time_mode_correction: corrections.map(|ticks| time(ticks.time_mode)),
            beats: self.beats.count(),
            diagnostic: self.diagnostic,
        }
    }
}

/// Warns of a known drift that changes by more than half of what it was.
fn drift_warning(before: f64, now: f64) -> Option<SyncWarning> {
    let changed = before != 0.0 && (now - before).abs() > 0.5 * before.abs();
    changed.then_some(SyncWarning::DriftChangedSignificantly)
}

#[cfg(test)]
mod tests;
