//! Figures of a receiver, cycle by cycle, and those of the whole run.

use coaxle_clock::Span;
use coaxle_receiver::DriveState;
use coaxle_receiver::config::GearConfig;

use super::{Previous, ReceiverJudge};
use crate::evaluate::followed_motion::seconds;
use crate::evaluate::moments::Moments;
use crate::evaluate::skipped::SkippedCycles;
use crate::evaluate::watch::ReceiverWatch;
use crate::record::ReceiverCycle;
use crate::row::Row;
use crate::summary::{LastSignals, ReceiverSummary};

/// Cycles after the first data from which a receiver that never synchronises is judged.
// Longer than the blend of 60 ms at cycles of 1 ms, and than the 90 cycles over which TS5066 blends a correction.
const SETTLING: u64 = 100;
/// Times of events that are kept.
// Each is a number in `summary.json`: a link that shifts all the time must not fill it.
const MOST_TIMES: usize = 1_000;

impl ReceiverJudge {
    /// The rate of a position since the previous cycle.
    pub(super) fn difference(
        &self,
        record: &ReceiverCycle,
        before: impl Fn(&Previous) -> Option<f64>,
        now: Option<f64>,
    ) -> Option<f64> {
        let previous = self.previous.as_ref()?;
        let passed = Span::from_nanos(record.at_ns - previous.at_ns).as_secs_f64();
        // A restarted receiver may begin at the instant of the cycle before, and a quotient over no time is none.
        (passed > 0.0).then_some((now? - before(previous)?) / passed)
    }

    /// Notes times of take-overs, jumps and relocks of the observer.
    pub(super) fn note_events(&mut self, row: &Row) {
        let (summary, record) = (&mut self.summary, &row.record);
        let before = self.last.as_ref().map(|last| &last.far);
        let take_overs = before.map_or(0, |far| far.take_overs);
        if record.far.take_overs > take_overs && summary.take_over_times_s.len() < MOST_TIMES {
            summary.take_over_times_s.push(row.t_s);
        }
        // Each node has its own counters.
        let same = self.last.as_ref().filter(|last| last.place == record.place);
        let before = same.map(|last| &last.far);
        let (shifts, relocks) = match before {
            // Greater than any counter, so that counters of another node are no events.
            None if self.last.is_some() => (u32::MAX, u32::MAX),
            before => before.map_or((0, 0), |far| (far.shifts, far.relocks)),
        };
        let events = [
            (record.far.shifts, shifts, &mut summary.shift_times_s),
            (record.far.relocks, relocks, &mut summary.relock_times_s),
        ];
        for (now, before, times) in events {
            if now > before && times.len() < MOST_TIMES {
                times.push(row.t_s);
            }
        }
    }

    pub(super) fn count(&mut self, record: &ReceiverCycle) {
        let summary = &mut self.summary;
        summary.cycles += 1;
        // Overwritten in each cycle: the last one stays.
        summary.synced_at_end = record.axis.synced;
        if let Some(slave) = record.slave() {
            summary.drive_tripped |= slave.drive_state == DriveState::Tripped;
            let following_error = slave.following_error.abs();
            summary.following_error_max = summary.following_error_max.max(following_error);
        }
        let woke = Span::from_nanos(record.woke_ns - record.at_ns).as_micros_f64();
        summary.wake_up_max_us = summary.wake_up_max_us.max(woke);
        // An error stays shown for as long as it lasts, and counts once.
        if record.axis.error != 0 && record.axis.error != self.was_error {
            summary.errors += 1;
            summary.last_error = Some(format!("0x{:04x}", record.axis.error));
        }
        self.was_error = record.axis.error;
        let warning = record.far.warning;
        summary.warnings += u64::from(warning != 0 && warning != self.was_warning);
        self.was_warning = warning;
    }

    /// Decides from which cycle on the receiver is judged.
    pub(super) fn note_sync(&mut self, row: &Row) {
        let record = &row.record;
        // A receiver waits for its first frame for any time: that is no time to sync.
        if record.far.count.is_none() && !self.is_virtual() {
            return;
        }
        let (first_ns, first_cycle) = *self
            .first_data
            .get_or_insert((record.at_ns, record.node.cycle));
        if record.axis.synced && !self.was_synced {
            self.summary.synced_times += 1;
        }
        self.was_synced = record.axis.synced;
        let begins = if self.synchronises {
            record.axis.synced
        } else {
            record.node.cycle >= first_cycle + SETTLING
        };
        // Evaluated from then on, also while it is out of sync: a loss of sync is part of the result.
        if begins && !self.evaluating {
            self.evaluating = true;
            self.summary.evaluated_from_s = Some(row.t_s);
            if self.synchronises {
                let took = Span::from_nanos(record.at_ns - first_ns);
                self.summary.time_to_sync_s = Some(seconds(took));
                self.summary.beats_at_sync = Some(record.far.beats);
            }
        }
    }

    pub(super) fn measure(&mut self, row: &Row, epoch: Option<u64>, is_settled: bool) {
        self.summary.evaluated_cycles += 1;
        if let Some(error) = row.time_error_us {
            self.time_error.push(error, is_settled);
        }
        let Some((position, velocity)) = row.truth else {
            return;
        };
        self.fastest_master = self.fastest_master.max(velocity.abs());
        // A cam or a saw has no ratio by which the slave's velocity could be compared.
        let Some(GearConfig { ratio, .. }) = self.gear else {
            return;
        };
        if row.record.slave().is_none() {
            return;
        }
        // Over the stretch of the set position's difference, and both its ends must count; a
        // restarted master has no velocity from one run to the next.
        let counts = self.previous.is_some_and(|previous| {
            previous.evaluated && previous.epoch == epoch && previous.place == row.record.place
        });
        let truly = self.difference(
            &row.record,
            |previous| previous.true_position,
            Some(position),
        );
        if let (Some(set), Some(truly), true) = (row.set_velocity, truly, counts) {
            // In units of the master, so that gears of any ratio compare.
            self.ripple.push(set / ratio - truly, is_settled);
        }
    }

    /// Measures the distances of the drive, and of what it is given, from the position by the master's.
    pub(super) fn measure_drive(&mut self, row: &Row, master: Option<(f64, f64)>) {
        let (Some((position, _)), Some(slave)) = (master, row.record.slave()) else {
            return;
        };
        // Present only if a gear leads to the drive: 0 would claim a perfect one.
        let Some(GearConfig { ratio, offset }) = self.gear else {
            return;
        };
        let wanted = ratio * position + offset;
        let dead_time = self.dead_time.simulated;
        let summary = &mut self.summary;
        let worst = summary.drive_position_error_max.get_or_insert(0.0);
        *worst = worst.max((slave.drive_position - wanted).abs());
        if let Some(given) = slave.shown_position {
            // Behind a dead time it is what the drive follows by now, of all that it was given.
            let shown = match dead_time {
                Span::ZERO => given,
                _ => slave.drive_position + slave.following_error,
            };
            let worst = summary.shown_position_error_max.get_or_insert(0.0);
            *worst = worst.max((shown - wanted).abs());
        }
    }

    pub(in crate::evaluate) fn finish(
        mut self,
        watches: &[ReceiverWatch],
        skipped: &SkippedCycles,
    ) -> (String, ReceiverSummary) {
        let summary = &mut self.summary;
        if let Some(last) = &self.last {
            let ReceiverCycle {
                node, far, axis, ..
            } = **last;
            summary.last = LastSignals { node, far, axis };
            if let Some(heard) = self.view.nodes.get(last.place) {
                // A cycle that never was is none that the network lost.
                // A run that ends in a gap counts its last cycles as skipped before the receiver counts them as lost.
                let skipped = skipped.of(self.view.receiver, *heard).min(far.lost);
                summary.skipped_by_sender = skipped;
                summary.last.far.lost -= skipped;
            }
        }
        summary.drift_ppm_true = self.drift.ppm();
        self.frame_ages.show(summary);
        let share = |ripple: f64| (self.fastest_master > 0.0).then(|| ripple / self.fastest_master);
        let ripple = &self.ripple;
        if ripple.all.count > 0 {
            summary.velocity_ripple_rms = Some(ripple.all.root_mean_square());
            let worst = ripple.all.largest_magnitude();
            summary.velocity_ripple_max = Some(worst);
            summary.velocity_ripple_ratio = share(worst);
        }
        summary.velocity_ripple_settled_rms = ripple.once_settled(Moments::root_mean_square);
        summary.velocity_ripple_settled_max = ripple.once_settled(Moments::largest_magnitude);
        summary.velocity_ripple_settled_ratio = summary.velocity_ripple_settled_max.and_then(share);
        summary.velocity_ripple_lock_in_max = ripple.locking_in(0.0);
        let error = &self.time_error;
        if error.all.count > 0 {
            summary.corrected_time_error_rms_us = Some(error.all.deviation());
            summary.corrected_time_error_max_us = Some(error.all.largest_deviation());
            // A time behind the true one has a negative error and a positive lag.
            summary.lag_us = Some(-error.all.mean);
        }
        summary.corrected_time_error_settled_rms_us = error.once_settled(Moments::deviation);
        summary.corrected_time_error_settled_max_us =
            error.once_settled(Moments::largest_deviation);
        let centre = error.once_settled(|settled| settled.mean);
        summary.corrected_time_error_lock_in_max_us =
            // Against the settled mean: the mean with the lock-in in it would hide a part of the lock-in.
            error.locking_in(centre.unwrap_or(error.all.mean));
        self.lag.conclude(summary);
        let watch = &watches[self.view.receiver];
        let shares = self.view.slaves.iter().map(|n| watch.shares(*n));
        let slaves = self.slaves.into_iter().zip(shares);
        summary.slaves = slaves.map(|(slave, shares)| slave.finish(shares)).collect();
        (self.view.name, self.summary)
    }
}
