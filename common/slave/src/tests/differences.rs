//! Set positions, differenced from cycle to cycle like in a drive.

use coaxle_curve::profile::Kinematics;

use super::{AxisWithPlates, CYCLE, SlaveParameters};

/// The set positions of the last cycles of an axis.
pub(super) struct Differences {
    last: [f64; 4],
    /// The stated set values of the last cycle.
    stated: Kinematics,
    /// Time from one to the next, s.
    dt: f64,
    /// Number of successive cycles since the last restart.
    seen: usize,
}

impl Differences {
    pub(super) fn of(axis: &AxisWithPlates) -> Self {
        Self::every(axis, CYCLE.0)
    }

    /// Starts with a cycle of `dt` seconds.
    pub(super) fn every(axis: &AxisWithPlates, dt: f64) -> Self {
        Self {
            last: [axis.set().position; 4],
            stated: axis.set(),
            dt,
            seen: 0,
        }
    }

    /// Restarts after a preset of the position.
    pub(super) const fn begin_anew(&mut self) {
        self.seen = 0;
    }

    /// Takes a cycle: velocity, acceleration and jerk stay within the parameters, which may be
    /// those of another motion.
    pub(super) fn keep(&mut self, axis: &AxisWithPlates, parameters: &SlaveParameters) {
        if let Err(why) = self.check(axis, parameters) {
            panic!("{why}: {:?} {:?}", self.last, axis.set());
        }
    }

    /// Performs [`keep`](Self::keep), with a violation as the result.
    pub(super) fn check(
        &mut self,
        axis: &AxisWithPlates,
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
        // Rounding as documented for the guard of the set values: by its own cycle, for any skipped ones.
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
            // Stated values keep the limits like the positions, and match them. Values stated after
            // skipped cycles may use all that the limits admit within those.
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

    fn take(&mut self, axis: &AxisWithPlates) {
        self.last.rotate_left(1);
        self.last[3] = axis.set().position;
    }
}
