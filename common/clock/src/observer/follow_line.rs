//! Takes the phases of messages into both lines, and chooses the one that is followed.

use super::PhaseObserver;
use super::events::{Arrival, within_cell};
use super::line::{Edge, Estimate};
use super::output::Shown;
use super::stream::{BLOCK, Line, Residual};
use crate::instant::{Instant, Local, Span};
use crate::numbers::rounded;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the choice of a sure line.
    FollowLineTuning {
        /// Multiple of the scatter of points that counts as the jitter where the edge is followed.
        // The accuracy that is sure enough is a part of the jitter, and the edge is much sharper than that of single messages.
        edge_as_jitter: f64 = 24.0,
        /// Time, s, until which, where delays are correlated, only an accuracy that is fine anywhere is sure enough.
        correlation_known_after: f64 = 4.0,
        /// Time after which the best there is will do, s.
        longest_if_correlated: f64 = 8.0,
        /// The line is known where its variance is below this part of the one of a block.
        known: f64 = 0.5,
    }
}

/// Far time that is no further from the line than this is where it should be, s.
// Not tuned: until it is synchronised the far time is set to the line, and is off by nothing or by what the slew limit of locking
// leaves, which is more than this up to the cycle that makes up the rest.
const AT_THE_LINE: f64 = 1e-6;

/// The line that is followed.
pub(super) struct Followed {
    /// Count of the estimate since the first.
    pub(super) at: i64,
    pub(super) estimate: Estimate,
    /// The variance that the drift gains per second.
    pub(super) drift_walk: f64,
}

impl PhaseObserver {
    /// Takes the phase of a message into both lines.
    pub(super) fn take_phase(&mut self, arrival: &Arrival) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        let Arrival {
            count,
            at: arrived,
            send_stamp,
        } = *arrival;
        let count = count.wrapping_sub(stream.first_count) as i64;
        let gap = arrived - stream.newest_used;
        stream.newest_used = stream.newest_used.max(arrived);
        // Without a stamp the sender's lateness is part of the jitter.
        let sent = arrived - send_stamp.unwrap_or(Span::ZERO);
        let phase = sent - stream.first_arrival - self.data_cycle_time * count;
        // In whole nanoseconds up to here: a float of the time since the start loses them within months.
        let phase = phase.as_secs_f64();
        let value = phase - stream.expected(count, self.seconds_per_count);
        if stream.batches.are_picked_from() && stream.line.is_some() {
            stream.waits.take(value);
        }
        if let Some(stamp) = send_stamp {
            let stamp = stamp.as_secs_f64();
            stream.echo.take(count, phase + stamp, stamp);
        }
        let time = count as f64 * self.seconds_per_count;
        // The edge first, as the line of all messages may shift both by what this message completes.
        self.take_edge(time, phase, arrived);
        self.suspect_drift_step(time, phase, arrived);
        self.take_residual(Residual { count, value }, gap, arrived);
    }

    /// Takes a phase into the lower edge. Where it is followed, its jumps are the line's.
    fn take_edge(&mut self, time: f64, phase: f64, arrived: Instant<Local>) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        // The edge of teeth is no line.
        if stream.resolution.polled() > 0.0 {
            return;
        }
        stream.edge.observe(time, phase);
        let (jump, shift) = (stream.edge.take_jump(), stream.edge.take_shift());
        stream.choice.edge_jumped(jump);
        if let Some(shift) = shift {
            stream.choice.shift_edge(shift);
        }
        if stream.choice.is_edge() {
            // A better line of the same path: exchanges are corrected with it, and the delay moves with it.
            self.corrected.0 += jump;
            if let Some(shift) = shift {
                stream.calibration.shift(shift);
                // A longer path, until exchanges say otherwise: the delay takes it up.
                self.jumped.0 += shift;
                self.drift_change.attributed.note(time, shift);
                self.events.shift(arrived);
            }
        }
        if shift.is_some() {
            self.leave_staircase();
        }
    }

    /// Takes the residual of a message into the line of all messages; it came `gap` after the one before.
    fn take_residual(&mut self, residual: Residual, gap: Span, arrived: Instant<Local>) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        stream.resolution.take(residual.count, arrived);
        // Residuals of stamps on a grid are alike by the grid and say nothing of queues and of correlation.
        let coarse = self.jitter.cell() > 0.0 || stream.resolution.polled() > 0.0;
        let is_queue = gap * 2 < self.data_cycle_time;
        let held_up = !coarse && stream.is_held_up(residual.value, gap, is_queue);
        if !held_up {
            if !coarse {
                stream.choice.observe(residual.value);
            }
            stream.block[stream.filled] = residual;
            stream.filled += 1;
        }
        // Messages behind a queue are late by the one in front, so a run of them is no longer delay.
        let queued = held_up && is_queue;
        let shifted = stream.line.as_ref().is_some_and(|line| {
            !queued
                && self.detector.observe(
                    residual.value,
                    line.bounds,
                    arrived,
                    self.data_cycle_time,
                    self.shift_messages,
                )
        });
        if shifted {
            self.follow_shift(arrived, residual.count);
        } else if stream.block_is_full() {
            self.end_block(arrived);
        }
    }

    /// Returns the line that is followed: that of all messages, or their lower edge.
    pub(super) fn followed(&self) -> Option<Followed> {
        let stream = self.stream.as_ref()?;
        let line = stream.line.as_ref()?;
        let mut followed = match stream.edge.line() {
            Some(edge) if stream.choice.is_edge() => Followed {
                at: rounded(edge.at / self.seconds_per_count),
                estimate: edge.estimate,
                drift_walk: Edge::drift_walk(),
            },
            _ => Followed {
                at: line.at,
                estimate: *line.bank.combined(),
                drift_walk: line.bank.drift_walk(),
            },
        };
        followed.estimate.offset += stream.choice.carry();
        Some(followed)
    }

    fn end_block(&mut self, arrived: Instant<Local>) {
        if self.take_level(arrived) {
            return;
        }
        let Some(stream) = &mut self.stream else {
            return;
        };
        let middle = stream.middle();
        let values = stream.block.map(|residual| residual.value);
        stream.filled = 0;
        self.jitter.set_cell(stream.resolution.cell());
        let Some(line) = &mut stream.line else {
            let drift = self.parameters.expected_drift_ppm * 1e-6;
            stream.line = Some(Line::first(middle, &values, &mut self.jitter, drift));
            return;
        };
        // Held until the cause is clear: otherwise a step of the delay becomes a drift (+30 µs at 5/20: 22 ppm).
        if self.detector.is_suspected() {
            return;
        }
        // Stragglers may put the middle of a block before the line.
        let dt = (middle - line.at).max(0) as f64 * self.seconds_per_count;
        let estimate = *line.bank.combined();
        let walk = line.bank.drift_walk();
        let (expected, prior) = line.bank.agile(dt);
        let line_offset = estimate.offset + estimate.drift * dt;
        // The location stays where it was before the widths were learnt better, or far time would walk with them.
        let reference = expected - line_offset + self.jitter.moved();
        let mut residuals = [0.0; BLOCK];
        for (residual, value) in residuals.iter_mut().zip(values) {
            *residual = value - reference;
        }
        let location = self.jitter.locate(&residuals, prior);
        let variance = location.variance;
        let measured = expected + location.measured;
        // Residuals about a line that is not known would teach its error as jitter.
        let known = estimate.offset_variance_after(dt, walk) < TUNING.known * variance;
        // Where the line is not known, nothing would show that the widths fit again.
        if !known || !self.jitter.is_unfit() {
            line.at = line.at.max(middle);
            line.bank.observe(dt, measured, variance);
        }
        if known {
            let correlated = line.bank.correlated();
            (self.jitter).learn(&residuals, line_offset - expected, correlated);
        }
        line.bounds = Line::bounds(&line.bank, &self.jitter);
        self.choose_line(arrived, middle);
    }

    /// Chooses the line to follow after a block, and judges its uncertainty.
    pub(super) fn choose_line(&mut self, arrived: Instant<Local>, middle: i64) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        let Some(line) = &stream.line else {
            return;
        };
        let all = line.bank.combined();
        let age = (arrived - self.progress.since).as_secs_f64();
        let width = self.jitter.width();
        let mut variance = all.offset_variance + line.bank.bias_variance();
        let polled = stream.resolution.polled();
        if polled > 0.0 {
            let ahead = middle.saturating_sub(line.at).max(0) as f64 * self.seconds_per_count;
            // Beside a grid no filter is unsure by more than a cell.
            variance = within_cell(all, ahead, line.bank.drift_walk(), polled);
        } else if let Some(edge) = stream.edge.line() {
            let time = middle as f64 * self.seconds_per_count;
            self.corrected.0 += stream.choice.judge(time, age, all, edge, width);
            if stream.choice.is_edge() {
                variance = edge.estimate.offset_variance;
            }
        }
        let longest = self.parameters.longest_locking_s;
        let (jitter, longest) = match stream.choice.is_correlated() {
            false if !stream.choice.may_be_correlated() => (width, longest),
            // A sign of correlation and no proof: the jitter may be mostly delays that last.
            false => (0.0, longest),
            // It is not known as yet how long a delay may last.
            true if age < TUNING.correlation_known_after => (0.0, longest),
            // It does not become better by waiting longer.
            true => {
                let scatter = TUNING.edge_as_jitter * stream.edge.point_sigma();
                (
                    width.max(scatter),
                    longest.min(TUNING.longest_if_correlated),
                )
            }
        };
        let sigma = stream.choice.sigma(variance);
        let may_end = self.may_end_locking(arrived);
        (self.progress).judge(arrived, may_end, sigma, jitter, longest, &self.parameters);
        self.calibrate(middle, sigma);
    }

    /// Compares the line that is followed, of standard deviation `sigma`, with its own predictions, at a mean count.
    fn calibrate(&mut self, middle: i64, sigma: f64) {
        let Some(Followed {
            at,
            mut estimate,
            drift_walk,
        }) = self.followed()
        else {
            return;
        };
        let Some(stream) = self.stream.as_mut() else {
            return;
        };
        if stream.resolution.polled() > 0.0 {
            return;
        }
        let bias_variance = match &stream.line {
            Some(line) if !stream.choice.is_edge() => line.bank.lasting_bias_variance(),
            _ => stream.edge.lasting_bias_variance(),
        };
        stream.calibration.remember(bias_variance);
        let ahead = middle.saturating_sub(at) as f64 * self.seconds_per_count;
        if ahead > 0.0 {
            estimate.predict(ahead, drift_walk);
        } else {
            // Backwards a variance would shrink below what is known. The estimate is a little newer than the block.
            estimate.offset += estimate.drift * ahead;
        }
        let time = middle as f64 * self.seconds_per_count;
        (stream.calibration).look(time, &estimate, drift_walk, sigma);
        if stream.choice.is_edge() {
            stream.calibration.hold(sigma);
        }
    }

    /// True if locking may end: not on a backlog that comes all at once, and not before far time is where the line
    /// is, as it is slewed afterwards so slowly that it would take an hour.
    fn may_end_locking(&self, now: Instant<Local>) -> bool {
        let messages = i64::from(self.parameters.synced_messages);
        let is_there = |shown: &Shown| shown.remaining.0.abs() < AT_THE_LINE;
        // Half of the time that the messages take at their pace: a backlog comes within milliseconds.
        now - self.progress.since >= self.data_cycle_time * messages / 2
            && self.shown.as_ref().is_none_or(is_there)
    }
}
