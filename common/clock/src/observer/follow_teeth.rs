//! The line through the lower corners of teeth.

use super::PhaseObserver;
use super::events::{Jump, ShownDrift, bounds, cell_of, lowest_level, within_cell};
use super::line::Estimate;
use super::stream::{BLOCK, Stream};
use crate::instant::{Instant, Local};

impl PhaseObserver {
    /// Reports whether a jump of the phase is a tooth. Then only corners count from now on.
    pub(super) fn is_tooth(&mut self, newest: i64, jump: f64) -> bool {
        let Some(stream) = &mut self.stream else {
            return false;
        };
        let cycle = self.seconds_per_count;
        if stream.resolution.polled() > 0.0 {
            return false;
        }
        let Some(cell) = cell_of(jump, cycle, self.jitter.width()) else {
            return false;
        };
        let level = stream.expected(newest, cycle);
        stream.teeth.take(Jump {
            time: newest as f64 * cycle,
            size: jump,
            level,
        });
        let is_tooth = match stream.echo.is_missing() {
            // The echo decides where it is known: a path that jumps regularly still echoes late sending.
            Some(is_missing) => is_missing,
            None => stream.teeth.return_regularly(),
        };
        if is_tooth {
            stream.resolution.set_polled(cell);
            // The line of all messages has just been moved up by the jump, and the corner is below it.
            self.begin_at_corner(newest, jump, -jump.max(0.0));
        }
        is_tooth
    }

    /// Takes the block that is full where arrivals are polled for: a corner is a measurement, and a level says nothing.
    /// Returns whether they are.
    pub(super) fn take_level(&mut self, arrived: Instant<Local>) -> bool {
        let Some(stream) = &mut self.stream else {
            return false;
        };
        stream.echo.judge();
        let polled = stream.resolution.polled();
        let is_unseen = stream.echo.is_missing() == Some(true) && polled == 0.0;
        let unseen = if is_unseen {
            // Nothing is known of the poller but that it keeps up: it polls once a cycle at least.
            self.seconds_per_count
        } else {
            stream.waits.open(self.seconds_per_count)
        };
        stream.choice.cells_unseen(unseen);
        if stream.line.is_none() || polled == 0.0 {
            return false;
        }
        let values: [f64; BLOCK] = core::array::from_fn(|n| stream.block[n].value);
        if stream.teeth.is_known() {
            let middle = stream.middle();
            stream.filled = 0;
            take_corner(stream, &values, middle, self.seconds_per_count);
            self.choose_line(arrived, middle);
            return true;
        }
        // The grid shows by this block, the first that is not level.
        let newest = stream.block[stream.filled.saturating_sub(1)].count;
        stream.filled = 0;
        let largest = values
            .into_iter()
            .max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let jump = largest.unwrap_or(0.0);
        stream.teeth.take(Jump {
            time: newest as f64 * self.seconds_per_count,
            size: jump,
            level: 0.0,
        });
        self.begin_at_corner(newest, jump, jump.min(0.0));
        true
    }

    /// Restarts the line at the corner where phases jumped: `beside` the line of all messages as it now is at the
    /// newest message, s.
    fn begin_at_corner(&mut self, newest: i64, jump: f64, beside: f64) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        let Some(line) = &stream.line else {
            return;
        };
        let ShownDrift { drift, sigma } = stream.teeth.shown_drift();
        let before = *line.bank.combined();
        let ahead = newest.saturating_sub(line.at) as f64 * self.seconds_per_count;
        let cell = stream.resolution.polled();
        let offset = before.offset + before.drift * ahead + beside;
        stream
            .teeth
            .begin(offset + jump.max(0.0), cell, self.jitter.width());
        let estimate = Estimate {
            offset,
            drift,
            offset_variance: stream.teeth.corner_variance(),
            covariance: 0.0,
            drift_variance: sigma * sigma,
        };
        let since = stream.teeth.since();
        self.begin_line_anew(newest, &estimate, drift - before.drift);
        if let Some(line) = self.stream.as_mut().and_then(|stream| stream.line.as_mut()) {
            line.bounds = bounds(cell, cell);
        }
        let change = &mut self.drift_change;
        // Teeth that were taken for steps of the path have made the delay longer, each by a cell.
        change.taken_back.0 += change.attributed.since(since);
        change.attributed.forget();
    }
}

/// Takes the corner in a block of this mean count into the line, if there is one.
fn take_corner(stream: &mut Stream, values: &[f64; BLOCK], middle: i64, seconds_per_count: f64) {
    let Some(line) = &mut stream.line else {
        return;
    };
    let cell = stream.resolution.polled();
    let dt = middle.saturating_sub(line.at).max(0) as f64 * seconds_per_count;
    let estimate = *line.bank.combined();
    let expected = estimate.offset + estimate.drift * dt;
    let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let level = expected + lowest_level(values, cell);
    let known = estimate.offset_variance_after(dt, line.bank.drift_walk());
    if let Some(corner) = stream.teeth.corner(level, highest - lowest, cell) {
        stream.teeth.learn(corner - expected, known);
        line.at = line.at.max(middle);
        line.bank
            .observe(dt, corner, stream.teeth.corner_variance());
    } else if let Some(border) = stream.teeth.border_left(expected, known, level, cell)
        && dt > 0.0
    {
        let drift = (border - estimate.offset) / dt;
        line.bank.begin_anew(&Estimate { drift, ..estimate });
    }
    let ahead = middle.saturating_sub(line.at).max(0) as f64 * seconds_per_count;
    let (estimate, walk) = (line.bank.combined(), line.bank.drift_walk());
    let sigma = libm::sqrt(within_cell(estimate, ahead, walk, cell));
    let corner = libm::sqrt(stream.teeth.corner_variance());
    line.bounds = bounds(cell, corner + sigma);
}
