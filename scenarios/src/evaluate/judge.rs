//! One receiver, judged cycle by cycle.

use std::collections::VecDeque;

use coaxle_clock::{CycleTime, Instant, Span};
use coaxle_receiver::config::GearConfig;
use coaxle_receiver::{DriveStateName, ReceiverConfig, ReceiverRecord};
use coaxle_sim::{Oracle, Truth};

use super::cuts::{self, Truth as _};
use super::drift::DriftTruth;
use super::lag::Lag;
use super::moments::Moments;
use super::slave::SlaveJudge;
use super::{Master, Reference, Row};
use crate::curves::Curves;
use crate::summary::ReceiverSummary;
use crate::topology::Root;

/// Cycles after the first data from which a receiver that never synchronises is judged.
const SETTLING: u64 = 100;

/// Judges one receiver.
#[derive(Debug)]
pub(super) struct Judge {
    motion: usize,
    clock: usize,
    root: Root,
    /// From the master to the first slave, where gears alone couple it.
    gear: Option<GearConfig>,
    slaves: Vec<SlaveJudge>,
    cycle_time: CycleTime,
    synchronises: bool,
    /// Cycles whose truth is not known yet.
    pub(super) waiting: VecDeque<ReceiverRecord>,
    previous: Option<Previous>,
    first_data: Option<(i64, u64)>,
    evaluating: bool,
    ripple: Moments,
    time_error: Moments,
    lag: Lag,
    fastest_master: f64,
    drift: DriftTruth,
    was_synced: bool,
    was_error: u16,
    curves: Curves,
    summary: ReceiverSummary,
}

/// The cycle before, as far as differences need it.
#[derive(Clone, Copy, Debug)]
struct Previous {
    at_ns: i64,
    slave_position: Option<f64>,
    true_position: Option<f64>,
    epoch: Option<u64>,
    evaluated: bool,
}

/// Times of events that are kept.
const MOST_TIMES: usize = 1_000;

impl Judge {
    pub(super) fn new(config: &ReceiverConfig, motion: usize, clock: usize, root: Root) -> Self {
        let mode = config.mode.name();
        let slaves = config.slaves.iter().map(|slave| slave.name.as_str());
        Self {
            motion,
            clock,
            root,
            gear: config.gear_to(0),
            slaves: slaves_of(config),
            cycle_time: config.cycle_time_us.0,
            synchronises: config.mode.synchronises(),
            waiting: VecDeque::new(),
            previous: None,
            first_data: None,
            evaluating: false,
            ripple: Moments::default(),
            time_error: Moments::default(),
            lag: Lag::default(),
            fastest_master: 0.0,
            drift: DriftTruth::default(),
            was_synced: false,
            was_error: 0,
            curves: Curves::new(config.name.as_str(), mode, slaves),
            summary: ReceiverSummary {
                mode,
                master: master_of(config),
                ..ReceiverSummary::default()
            },
        }
    }

    pub(super) fn is_known(&self, masters: &[Master], at: Instant<Reference>) -> bool {
        [self.motion, self.clock]
            .iter()
            .filter_map(|n| masters[*n].oracle.known_until())
            .all(|until| at <= until)
    }

    pub(super) fn judge(
        &mut self,
        record: ReceiverRecord,
        masters: &[Master],
        start: Instant<Reference>,
    ) -> Row {
        let at = Instant::from_nanos(record.at_ns);
        let far = FarAxis {
            oracle: &masters[self.motion].oracle,
            gear: self.root.gear,
            start,
        };
        let truth = far.oracle.at(at);
        let clock = masters[self.clock].oracle.at(at);
        let master = truth.and_then(|truth| far.moves(&truth));
        let epoch = truth.map(|truth| truth.epoch);
        let set_velocity = self.difference(
            &record,
            |previous| previous.slave_position,
            record.slave.position,
        );
        let row = Row {
            t_s: far.time(at),
            time_error_us: time_error_us(&record, clock.as_ref(), master),
            record,
            truth: master,
            set_velocity,
        };
        let record = &row.record;
        self.note_events(&row);
        self.count(record);
        for (judge, slave) in self.slaves.iter_mut().zip(record.slaves()) {
            judge.push(record, slave, &far);
        }
        self.note_sync(&row);
        if let Some(clock) = &clock {
            let own = self.cycle_time.as_secs_f64() * record.cycle as f64;
            self.drift.push(at, clock, own);
        }
        if self.evaluating {
            self.measure(&row, epoch);
            // Of a receiver that is followed the run is not known.
            let chained = self.clock != self.motion;
            let is_heard = chained || epoch.is_some_and(|epoch| record.epoch == Some(epoch));
            self.lag
                .push(&row, is_heard, self.gear, self.fastest_master);
        }
        self.curves.push(&row, self.evaluating);
        self.previous = Some(Previous {
            at_ns: record.at_ns,
            slave_position: record.slave.position,
            true_position: master.map(|(position, _)| position),
            epoch,
            evaluated: self.evaluating,
        });
        row
    }

    /// The rate of a position since the previous cycle.
    fn difference(
        &self,
        record: &ReceiverRecord,
        before: impl Fn(&Previous) -> Option<f64>,
        now: Option<f64>,
    ) -> Option<f64> {
        let previous = self.previous.as_ref()?;
        let passed = Span::from_nanos(record.at_ns - previous.at_ns).as_secs_f64();
        (passed > 0.0).then_some((now? - before(previous)?) / passed)
    }

    /// When the observer noticed jumps, or began to lock anew.
    fn note_events(&mut self, row: &Row) {
        let (summary, record) = (&mut self.summary, &row.record);
        let events = [
            (record.shifts, summary.shifts, &mut summary.shift_times_s),
            (record.relocks, summary.relocks, &mut summary.relock_times_s),
        ];
        for (now, before, times) in events {
            if u64::from(now) > before && times.len() < MOST_TIMES {
                times.push(row.t_s);
            }
        }
    }

    fn count(&mut self, record: &ReceiverRecord) {
        let summary = &mut self.summary;
        summary.cycles += 1;
        summary.overruns = record.overruns;
        summary.received = record.received;
        summary.lost = record.lost;
        summary.duplicates = record.duplicates;
        summary.late = record.late;
        summary.stale = record.stale;
        summary.rejected = record.rejected;
        summary.restarts = record.restarts;
        summary.beats = record.beats.into();
        summary.drift_ppm = record.drift_ppm;
        summary.observer_state = record.observer;
        summary.drift_uncertainty_ppm = record.drift_sigma_ppm;
        summary.offset_uncertainty_us = record.offset_sigma_us;
        summary.random_walk_ppm = record.random_walk_ppm;
        summary.block_length = record.block_length;
        summary.shifts = record.shifts.into();
        summary.relocks = record.relocks.into();
        summary.delay_state = record.delay;
        summary.delay_us = record.delay_us;
        summary.delay_uncertainty_us = record.delay_uncertainty_us;
        summary.exchanges = record.exchanges;
        summary.answers_refused = record.answers_refused;
        summary.synced_at_end = record.synced;
        summary.drive_tripped |= record.slave.drive_state == DriveStateName::Tripped;
        summary.following_error_max = summary
            .following_error_max
            .max(record.slave.following_error.abs());
        let woke = Span::from_nanos(record.woke_ns - record.at_ns).as_micros_f64();
        summary.wake_up_max_us = summary.wake_up_max_us.max(woke);
        if record.error != 0 && record.error != self.was_error {
            summary.errors += 1;
            summary.last_error = Some(format!("0x{:04x}", record.error));
        }
        self.was_error = record.error;
    }

    /// Decides from when on the receiver is judged.
    fn note_sync(&mut self, row: &Row) {
        let record = &row.record;
        if record.count.is_none() {
            return;
        }
        let (first_ns, first_cycle) = *self.first_data.get_or_insert((record.at_ns, record.cycle));
        if record.synced && !self.was_synced {
            self.summary.synced_times += 1;
        }
        self.was_synced = record.synced;
        let begins = if self.synchronises {
            record.synced
        } else {
            record.cycle >= first_cycle + SETTLING
        };
        if begins && !self.evaluating {
            self.evaluating = true;
            self.summary.evaluated_from_s = Some(row.t_s);
            if self.synchronises {
                let took = Span::from_nanos(record.at_ns - first_ns);
                self.summary.time_to_sync_s = Some(took.as_secs_f64());
                self.summary.beats_at_sync = Some(record.beats);
            }
        }
    }

    fn measure(&mut self, row: &Row, epoch: Option<u64>) {
        self.summary.evaluated_cycles += 1;
        if let Some(error) = row.time_error_us {
            self.time_error.push(error);
        }
        let Some((position, velocity)) = row.truth else {
            return;
        };
        self.fastest_master = self.fastest_master.max(velocity.abs());
        let Some(GearConfig { ratio, offset }) = self.gear else {
            return;
        };
        let drive_error = (row.record.slave.drive_position - (ratio * position + offset)).abs();
        let worst = self.summary.drive_position_error_max.get_or_insert(0.0);
        *worst = worst.max(drive_error);
        // Over the same stretch as the set position's difference, and both its ends must count; a
        // master that was started anew has no velocity from one run to the next.
        let counts = self
            .previous
            .is_some_and(|previous| previous.evaluated && previous.epoch == epoch);
        let truly = self.difference(
            &row.record,
            |previous| previous.true_position,
            Some(position),
        );
        if let (Some(set), Some(truly), true) = (row.set_velocity, truly, counts) {
            self.ripple.push(set / ratio - truly);
        }
    }

    pub(super) fn finish(mut self) -> (String, ReceiverSummary, Curves) {
        let summary = &mut self.summary;
        summary.drift_ppm_true = self.drift.ppm();
        if self.ripple.count > 0 {
            summary.velocity_ripple_rms = Some(self.ripple.root_mean_square());
            let worst = self.ripple.largest_magnitude();
            summary.velocity_ripple_max = Some(worst);
            summary.velocity_ripple_ratio =
                (self.fastest_master > 0.0).then(|| worst / self.fastest_master);
        }
        if self.time_error.count > 0 {
            summary.corrected_time_error_rms_us = Some(self.time_error.deviation());
            summary.corrected_time_error_max_us = Some(self.time_error.largest_deviation());
            summary.lag_us = Some(-self.time_error.mean);
        }
        self.lag.conclude(summary);
        summary.slaves = self.slaves.into_iter().map(SlaveJudge::finish).collect();
        (self.curves.name.clone(), self.summary, self.curves)
    }
}

/// What a receiver follows, as it truly was.
struct FarAxis<'a> {
    oracle: &'a Oracle<Reference>,
    gear: Option<GearConfig>,
    start: Instant<Reference>,
}

impl FarAxis<'_> {
    /// Position and velocity, for those of the axis at the root.
    fn moves(&self, root: &Truth) -> Option<(f64, f64)> {
        let GearConfig { ratio, offset } = self.gear?;
        Some((ratio * root.position + offset, ratio * root.velocity))
    }
}

impl cuts::Truth for FarAxis<'_> {
    fn far_position(&self, at: Instant<Reference>) -> Option<f64> {
        let (position, _) = self.moves(&self.oracle.at(at)?)?;
        Some(position)
    }

    fn time(&self, at: Instant<Reference>) -> f64 {
        (at - self.start).as_secs_f64()
    }
}

fn slaves_of(config: &ReceiverConfig) -> Vec<SlaveJudge> {
    let slaves = &config.slaves;
    let judged = slaves.iter().map(|slave| SlaveJudge::new(slave, slaves));
    judged.collect()
}

fn master_of(config: &ReceiverConfig) -> String {
    let master = &config.master;
    let key = master.node.channel_key(master.channel.into());
    format!("{key}/{}", master.axis)
}

/// Corrected minus true far time. Where a filter smears it the position tells, if it moves.
fn time_error_us(
    record: &ReceiverRecord,
    clock: Option<&Truth>,
    master: Option<(f64, f64)>,
) -> Option<f64> {
    if let Some(far_time) = record.far_time() {
        return clock.map(|truth| truth.error_of(far_time).as_micros());
    }
    let (position, velocity) = master?;
    let corrected = record.corrected_position?;
    (velocity.abs() > 1e-9).then(|| (corrected - position) / velocity * 1e6)
}
