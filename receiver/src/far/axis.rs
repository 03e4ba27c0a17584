//! One far axis: its newest values, moved in time by what the clock of its node says.

use coaxle_clock::time_sync::{SyncError, WrongParameter};
use coaxle_clock::{CycleTime, Instant, Remote, Seconds};
use coaxle_node::{AxisSample, FrameHeader};
use coaxle_remote::{
    AxisSyncParameters, CheckedParameters, Continuity, ContinuityState, FarAxis, FarAxisOutput,
    FarCorrection, FilterState,
};

use super::micros;
use crate::signals::FarAxisSignals;
use crate::slaves::Master;

/// A far axis.
#[derive(Debug)]
pub(super) struct Axis {
    block: FarAxis,
    continuity: Continuity,
    /// None until it comes.
    sample: Option<AxisSample>,
    /// The sender's cycle count that it came with.
    count: u64,
    /// Own cycles since it was to come and did not.
    missing_cycles: u32,
    missing: u64,
    error: Option<SyncError>,
}

impl Axis {
    pub(super) fn new(
        cycle_time: CycleTime,
        parameters: &AxisSyncParameters,
    ) -> Result<Self, WrongParameter> {
        Ok(Self {
            block: FarAxis::start(cycle_time.span(), parameters)?,
            continuity: Continuity::new(cycle_time.span(), parameters.extrapolate.blending_time),
            sample: None,
            count: 0,
            missing_cycles: 0,
            missing: 0,
            error: None,
        })
    }

    /// Its node's clock was started anew.
    pub(super) fn restart(&mut self) {
        self.block.restart();
        self.continuity.rejoin();
    }

    /// What its node's clock says next has nothing to do with what it said: the axis is brought there.
    pub(super) const fn rejoin(&mut self) {
        self.continuity.rejoin();
    }

    /// Another run of its node: what it was before says nothing of where it is now.
    pub(super) fn forget(&mut self) {
        self.sample = None;
        self.block.begin_anew();
        self.continuity.rejoin();
    }

    /// Its node's clock starts anew by an order; the set values go on from where they are.
    pub(super) const fn re_initialise(&mut self) {
        self.block.re_initialise();
    }

    /// The set values go on from where they are, whatever an order changes.
    pub(super) const fn carry_on(&mut self) {
        self.block.carry_on();
    }

    /// Changes the parameters; the set values go on from where they are.
    pub(super) fn set_parameters(&mut self, parameters: &CheckedParameters) {
        self.block.set_parameters(parameters);
    }

    /// What the newest frame, with this count, says of it.
    pub(super) const fn take(&mut self, sample: Option<AxisSample>, count: u64) {
        if sample.is_some() {
            self.sample = sample;
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

    /// One cycle; none as long as it has not come. Without news for too long it `is_lost`.
    pub(super) fn cycle(
        &mut self,
        header: &FrameHeader,
        correction: &FarCorrection,
        elapsed: u32,
        is_lost: bool,
        signals: &mut FarAxisSignals,
    ) -> Option<Master> {
        if !is_lost && self.continuity.state() == ContinuityState::Braking {
            self.block.begin_anew();
        }
        let Some(sample) = &self.sample else {
            *signals = FarAxisSignals {
                missing: self.missing,
                ..FarAxisSignals::default()
            };
            return None;
        };
        let mut moved = self.block.update(&sample.set, correction, elapsed);
        moved.set = match is_lost {
            true => self.continuity.brake(elapsed).unwrap_or(moved.set),
            false => self.continuity.follow(&moved.set, elapsed),
        };
        let continuity = self.continuity.state();
        moved.synced &= continuity == ContinuityState::Following;
        self.error = moved.error;
        *signals = self.show(header, sample, &moved);
        let error = moved.error.map_or(0, |error| error.code().into());
        let error_code = if error == 0 { sample.error_code } else { error };
        Some(Master {
            set: moved.set,
            is_sound: error_code == 0,
            is_ready: false,
            error_code: error,
        })
    }

    /// Its error in the newest cycle, its clock's included.
    pub(super) const fn error(&self) -> Option<SyncError> {
        self.error
    }

    fn show(
        &self,
        header: &FrameHeader,
        sample: &AxisSample,
        moved: &FarAxisOutput,
    ) -> FarAxisSignals {
        FarAxisSignals {
            state: Some(moved.state.into()),
            continuity: self.continuity.state().into(),
            synced: moved.synced,
            error: moved.error.map_or(0, |error| error.code()),
            age_cycles: 0,
            missing: self.missing,
            received_error: sample.error_code,
            received_position: Some(sample.set.position),
            received_velocity: Some(sample.set.velocity),
            corrected_position: Some(moved.set.position),
            corrected_velocity: Some(moved.set.velocity),
            position_diff: Some(moved.diagnostic.position_diff),
            velocity_diff: Some(moved.diagnostic.velocity_diff),
            correction_us: micros(moved.correction_time),
            far_time_ns: far_time(header, self.count, moved)
                .filter(|_| self.continuity.state() == ContinuityState::Following)
                .map(Instant::as_nanos),
        }
    }
}

/// The sender's ideal time that corrected set values stand for, received with this count.
fn far_time(header: &FrameHeader, count: u64, moved: &FarAxisOutput) -> Option<Instant<Remote>> {
    let sent = Instant::EPOCH + header.cycle_time.span() * count as i64;
    match moved.state {
        FilterState::Bypass => Some(sent),
        FilterState::Pt1 => None,
        FilterState::Sync | FilterState::Time | FilterState::Observer => {
            Some(sent + moved.correction_time?.to_span())
        }
    }
}
