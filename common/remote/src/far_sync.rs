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
    /// Own cycles of silence that a phase observer bridges; none where a limit is configured, for all modes.
    bridged: Option<u32>,
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
        Ok(Self {
            task_cycle_time,
            time_sync: TimeSync::start(task_cycle_time, parameters.time_sync)?,
            bridged: bridged(parameters, task_cycle_time),
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
        self.bridged = bridged(whole, self.task_cycle_time);
        self.start_up_mode = whole.start_up_mode;
        self.fall_back_mode = whole.fall_back_mode;
        self.delay_time_offset = whole.time_sync.delay_time_offset;
    }

    /// Own cycles without new data after which they are too old in a mode; none if they are not monitored.
    #[must_use]
    pub fn age_limit(&self, mode: FilterMode) -> Option<u32> {
        let bridged = self.bridged.filter(|_| mode == FilterMode::Observer);
        let watched = self.time_sync.parameters().age_of_data_limit;
        bridged.or_else(|| Some(watched?.into()).filter(|&cycles| cycles > 0))
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
        let time = self.time_sync.update(index, elapsed);
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
        let time = self.time_sync.update(index, elapsed);
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

fn bridged(parameters: &AxisSyncParameters, task_cycle_time: Span) -> Option<u32> {
    let is_configured = parameters.time_sync.age_of_data_limit.is_some();
    (!is_configured).then(|| parameters.bridged(task_cycle_time))
}
