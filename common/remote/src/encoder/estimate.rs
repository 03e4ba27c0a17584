//! Position, velocity and acceleration from edges, and from the absence of edges.
//!
//! An α-β-γ loop that corrects at every count with new information. While the axis passes at least
//! a third of an increment per sample, every count has some, and the middle of its increment is the
//! best estimate of the position. Slower, only an edge has, but to a part of an increment; between
//! edges the estimate does not leave the increment that the count shows.

use coaxle_axis::TravelDirection;
use coaxle_curve::profile::Kinematics;

use super::gains::Gains;
use super::gate::{Edge, Passage};
use super::parameters::CheckedEncoder;

/// The loop. Its positions count from the first increment, so that none is too large for its fraction.
#[derive(Clone, Debug)]
pub(super) struct Estimator {
    increment: f64,
    /// The first count.
    origin: i64,
    bandwidth: f64,
    sampling: f64,
    /// Gains of one sampling time, which most corrections take.
    gains: Gains,
    /// True if the vibration is so large that every count corrects the position, at any speed.
    dithered: bool,
    state: Kinematics,
    direction: TravelDirection,
    /// The lower border of the increment that was entered last.
    cell: f64,
    since_edge: f64,
    since_correction: f64,
    standstill: bool,
}

/// Time without an edge after which the axis stands, s.
pub(super) const STANDSTILL_AFTER: f64 = 0.25;
/// Increments per sampling time from which on every count is a correction.
const FAST: f64 = 0.3;
/// Increments of vibration from which on every count is one at any speed: the last edge gives
/// little information of a shaft that vibrates across it.
const DITHER: f64 = 0.25;
/// Weight of a count in the mean of those at rest.
const AT_REST: f64 = 0.05;
/// Longest time that a correction from standstill covers, in time constants: the beginning of the
/// motion is unknown.
const FROM_STANDSTILL: f64 = 0.6;

impl Estimator {
    /// Creates the estimator of a standing axis.
    pub(super) fn new(checked: &CheckedEncoder, count: i64) -> Self {
        let increment = checked.given.increment;
        Self {
            increment,
            origin: count,
            bandwidth: checked.bandwidth,
            sampling: checked.sampling,
            gains: Gains::new(checked.bandwidth, checked.sampling),
            dithered: checked.given.vibration >= DITHER * increment,
            // The middle of the first increment, whose lower border is the origin.
            state: Kinematics::at_rest(0.5 * increment),
            direction: TravelDirection::Forward,
            cell: 0.0,
            since_edge: 0.0,
            since_correction: 0.0,
            standstill: true,
        }
    }

    /// The axis at the last count.
    pub(super) const fn state(&self) -> &Kinematics {
        &self.state
    }

    /// Seconds since the axis entered its increment.
    pub(super) const fn since_edge(&self) -> f64 {
        self.since_edge
    }

    pub(super) const fn is_standstill(&self) -> bool {
        self.standstill
    }

    /// Restarts with only the position of the axis and its speed on the way there, `gap` seconds.
    pub(super) fn restart(&mut self, edge: &Edge, gap: f64) {
        let way = edge.counts as f64 * self.increment * edge.direction.sign();
        self.direction = edge.direction;
        self.cell = self.border(edge.cell);
        // The mean over the gap is all that is known of the velocity; an acceleration would be a guess.
        self.state = Kinematics {
            velocity: way / gap,
            ..Kinematics::at_rest(self.cell + 0.5 * self.increment)
        };
        self.since_edge = 0.0;
        self.since_correction = 0.0;
        self.standstill = false;
    }

    /// Takes a count's passage, `gap` seconds after the last one.
    pub(super) fn update(&mut self, count: i64, passage: Passage, gap: f64) {
        self.predict(gap);
        match passage {
            // An edge is information in every state. At rest the other counts are only averaged, or bound the
            // position.
            Passage::Edge(edge) => self.enter(&edge, gap),
            Passage::SameCell | Passage::Retreated if self.stands() => self.rest(count),
            Passage::SameCell | Passage::Retreated if self.dithered => {
                self.correct_by_gap(self.border(count) + 0.5 * self.increment);
            }
            Passage::SameCell if self.is_fast() => {
                self.correct_by_gap(self.cell + 0.5 * self.increment);
            }
            Passage::SameCell | Passage::Retreated => self.stay_in_cell(),
        }
    }

    fn predict(&mut self, gap: f64) {
        self.since_edge += gap;
        self.since_correction += gap;
        // At rest velocity and acceleration are 0 by definition; their noise would creep.
        if !self.standstill {
            let Kinematics {
                velocity: v,
                acceleration: a,
                ..
            } = self.state;
            self.state.position += (v + 0.5 * a * gap) * gap;
            self.state.velocity += a * gap;
        }
    }

    /// True if every count is a correction.
    fn is_fast(&self) -> bool {
        let speed = self.state.velocity * self.direction.sign();
        !self.standstill && speed * self.sampling >= FAST * self.increment
    }

    /// Position at which the increment of a count begins.
    fn border(&self, count: i64) -> f64 {
        // The difference is exact as an integer; a 64-bit count as f64 loses its last digits.
        count.wrapping_sub(self.origin) as f64 * self.increment
    }

    fn enter(&mut self, edge: &Edge, gap: f64) {
        let cell = self.border(edge.cell);
        let middle = cell + 0.5 * self.increment;
        let reversed = edge.direction != self.direction;
        self.direction = edge.direction;
        self.cell = cell;
        // Velocity and acceleration of the other direction are of no use; the axis passed through rest in between.
        if reversed && !self.standstill {
            self.state = Kinematics::at_rest(middle);
            self.since_correction = 0.0;
        } else if self.is_fast() || self.dithered {
            self.correct_by_gap(middle);
        } else {
            self.correct_by_edge(self.crossing(edge, gap).unwrap_or(middle));
        }
        self.since_edge = 0.0;
        self.standstill = false;
    }

    /// Position of the axis if it passed one edge since the last count, on a way that is known to
    /// be short.
    fn crossing(&self, edge: &Edge, gap: f64) -> Option<f64> {
        let way = self.state.velocity.abs() * gap;
        let border = match edge.direction {
            TravelDirection::Forward => self.cell,
            TravelDirection::Backward => self.cell + self.increment,
        };
        // With several edges passed at once, the instant of none is known to a part of an increment.
        let is_short = edge.counts == 1 && way < self.increment;
        // The edge was crossed at any instant of the gap, so that the axis is 0 to `way` beyond it, on average half.
        is_short.then_some(border + 0.5 * way * edge.direction.sign())
    }

    fn correct_by_edge(&mut self, measured: f64) {
        let time = self.known_since(self.since_edge);
        self.correct(measured, &Gains::new(self.bandwidth, time));
    }

    fn correct_by_gap(&mut self, measured: f64) {
        // Sums of sampling times differ from one by rounding: 1.001 covers that and no second sample.
        let usual = self.since_correction <= 1.001 * self.sampling;
        let gains = if usual {
            self.gains
        } else {
            Gains::new(self.bandwidth, self.known_since(self.since_correction))
        };
        self.correct(measured, &gains);
    }

    /// Time that a correction covers, of the time since the last one.
    fn known_since(&self, last: f64) -> f64 {
        if self.standstill {
            // The motion began at an unknown instant since the last edge, and the whole time would give too small a
            // velocity.
            last.min(FROM_STANDSTILL / self.bandwidth)
        } else {
            last
        }
    }

    fn correct(&mut self, measured: f64, gains: &Gains) {
        let error = measured - self.state.position;
        self.state.position += gains.position * error;
        self.state.velocity += gains.velocity * error;
        self.state.acceleration += gains.acceleration * error;
        self.since_correction = 0.0;
    }

    fn stands(&self) -> bool {
        self.standstill || self.since_edge >= STANDSTILL_AFTER
    }

    fn rest(&mut self, count: i64) {
        let position = self.state.position;
        let position = if self.dithered {
            let middle = self.border(count) + 0.5 * self.increment;
            // A weight w averages (2 - w)/w = 39 samples.
            position + AT_REST * (middle - position)
        } else {
            self.in_cell(position)
        };
        self.state = Kinematics::at_rest(position);
        self.standstill = true;
    }

    fn in_cell(&self, position: f64) -> f64 {
        position.clamp(self.cell, self.cell + self.increment)
    }

    /// The absence of an edge is information as well: the axis is still in its increment, and
    /// cannot be faster than that allows.
    fn stay_in_cell(&mut self) {
        let predicted = self.state.position;
        let position = self.in_cell(predicted);
        // Above 0 by the prediction of this sample, which has at least one cycle.
        let most = self.increment / self.since_edge;
        let sign = self.direction.sign();
        let state = &mut self.state;
        state.position = position;
        state.velocity = state.velocity.clamp(-most, most);
        if (predicted - position) * sign > 0.0 {
            // Otherwise it would have left at the other end already.
            state.acceleration = sign * (sign * state.acceleration).min(0.0);
        }
    }
}
