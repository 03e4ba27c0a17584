//! Distance of the slave from its master's position at one true instant.

use coaxle_clock::delay::DelayState;
use coaxle_receiver::config::GearConfig;

use super::moments::Moments;
use super::watch::wanted_offset;
use crate::record::ReceiverCycle;
use crate::row::Row;
use crate::summary::ReceiverSummary;

/// Slower than this share of its highest velocity a master has no useful time error.
// Errors of the position that do not depend on the velocity count tenfold there, and without bound at rest.
const SLOW: f64 = 0.1;

/// The lag of one receiver, nothing removed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MasterLag {
    distance: Moments,
    far_position: Moments,
    far_motion: Moments,
    travel_us: Moments,
    far_time_us: Moments,
    /// Cycles with an uncertainty, and those in which it covered the error.
    judged: u64,
    covered: u64,
}

impl MasterLag {
    /// Takes a cycle of a settled receiver. `gear` makes the slave's position from the master's,
    /// if there is one; `fastest` is the master's highest velocity so far.
    pub(super) fn push(&mut self, row: &Row, gear: Option<GearConfig>, fastest: f64) {
        let record = &row.record;
        if let (Some(slave), Some((position, velocity)), Some(GearConfig { ratio, offset })) =
            (record.slave_position(), row.truth, gear)
        {
            let distance = (slave - offset) / ratio - position;
            self.distance.push(distance);
            if velocity.abs() > SLOW * fastest {
                self.travel_us.push(distance / velocity * 1e6);
            }
        }
        if let (Some(corrected), Some((position, velocity))) =
            (record.axis.corrected_position, row.truth)
        {
            // At rest, too, where a time has no error that shows.
            self.far_position.push(corrected - position);
            if let Some(error) = row.time_error_us {
                let by_time = velocity * error * 1e-6;
                self.far_motion.push(corrected - position - by_time);
            }
        }
        if let Some(error) = row.time_error_us {
            self.far_time_us.push(error);
            self.judge_uncertainty(record, error - wanted_offset(row));
        }
    }

    fn judge_uncertainty(&mut self, record: &ReceiverCycle, error: f64) {
        // A stale delay still states its uncertainty, and is judged by it.
        if let (Some(DelayState::Measured | DelayState::Stale), Some(uncertainty)) =
            (record.far.delay_state, record.far.delay_uncertainty_us)
        {
            self.judged += 1;
            self.covered += u64::from(error.abs() <= uncertainty);
        }
    }

    pub(super) fn conclude(&self, summary: &mut ReceiverSummary) {
        if self.distance.count > 0 {
            summary.lag_error_max = Some(self.distance.largest_magnitude());
        }
        if self.far_position.count > 0 {
            summary.far_position_error_max = Some(self.far_position.largest_magnitude());
            summary.far_position_error_rms = Some(self.far_position.root_mean_square());
        }
        if self.far_motion.count > 0 {
            summary.far_motion_error_max = Some(self.far_motion.largest_magnitude());
        }
        if self.travel_us.count > 0 {
            summary.lag_error_max_us = Some(self.travel_us.largest_magnitude());
            summary.lag_error_rms_us = Some(self.travel_us.root_mean_square());
        }
        if self.judged > 0 {
            summary.delay_error_us = Some(self.far_time_us.mean);
            summary.delay_covered_share = Some(self.covered as f64 / self.judged as f64);
        }
    }
}
