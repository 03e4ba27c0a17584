//! Signals of an axis.

use coaxle_clock::{Instant, Remote};
use coaxle_node::{AxisSample, FrameHeader};
use coaxle_remote::{FarAxisOutput, FilterState};

use super::super::micros;
use super::Axis;
use crate::signals::FarAxisSignals;

impl Axis {
    /// Returns its signals of a cycle.
    pub(super) fn show(
        &self,
        sample: &AxisSample,
        moved: &FarAxisOutput,
        far_time: Option<Instant<Remote>>,
    ) -> FarAxisSignals {
        let mut signals = FarAxisSignals {
            state: Some(moved.state),
            continuity: self.state(),
            synced: moved.synced,
            error: moved.error.map_or(0, |error| error.code()),
            // Filled in by the caller: the age is one of the frames, and not of the axis alone.
            age_cycles: 0,
            missing: self.missing,
            wraps: self.wraps.count,
            wrap_length: self.wraps.length,
            received_error: sample.error_code,
            received_position: Some(sample.set.position),
            received_velocity: Some(sample.set.velocity),
            received_acceleration: Some(sample.set.acceleration),
            corrected_position: Some(moved.set.position),
            corrected_velocity: Some(moved.set.velocity),
            position_diff: Some(moved.diagnostic.position_diff),
            velocity_diff: Some(moved.diagnostic.velocity_diff),
            correction_us: micros(moved.correction_time),
            interpolated: (self.presented.as_ref())
                .filter(|presented| presented.is_in_force())
                .map(|presented| presented.is_interpolated),
            extrapolated_cycles: (self.presented.as_ref())
                .map_or(0, |presented| presented.extrapolated),
            // On its way back an axis is at no instant of its master's motion.
            far_time_ns: far_time.filter(|_| self.follows()).map(Instant::as_nanos),
            ..FarAxisSignals::default()
        };
        if let Some(encoder) = &self.encoder {
            encoder.show(&mut signals);
        }
        signals
    }
}

/// Ideal time of the sender that corrected set values stand for, received with this count.
pub(super) fn far_time(
    header: &FrameHeader,
    count: u64,
    moved: &FarAxisOutput,
) -> Option<Instant<Remote>> {
    // Even 4·10¹⁰ cycles (the largest first count of a config) of 100 ms are 4·10¹⁸ ns, which fit into an i64.
    let sent = Instant::EPOCH + header.cycle_time.span() * count as i64;
    match moved.state {
        FilterState::Bypass => Some(sent),
        // A filtered value is a mean over many instants.
        FilterState::Pt1 => None,
        FilterState::Sync | FilterState::Time | FilterState::Observer => {
            Some(sent + moved.correction_time?.to_span())
        }
    }
}
