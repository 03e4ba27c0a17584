//! The lower edge of the phases: the line to follow where delays are correlated.
//!
//! Between processes the delay of a message depends on what the machines are doing: sleeping cores,
//! queues, other threads. For seconds all messages come some 10 µs later, and then they do not. A mean
//! over such a time is off by as much. But now and then a message meets no obstacle, and those lie on
//! a sharp *edge*, stable to tenths of a microsecond. So the lowest of each window of half a second is
//! a point; points on the edge lie on the clock's straight line and the others above it; and a line
//! that many points support, with few below, is the edge.
//!
//! [`Windows`] keeps the points, [`consensus`] finds the line that they support, and a Kalman filter
//! follows it from point to point, taking no notice of points that are not on it.

mod consensus;
mod noise;
mod windows;

use super::bias::Bias;
use super::filter::Estimate;
use crate::tuning::tuning;
use consensus::Candidate;
use noise::Noise;
use windows::{Point, Windows};

tuning! {
    /// Tuned constants of the edge.
    EdgeTuning {
        /// Standard deviations off the line from which a point is not on it.
        gate: f64 = 4.0,
        /// The random walk of the drift, s/s per √s.
        // A quartz at rest.
        drift_walk: f64 = 1e-8,
        /// Possible lateness of the first message, s.
        // A thread that slept.
        first_offset: f64 = 1e-4,
        /// Drift that is expected at first, s/s.
        // Quartzes are sold with 20 to 50 ppm.
        first_drift: f64 = 3e-5,
        /// Points in a row above the edge that are a delay that grew …
        // Half of those kept.
        late_points: u8 = 16,
        /// … over this time, s, that of sixteen full windows …
        // The first ones are shorter.
        late_for: f64 = 7.5,
        /// … and fewer, if they are all `far` above it, …
        far_points: u8 = 3,
        /// … over this time, s, that of two intervals of full windows.
        far_for: f64 = 0.9,
        /// Height above the edge that correlated delays seldom have, s.
        far: f64 = 1e-4,
        /// Steps in a row that may be a path which grows longer and longer, …
        // Of faults/terms, a ramp of 650 µs within 11 s is five of them.
        stairs: u8 = 6,
        /// … each at most this number of points after the one before.
        stair: u8 = 8,
        /// Points that make a line.
        enough: usize = 8,
        /// Points on the edge whose mean shows the latest bias of the line.
        bias_memory: f64 = 3.0,
        /// Standard deviations of that mean below which it is chance …
        unbiased: f64 = 2.0,
        /// … and below which it is not remembered.
        lasting_unbiased: f64 = 3.0,
    }
}

/// Follows the lower edge of the phases.
#[derive(Clone, Debug)]
pub(in crate::observer) struct Edge {
    windows: Windows,
    noise: Noise,
    line: Option<Line>,
    /// Jump from which it may be a sender that stood still, and is not followed here, s.
    skip: f64,
    /// Points in a row above the edge, with the height of the first and that of the lowest of the others, s. The
    /// first may be late by chance, or of a window in which the delay grew.
    late: u8,
    late_since: f64,
    first_late: f64,
    least_late: f64,
    /// Steps of the delay in a row, the time from which they came, s, and points since the last one.
    stairs: u8,
    stairs_from: f64,
    since_step: u8,
    /// Opening time of the first of their windows, and of the open one.
    late_from: f64,
    opened: f64,
    /// Jump of the path's delay, s.
    shifted: Option<f64>,
    /// Jumps of the line since [`Edge::take_jump`] was called last, s.
    jumped: f64,
    /// Bias of the line against the last points on the edge.
    bias: Bias,
}

/// A line and when its offset is due, s.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) struct Line {
    pub(in crate::observer) at: f64,
    pub(in crate::observer) estimate: Estimate,
}

impl Line {
    /// Offset of the line at a time.
    pub(in crate::observer) fn offset_at(&self, time: f64) -> f64 {
        self.estimate.offset + self.estimate.drift * (time - self.at)
    }
}

impl Edge {
    /// Makes the edge of messages with this period, s. Jumps of `skip` seconds and more are passed to it by
    /// [`shift`](Self::shift).
    pub(in crate::observer) fn new(seconds_per_count: f64, skip: f64) -> Self {
        Self {
            windows: Windows::new(seconds_per_count),
            noise: Noise::new(),
            line: None,
            skip,
            late: 0,
            late_since: 0.0,
            first_late: 0.0,
            least_late: f64::INFINITY,
            stairs: 0,
            stairs_from: 0.0,
            since_step: 0,
            late_from: 0.0,
            opened: f64::NEG_INFINITY,
            shifted: None,
            jumped: 0.0,
            bias: Bias::over(TUNING.bias_memory),
        }
    }

    /// The line, once enough points support one.
    pub(in crate::observer) fn line(&self) -> Option<&Line> {
        self.line
            .as_ref()
            .filter(|_| self.windows.len() >= TUNING.enough)
    }

    /// Time from which the line was moved up again and again, as beside one with another drift, s; none if it was not. Moved up with each few
    /// points the line keeps a wrong drift for ever: in swarm schedule 50718, 150 ppm for 90 s.
    pub(in crate::observer) fn staircase_from(&self) -> Option<f64> {
        (self.stairs > TUNING.stairs).then_some(self.stairs_from)
    }

    /// Scatter of a point, s.
    pub(in crate::observer) fn point_sigma(&self) -> f64 {
        libm::sqrt(self.noise.near())
    }

    /// Square of the line's bias, as far as the last points on the edge show it, s²: where the sender's clock is
    /// steered all the time, points lie on its course and not on a straight line.
    pub(in crate::observer) fn bias_variance(&self) -> f64 {
        self.bias.variance_beyond(TUNING.unbiased)
    }

    /// Square of the bias beyond chance.
    pub(in crate::observer) fn lasting_bias_variance(&self) -> f64 {
        self.bias.variance_beyond(TUNING.lasting_unbiased)
    }

    /// The variance that the drift gains per second.
    pub(in crate::observer) fn drift_walk() -> f64 {
        TUNING.drift_walk * TUNING.drift_walk
    }

    /// Takes the jump of the line since the last call, s.
    pub(in crate::observer) const fn take_jump(&mut self) -> f64 {
        let jump = self.jumped;
        self.jumped = 0.0;
        jump
    }

    /// Takes a jump of the delay that was noticed since the last call, s.
    pub(in crate::observer) const fn take_shift(&mut self) -> Option<f64> {
        self.shifted.take()
    }

    /// Shifts all phases, those before as well as the line.
    pub(in crate::observer) fn shift(&mut self, by: f64) {
        self.windows.shift(by);
        if let Some(line) = &mut self.line {
            line.estimate.offset += by;
        }
    }

    /// Takes the phase of a message due at `time`.
    pub(in crate::observer) fn observe(&mut self, time: f64, phase: f64) {
        let line = self.line.get_or_insert(Line {
            at: time,
            estimate: Estimate {
                offset: phase,
                drift: 0.0,
                offset_variance: TUNING.first_offset * TUNING.first_offset,
                covariance: 0.0,
                drift_variance: TUNING.first_drift * TUNING.first_drift,
            },
        });
        // Windows keep the lowest as seen from the line: by a drift of 100 ppm phases of one window differ by 50 µs.
        let residual = phase - line.offset_at(time);
        if !self.windows.take(time, phase, residual) {
            return;
        }
        let mut line = *line;
        let point = self.windows.close(&line, self.noise.variance());
        self.follow(&mut line, point);
        self.line = Some(line);
        self.opened = time;
    }

    fn follow(&mut self, line: &mut Line, point: Point) {
        let dt = point.time - line.at;
        // A point may be older than the line: the lowest message of a window is anywhere in it.
        if dt > 0.0 {
            line.estimate.predict(dt, Self::drift_walk());
            line.at = point.time;
        }
        self.since_step = self.since_step.saturating_add(1);
        self.noise.measure(&self.windows, Self::drift_walk());
        let innovation = point.phase - line.offset_at(point.time);
        let variance = self.noise.variance();
        let bound = TUNING.gate * libm::sqrt(line.estimate.offset_variance + variance);
        // Left out and not clamped: a Kalman filter on all points is 2 to 10 µs off.
        let on_the_edge = libm::fabs(innovation) < bound;
        self.windows.mark(on_the_edge);
        if on_the_edge {
            // Before the correction, which takes a part of the innovation away.
            self.bias.take(innovation, self.noise.near(), 1.0);
            let _ = line
                .estimate
                .correct(line.estimate.offset + innovation, variance);
        }
        // Before the search for a better line, which would take points of before and after a shift for one line.
        if self.is_shift(point.time, innovation, bound) {
            self.follow_shift(line);
            return;
        }
        if self.windows.len() >= TUNING.enough
            && let Some(better) = consensus::better(&self.windows, line, &self.noise)
        {
            self.jump(line, &better);
        }
    }

    /// True if points lay above the edge for so long that it is not the edge any more.
    fn is_shift(&mut self, time: f64, innovation: f64, bound: f64) -> bool {
        if innovation < bound {
            self.late = 0;
            self.least_late = f64::INFINITY;
            return false;
        }
        if self.late == 0 {
            self.late_since = time;
            self.late_from = self.opened;
            self.first_late = innovation;
        } else {
            // The least of them, as the delay grew by no more than the earliest message shows.
            self.least_late = self.least_late.min(innovation);
        }
        self.late = self.late.saturating_add(1);
        let so_long = time - self.late_since;
        let for_good = self.late >= TUNING.late_points && so_long >= TUNING.late_for;
        // A window in which the delay grew has a point between both levels.
        let far_points = self.late - u8::from(self.first_late <= TUNING.far);
        // Jumps beyond `skip` may be a sender that stood still, which the line of all messages decides.
        let far = TUNING.far..self.skip;
        let far = far_points >= TUNING.far_points
            && so_long >= TUNING.far_for
            && far.contains(&self.least_late);
        for_good || far
    }

    /// Follows a jump of the delay: the line and what came before move with it.
    fn follow_shift(&mut self, line: &mut Line) {
        if self.since_step > TUNING.stair {
            self.stairs = 0;
        }
        if self.stairs == 0 {
            self.stairs_from = self.late_from;
        }
        self.stairs = self.stairs.saturating_add(1);
        self.since_step = 0;
        let by = self.least_late;
        line.estimate.offset += by;
        self.windows.shift_until(self.late_from, by, line);
        // The height of the shift is known no better than a point.
        line.estimate.offset_variance += self.noise.variance();
        self.shifted = Some(by);
        self.late = 0;
        self.least_late = f64::INFINITY;
    }

    fn jump(&mut self, line: &mut Line, better: &Candidate) {
        let before = line.estimate.offset;
        line.estimate = consensus::fitted(&self.windows, line, better, &self.noise);
        self.jumped += line.estimate.offset - before;
        // The innovations were those of another line.
        self.bias.forget();
    }
}

#[cfg(feature = "perturb")]
pub(super) use {consensus::TUNED as CONSENSUS, noise::TUNED as NOISE, windows::TUNED as WINDOWS};

#[cfg(test)]
mod tests;
