//! Signals of a far clock.

use coaxle_clock::far_clock::{CommonTimeOutput, FarClockOutput};
use coaxle_clock::time_sync::TimeSyncState;
use coaxle_clock::{Instant, Local, Seconds, Span};

use super::clock::ClockOutput;
use super::micros;
use crate::signals::FarNodeSignals;

impl ClockOutput {
    /// Writes its signals without an observer.
    pub(super) fn show(&self, signals: &mut FarNodeSignals) {
        let correction = &self.correction;
        let time_sync = &correction.time_sync;
        let diagnostic = &time_sync.diagnostic;
        signals.synced = correction.synced && correction.error.is_none();
        signals.error = correction.error.map_or(0, |error| error.code());
        signals.warning = correction.warning.map_or(0, |warning| warning.code());
        signals.beats = time_sync.beats;
        // A disabled clock has the diagnostic of none: its 0 ppm would pass for a measurement.
        signals.drift_ppm = Some(diagnostic.drift_ppm).filter(|_| self.enabled);
        signals.correction_us = micros(correction.time(correction.mode));
        signals.time_sync_correction_us = micros(time_sync.correction_time);
        signals.time_mode_correction_us = micros(time_sync.time_mode_correction);
        signals.time_mode = self.enabled && time_sync.state == TimeSyncState::StartUp;
        signals.cycle_index_diff = diagnostic.cycle_index_diff;
        signals.total_equal_data = diagnostic.total_equal_data;
        signals.consecutive_equal_data = diagnostic.consecutive_equal_data;
    }
}

/// Writes its signals with an observer.
pub(super) fn show_observation(observed: &FarClockOutput, signals: &mut FarNodeSignals) {
    let FarClockOutput {
        observer,
        delay,
        timing,
        common_time,
        ..
    } = observed;
    let seconds = |at: Instant<Local>| at.since_epoch().as_secs_f64();
    // Replaces the drift by beats, which needs minutes where the clocks differ by a few ppm.
    signals.drift_ppm = Some(observer.drift_ppm);
    signals.observer_state = Some(observer.state);
    signals.observer_line = Some(observer.line);
    signals.offset_sigma_us = Some(observer.offset_sigma.as_micros());
    signals.within_three_sigma = observer.within_three_sigma;
    signals.drift_sigma_ppm = Some(observer.drift_sigma_ppm);
    signals.slew_remaining_us = Some(observer.slew_remaining.as_micros());
    signals.normal_jitter_us = Some(observer.normal_jitter.as_micros());
    signals.exponential_jitter_us = Some(observer.exponential_jitter.as_micros());
    signals.random_walk_ppm = Some(observer.random_walk_ppm);
    signals.block_length = Some(observer.block_length);
    signals.shifts = observer.shifts;
    signals.drift_steps = observer.drift_steps;
    signals.last_shift_s = observer.last_shift.map(seconds);
    signals.relocks = observer.relocks;
    signals.last_relock_s = observer.last_relock.map(seconds);
    signals.delay_state = Some(delay.state);
    signals.delay_us = micros(delay.delay);
    signals.delay_uncertainty_us = micros(delay.uncertainty);
    signals.asymmetry_denied = delay.is_statement_denied;
    signals.delay_jitter_us = micros(delay.jitter);
    signals.delay_sigma_us = micros(delay.sigma);
    signals.delay_age_s = delay.age.map(Span::as_secs_f64);
    signals.exchanges = delay.exchanges;
    signals.responses_refused = delay.refused;
    signals.timing_state = Some(timing.state);
    signals.timing_sigma_us = micros(timing.sigma);
    signals.timing_round_trip_us = micros(timing.round_trip);
    signals.timing_age_s = timing.age.map(Span::as_secs_f64);
    signals.timing_exchanges = timing.exchanges;
    signals.timing_refused = timing.refused;
    signals.timing_restarts = timing.restarts;
    if let Some(common) = common_time {
        show_common_time(common, signals);
    }
}

fn show_common_time(common: &CommonTimeOutput, signals: &mut FarNodeSignals) {
    let timing = &common.timing;
    signals.common_time_state = Some(timing.state);
    signals.common_time_lack = Some(common.lack);
    signals.common_time_apart_us = micros(timing.apart);
    // Its exchanges take twice what both are off by.
    let bound = |round_trip: Seconds| 0.5 * round_trip.as_micros();
    signals.common_time_bound_us = timing.round_trip.map(bound);
    signals.common_time_sigma_us = micros(timing.sigma);
    signals.common_time_age_s = timing.age.map(Span::as_secs_f64);
    signals.common_time_readings = timing.exchanges;
    signals.common_time_restarts = timing.restarts;
}
