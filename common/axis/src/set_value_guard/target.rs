//! Course of a target, as far as it is known.

use coaxle_curve::profile::Kinematics;

use super::differences::Differences;
use super::envelope::{Envelope, PACE, ROUNDING};

/// The positions of a target, and its stated values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Target {
    series: Differences,
    /// The position before the last, u, and its age in cycles.
    from: f64,
    gap: f64,
    stated: Kinematics,
    /// Successive cycles in which it did not move as stated.
    deviating_cycles: u8,
    /// Cycles in which its jerk was far beyond the limit, less those in which it was not.
    rough_cycles: u8,
    last_position: f64,
}

/// Assumed course of a target: its mean velocity of the last cycle, u/s, and its acceleration, u/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Course {
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    /// True for a target that goes to and fro faster than the axis can.
    pub(super) is_rough: bool,
}

/// Greatest deviation of a target's velocities from its positions, as a share of the change of its
/// acceleration in a cycle: an eighth, and four times that for an acceleration that begins within a
/// cycle. Without it, a velocity passed that deviated by 130 % from its positions where the limits
/// mean "none" (wide schedule 4128).
const CHANGE: f64 = 0.5;

/// Number of successive deviating cycles that count. A motion may begin and end within a cycle, and
/// positions show little of that; a target with false stated values deviates again in the next.
const DEVIATING_CYCLES: u8 = 3;

/// Number of cycles far beyond the jerk limit, less the others, from which a target is rough. A jump is up to four: a jerk spans four positions.
const ROUGH_CYCLES: u8 = 5;

/// Greatest number of them that is counted: as many other cycles later, less five, the target is smooth again.
const MOST_ROUGH_CYCLES: u8 = 16;

/// Greatest distance from the axis, in units of the closed forms, of a target that goes on from there. A plan that is made again from where
/// the axis was left is j·T³ beside it in its first cycle: a saw that did so every five cycles jumped as often as one in beats, and did not
/// get back to its target (`late-ripple`).
const MET: f64 = 4.0;

/// Greatest number of cycles over which differences still show the course of a target.
const MOST_MISSING: f64 = 4.0;

impl Target {
    pub(super) fn at(state: &Kinematics, cycle_time: f64) -> Self {
        Self {
            series: Differences::up_to(state, cycle_time),
            from: state.position,
            gap: 1.0,
            stated: *state,
            deviating_cycles: 0,
            rough_cycles: 0,
            last_position: state.position,
        }
    }

    /// Appends the next target, this number of cycles later. After a non-finite one it takes three
    /// more until the differences are numbers again.
    pub(super) fn then(&self, next: &Kinematics, cycles: f64, envelope: &Envelope) -> Self {
        let rate = envelope.rate;
        // Kept for the distance that is reported, which must be a number.
        let last_position = if next.position.is_finite() {
            next.position
        } else {
            self.last_position
        };
        let series = self.series.then(next.position, cycles, rate);
        // After a gap the two stated velocities are not those at the ends of one cycle.
        let is_known = cycles == 1.0 && self.gap == 1.0;
        let is_rough = envelope.is_rough(&series, self.series.position);
        Self {
            series,
            from: self.series.position,
            gap: cycles,
            stated: *next,
            deviating_cycles: match is_known && !self.goes_on(next, &series, rate) {
                true => self.deviating_cycles.saturating_add(1),
                false => 0,
            },
            rough_cycles: match is_rough {
                true => (self.rough_cycles + 1).min(MOST_ROUGH_CYCLES),
                false => self.rough_cycles.saturating_sub(1),
            },
            last_position,
        }
    }

    /// True for a target whose distance in a cycle is the mean of the stated velocities at its ends.
    ///
    /// For a motion this is true to an eighth of the change of its acceleration (the trapezoidal
    /// rule), as stated or as shown by its positions. A far axis that is blended, or that jumps,
    /// states neither.
    fn goes_on(&self, next: &Kinematics, series: &Differences, rate: f64) -> bool {
        // Trapezoidal rule: distance over time in a cycle, against the mean of the velocities at its ends.
        let mean = 0.5 * (self.stated.velocity + next.velocity);
        let stated = (next.acceleration - self.stated.acceleration).abs();
        // Differences show a change of the acceleration spread over two cycles.
        let seen = series.jerk.abs().max(self.series.jerk.abs()) / rate;
        // Two positions, each rounded, over one cycle.
        let rounding = 2.0 * ROUNDING * series.position.abs() * rate;
        let most = CHANGE * (stated + seen) / rate + PACE * series.velocity.abs() + rounding;
        (series.velocity - mean).abs() <= most
    }

    /// True for a target whose newest positions match its stated velocities.
    pub(super) const fn is_consistent(&self) -> bool {
        self.deviating_cycles < DEVIATING_CYCLES
    }

    /// The last position that was a number, u.
    pub(super) const fn last_position(&self) -> f64 {
        self.last_position
    }

    /// Takes the distance of the axis: a target that goes on from where the axis is, is another one.
    pub(super) fn meet(&mut self, distance: f64, envelope: &Envelope) {
        if envelope.scaled_way(distance).abs() <= MET {
            self.rough_cycles = 0;
        }
    }

    /// True for a target that goes to and fro faster than the axis can: whose positions are rounded or come in beats, or are those of
    /// another axis that another guard leads about its master.
    const fn is_rough(&self) -> bool {
        self.rough_cycles >= ROUGH_CYCLES
    }

    /// The course by its positions. If they jump, or too many of them are missing, by its stated values.
    pub(super) fn course(&self, envelope: &Envelope) -> Course {
        let is_known = self.gap <= MOST_MISSING && !self.is_rough();
        if is_known && envelope.is_motion(&self.series, self.from) {
            Course {
                velocity: self.series.velocity_of_cycle(envelope.cycle_time),
                acceleration: self.series.acceleration,
                is_rough: false,
            }
        } else {
            self.stated_course(envelope)
        }
    }

    /// Position this number of cycles before its last one, as far as known, and its course then:
    /// the current course, but at most back to the position before the last.
    pub(super) fn before(&self, cycles: f64, course: &Course, cycle_time: f64) -> (f64, Course) {
        let last = self.series.position;
        let by_course = last - course.way_of_last(cycles, cycle_time);
        let then = course.later(-cycles, cycle_time);
        // Within the gap the target was between its two known positions, whatever its course says.
        let (low, high) = (last.min(self.from), last.max(self.from));
        if (low..=high).contains(&by_course) {
            (by_course, then)
        } else {
            // A course that leads out of there is not the one that was taken, so no velocity is assumed.
            let rests = Course {
                velocity: 0.0,
                acceleration: 0.0,
                ..then
            };
            (by_course.clamp(low, high), rests)
        }
    }

    fn stated_course(&self, envelope: &Envelope) -> Course {
        let stated = self.stated.acceleration;
        // An acceleration that no axis with these limits has would mislead more than none, and so would one that turns before the axis
        // has it: an axis was led 17 µm to and fro about a target that went 0.5 µm to and fro (swarm schedule 1075).
        let believed = envelope.is_credible(stated) && !self.is_rough();
        let acceleration = if believed { stated } else { 0.0 };
        Course {
            // From the end of the cycle to its mean, as differences of positions have it.
            velocity: self.stated.velocity - acceleration * envelope.cycle_time / 2.0,
            acceleration,
            is_rough: self.is_rough(),
        }
    }
}

impl Course {
    /// Distance in this number of cycles that end now, u.
    pub(super) fn way_of_last(&self, cycles: f64, cycle_time: f64) -> f64 {
        // The mean velocity of n cycles is that in their middle, (n - 1)/2 cycles before that of the last one.
        let slower = self.acceleration * cycle_time * (cycles - 1.0) / 2.0;
        cycles * cycle_time * (self.velocity - slower)
    }

    /// The course this number of cycles later; earlier if negative.
    pub(super) fn later(&self, cycles: f64, cycle_time: f64) -> Self {
        Self {
            velocity: self.velocity + self.acceleration * cycle_time * cycles,
            ..*self
        }
    }
}
