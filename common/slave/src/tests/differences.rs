//! Set positions, differenced from cycle to cycle: what a drive makes of them.

use coaxle_curve::profile::Kinematics;

use super::{CYCLE, SlaveAxis, SlaveParameters};

/// The set positions of the last cycles of an axis.
pub(super) struct Differences {
    last: [f64; 4],
    /// The set values of the last cycle as they were stated.
    stated: Kinematics,
    /// From one to the next, s.
    dt: f64,
    /// Of how many cycles in a row they are, since something that counts began.
    seen: usize,
}

impl Differences {
    pub(super) fn of(axis: &SlaveAxis) -> Self {
        Self::every(axis, CYCLE.0)
    }

    /// Of an axis that has a cycle only every `dt` seconds.
    pub(super) fn every(axis: &SlaveAxis, dt: f64) -> Self {
        Self {
            last: [axis.set().position; 4],
            stated: axis.set(),
            dt,
            seen: 0,
        }
    }

    /// Something has put the axis where it is that is no motion.
    pub(super) const fn begin_anew(&mut self) {
        self.seen = 0;
    }

    /// One cycle more: velocity, acceleration and jerk stay within those of the parameters, and these
    /// of whatever else moves the axis.
    pub(super) fn keep(&mut self, axis: &SlaveAxis, parameters: &SlaveParameters) {
        if let Err(why) = self.check(axis, parameters) {
            panic!("{why}: {:?} {:?}", self.last, axis.set());
        }
    }

    /// As [`keep`](Self::keep), and what is not kept.
    pub(super) fn check(
        &mut self,
        axis: &SlaveAxis,
        parameters: &SlaveParameters,
    ) -> Result<(), std::string::String> {
        self.take(axis);
        let before = core::mem::replace(&mut self.stated, axis.set());
        self.seen += 1;
        if self.seen <= 3 {
            return Ok(());
        }
        let [p0, p1, p2, p3] = self.last;
        let dt = self.dt;
        let most = parameters
            .acceleration
            .max(parameters.deceleration.unwrap_or(0.0));
        // What rounding may add, as the guard of the set values says: by its own cycle, whatever is skipped.
        let largest = p3.abs().max(p0.abs()).max(parameters.velocity);
        let digits = 4.0 * f64::EPSILON * largest;
        let cycle = CYCLE.0;
        for (quantity, received, limit, rounding) in [
            (
                "velocity",
                (p3 - p2) / dt,
                parameters.velocity,
                digits / cycle,
            ),
            (
                "acceleration",
                (p3 - 2.0 * p2 + p1) / (dt * dt),
                most,
                2.0 * digits / (cycle * cycle),
            ),
            // What is stated beside the positions keeps the limits as they do, and is theirs. What was stated after skipped
            // cycles could be all that the limits admit within those.
            (
                "stated velocity, per second,",
                (self.stated.velocity - before.velocity) / (2.0 * dt - cycle),
                most,
                2.0 * digits / (cycle * cycle),
            ),
            (
                "stated acceleration, per second,",
                (self.stated.acceleration - before.acceleration) / (3.0 * dt - 2.0 * cycle),
                parameters.jerk,
                4.0 * digits / (cycle * cycle * cycle),
            ),
            (
                "stated velocity, beside that of the positions,",
                self.stated.velocity - (p3 - p2) / dt,
                (most * dt).max(parameters.jerk * dt * dt),
                4.0 * digits / cycle,
            ),
            (
                "jerk",
                (p3 - 3.0 * p2 + 3.0 * p1 - p0) / (dt * dt * dt),
                parameters.jerk,
                4.0 * digits / (cycle * cycle * cycle),
            ),
        ] {
            if received.abs() > limit * (1.0 + 1e-6) + rounding {
                return Err(std::format!("{quantity} {received}, at most {limit}"));
            }
        }
        Ok(())
    }

    fn take(&mut self, axis: &SlaveAxis) {
        self.last.rotate_left(1);
        self.last[3] = axis.set().position;
    }
}
