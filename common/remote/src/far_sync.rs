//! The clock's half of `FB_AxisSync`: one far clock's correction for all axes of its node.

use coaxle_clock::time_sync::{
    SyncError, SyncWarning, TimeSync, TimeSyncDiagnostic, TimeSyncOutput, TimeSyncState,
    WrongParameter,
};
use coaxle_clock::{CycleIndex, Seconds, Span};

use super::extrapolate::{CorrectionTimes, ExtrapolateMode, FallBackMode};
use super::parameters::{AxisSyncParameters, CheckedParameters, FilterMode, StartUpMode};

/// A far clock in cycle indices, and the choice of the mode. A single one serves any number of
/// [`FarAxis`](super::FarAxis).
#[derive(Clone, Debug)]
pub struct FarSync {
    task_cycle_time: Span,
    time_sync: TimeSync,
    /// Limits of the modes of TS5066 …
    watched: MonitorLimits,
    /// … and of a phase observer.
    bridged: MonitorLimits,
    start_up_mode: StartUpMode,
    fall_back_mode: FallBackMode,
    delay_time_offset: Seconds,
    silence: Silence,
}

/// Correction of a far clock in one cycle.
#[must_use]
#[derive(Clone, Copy, Debug)]
pub struct FarCorrection {
    /// Output of the time sync.
    pub time_sync: TimeSyncOutput,
    /// True if the far clock is known and corrected.
    pub synced: bool,
    /// True if its data have been missing for longer than `age_of_data_limit`.
    pub is_silent: bool,
    /// The error of the clock.
    pub error: Option<SyncError>,
    /// The warning to report.
    pub warning: Option<SyncWarning>,
    /// Mode that calculates the set values.
    pub mode: ExtrapolateMode,
    /// Mode if that is impossible.
    pub fall_back: FallBackMode,
    pub(super) times: CorrectionTimes,
    /// Reaction of an axis to a position error of its own.
    pub(super) on_position_error: OnPositionError,
}

/// Effect of a position error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OnPositionError {
    /// Latches; the fallback is in force.
    FallBack,
    /// Latches; the mode, explicitly selected, stays.
    KeepMode,
    /// Ends with its cause.
    Forget,
}

/// Limits of the time sync in a mode; 0: not watched.
#[derive(Clone, Copy, Debug)]
struct MonitorLimits {
    /// Own cycles without new data.
    age: u16,
    /// Difference of the cycle indices, data cycles.
    index_difference: f64,
}

impl MonitorLimits {
    /// Limits of the modes of TS5066: those in force at a time sync that has just been given its parameters.
    fn watched(time_sync: &TimeSync) -> Self {
        let parameters = time_sync.parameters();
        Self {
            age: parameters.age_of_data_limit.unwrap_or_default(),
            index_difference: parameters.max_cycle_index_difference,
        }
    }

    /// Limits of an observer: it bridges a silence by its clock, and so must time mode, which stands in until that is known.
    fn bridged(self, parameters: &AxisSyncParameters, task_cycle_time: Span) -> Self {
        let bridged = parameters.bridged(task_cycle_time);
        let age = match parameters.time_sync.age_of_data_limit {
            Some(_) => self.age,
            None => bridged,
        };
        // Behind a silence that is not watched the difference would be all that is left.
        let tolerated = if age > 0 { age } else { bridged };
        let data_cycle_time = parameters.data_cycle_time(task_cycle_time);
        let ratio = task_cycle_time.as_secs_f64() / data_cycle_time.as_secs_f64();
        let index_difference = match self.index_difference > 0.0 {
            true => self.index_difference.max(f64::from(tolerated) * ratio),
            false => 0.0,
        };
        Self {
            age,
            index_difference,
        }
    }
}

/// Time for which the index has not changed.
#[derive(Clone, Copy, Debug, Default)]
struct Silence {
    index: Option<CycleIndex>,
    cycles: u32,
}

impl Silence {
    fn count(&mut self, index: CycleIndex, elapsed: u32) {
        self.cycles = match self.index.replace(index) {
            // A node that is silent for seven weeks at 1 kHz reaches the end of u32; wrapped, it would count as
            // fresh.
            Some(last) if last == index => self.cycles.saturating_add(elapsed),
            _ => 0,
        };
    }
}

impl FarCorrection {
    /// Output of a disabled block (`bEnable` = FALSE): passes the axes through.
    pub fn disabled() -> Self {
        let none = CorrectionTimes {
            sync: None,
            time: None,
            observer: None,
        };
        Self {
            time_sync: TimeSyncOutput {
                state: TimeSyncState::StartUp,
                warning: None,
                correction_time: None,
                time_mode_correction: None,
                beats: 0,
                diagnostic: TimeSyncDiagnostic::default(),
            },
            synced: false,
            is_silent: false,
            error: None,
            warning: None,
            mode: ExtrapolateMode::Bypass,
            fall_back: FallBackMode::Bypass,
            times: none,
            on_position_error: OnPositionError::Forget,
        }
    }

    /// Correction that moves set values in a mode; none if it needs none or has none.
    #[must_use]
    pub const fn time(&self, mode: ExtrapolateMode) -> Option<Seconds> {
        self.times.of(mode)
    }

    /// Correction by the phase observer, also in a silence; none if there is none.
    #[must_use]
    pub const fn of_clock(&self) -> Option<Seconds> {
        self.times.observer
    }

    /// Correction of an axis whose frames are shown later, as long as those that are shown have arrived: a silence takes
    /// nothing away. It needs a phase observer.
    pub fn despite_silence(&self) -> Self {
        if !self.is_silent || self.times.observer.is_none() {
            return *self;
        }
        Self {
            is_silent: false,
            error: (self.error).filter(|error| *error != SyncError::MaxDataAgeExceeded),
            mode: ExtrapolateMode::Observer,
            ..*self
        }
    }

    /// Correction for an axis whose newest values are older than those of its node by this time.
    pub fn for_older(&self, by: Seconds) -> Self {
        // Older values lie further in the past of the instant wanted: a longer extrapolation.
        let later = |time: Option<Seconds>| time.map(|time| time + by);
        Self {
            times: CorrectionTimes {
                sync: later(self.times.sync),
                time: later(self.times.time),
                observer: later(self.times.observer),
            },
            ..*self
        }
    }

    /// Output if the far node is not to be followed: its axes count as silent.
    pub fn refused(&self) -> Self {
        Self {
            synced: false,
            is_silent: true,
            // A pace of the frames that contradicts the cycle time is a wrong parameter: the manual's 0x4b56.
            error: Some(SyncError::WrongParameter),
            mode: self.fall_back.into(),
            ..*self
        }
    }

    /// Correction for an axis without data for too long, though its node continues.
    pub fn for_silent(&self) -> Self {
        Self {
            is_silent: true,
            error: self.error.or(Some(SyncError::MaxDataAgeExceeded)),
            // A mode that was selected explicitly stays in force on errors.
            mode: match self.on_position_error {
                OnPositionError::KeepMode => self.mode,
                OnPositionError::FallBack | OnPositionError::Forget => self.fall_back.into(),
            },
            ..*self
        }
    }
}

impl FarSync {
    /// Creates an enabled clock. `task_cycle_time` is the receiver's nominal cycle time.
    ///
    /// # Errors
    /// [`WrongParameter`] (0x4b56) names the parameter that is out of its range.
    pub fn start(
        task_cycle_time: Span,
        parameters: &AxisSyncParameters,
    ) -> Result<Self, WrongParameter> {
        let time_sync = TimeSync::start(task_cycle_time, parameters.time_sync)?;
        let watched = MonitorLimits::watched(&time_sync);
        Ok(Self {
            task_cycle_time,
            watched,
            bridged: watched.bridged(parameters, task_cycle_time),
            time_sync,
            start_up_mode: parameters.start_up_mode,
            fall_back_mode: parameters.fall_back_mode,
            delay_time_offset: parameters.time_sync.delay_time_offset,
            silence: Silence::default(),
        })
    }

    /// Clears errors and drift, and restarts with the next data newer than `index`.
    pub fn restart(&mut self, index: CycleIndex) {
        self.time_sync.restart(index);
    }

    /// Changes `fDelayTimeOffset` while running. The change acts at once: slew it.
    pub fn set_delay_time_offset(&mut self, offset: Seconds) {
        self.delay_time_offset = offset;
        self.time_sync.set_delay_time_offset(offset);
    }

    /// Changes the parameters while running; the learned values are kept. See
    /// [`TimeSync::set_parameters`].
    pub fn set_parameters(&mut self, parameters: &CheckedParameters) {
        let CheckedParameters { whole, time_sync } = parameters;
        self.time_sync.set_parameters(time_sync);
        self.watched = MonitorLimits::watched(&self.time_sync);
        self.bridged = self.watched.bridged(whole, self.task_cycle_time);
        self.start_up_mode = whole.start_up_mode;
        self.fall_back_mode = whole.fall_back_mode;
        self.delay_time_offset = whole.time_sync.delay_time_offset;
    }

    /// Own cycles without new data after which they are too old in a mode; none if they are not monitored.
    #[must_use]
    pub fn age_limit(&self, mode: FilterMode) -> Option<u32> {
        let MonitorLimits { age, .. } = match mode {
            FilterMode::Observer => self.bridged,
            _ => self.watched,
        };
        (age > 0).then_some(age.into())
    }

    /// Runs one cycle. `index` is the current value of the input image; `elapsed` counts the own
    /// cycles since the previous call. Call it once per cycle and not before data have arrived.
    pub fn update(
        &mut self,
        index: CycleIndex,
        filter_mode: FilterMode,
        elapsed: u32,
    ) -> FarCorrection {
        // Counted here too: the time sync restarts in observer mode, and its own age with it.
        self.silence.count(index, elapsed);
        let time = self.update_within(self.watched, index, elapsed);
        let (mode, on_position_error) = self.mode(filter_mode, &time);
        let error = match time.state {
            TimeSyncState::Failed(error) => Some(error),
            TimeSyncState::StartUp | TimeSyncState::Synced => None,
        };
        FarCorrection {
            synced: time.state == TimeSyncState::Synced,
            is_silent: self.is_silent(filter_mode),
            error,
            warning: time.warning,
            mode,
            fall_back: self.fall_back_mode,
            times: CorrectionTimes {
                sync: time.correction_time,
                time: time.time_mode_correction,
                observer: None,
            },
            on_position_error,
            time_sync: time,
        }
    }

    /// Runs one cycle in observer mode. `clock` is the correction of a phase observer, once it is
    /// sure of the far clock; without one the start-up mode bridges. The only errors here are data
    /// that are missing beyond the age limit and a position too far off; neither latches.
    pub fn update_by_clock(
        &mut self,
        index: CycleIndex,
        clock: Option<Seconds>,
        elapsed: u32,
    ) -> FarCorrection {
        self.silence.count(index, elapsed);
        // Runs in observer mode as well, so that time mode can bridge at any moment.
        let time = self.update_within(self.bridged, index, elapsed);
        if let TimeSyncState::Failed(_) = time.state {
            // The time sync only bridges: after any loss it restarts.
            self.time_sync.restart(index);
        }
        let silent = self.is_silent(FilterMode::Observer);
        FarCorrection {
            synced: clock.is_some(),
            is_silent: silent,
            error: silent.then_some(SyncError::MaxDataAgeExceeded),
            // A drift warning from beats is obsolete once the observer knows the clock.
            warning: time.warning.filter(|_| clock.is_none()),
            mode: match clock {
                // Silence first: a clock that is still known moves old values ever further.
                _ if silent => self.fall_back_mode.into(),
                Some(_) => ExtrapolateMode::Observer,
                None => self.start_up_mode.into(),
            },
            fall_back: self.fall_back_mode,
            times: CorrectionTimes {
                sync: None,
                time: time.time_mode_correction,
                // The phase is known up to a constant delay, which this offset adds. The corrections of the time sync
                // contain it.
                observer: clock.map(|clock| clock + self.delay_time_offset),
            },
            on_position_error: OnPositionError::Forget,
            time_sync: time,
        }
    }

    fn update_within(
        &mut self,
        limits: MonitorLimits,
        index: CycleIndex,
        elapsed: u32,
    ) -> TimeSyncOutput {
        self.time_sync
            .set_limits(limits.age, limits.index_difference);
        self.time_sync.update(index, elapsed)
    }

    fn is_silent(&self, mode: FilterMode) -> bool {
        let limit = self.age_limit(mode);
        // Older than the limit, not as old: TS5066, iAgeOfDataLimit, permits that number of cycles.
        limit.is_some_and(|limit| self.silence.cycles > limit)
    }

    fn mode(
        &self,
        filter_mode: FilterMode,
        time: &TimeSyncOutput,
    ) -> (ExtrapolateMode, OnPositionError) {
        use OnPositionError::{FallBack, KeepMode};
        match (filter_mode, time.state) {
            // Explicit modes before the failure: they need no clock, so that its failure changes nothing for them.
            (FilterMode::Bypass, _) => (ExtrapolateMode::Bypass, KeepMode),
            (FilterMode::Pt1, _) => (ExtrapolateMode::Pt1, KeepMode),
            (_, TimeSyncState::Failed(_)) => (self.fall_back_mode.into(), FallBack),
            (FilterMode::Time, _) => (ExtrapolateMode::Time, FallBack),
            (FilterMode::Observer, _) => (ExtrapolateMode::Observer, FallBack),
            (FilterMode::Auto, TimeSyncState::Synced) => (ExtrapolateMode::Sync, FallBack),
            (FilterMode::Auto, TimeSyncState::StartUp) => (self.start_up_mode.into(), FallBack),
        }
    }
}
