//! Velocity, acceleration and jerk of a series of positions.

use coaxle_curve::profile::Kinematics;

/// The last position of a series, and its differences.
///
/// Between positions that are not one cycle apart these are divided differences, times 1, 2 and 6.
/// Each is a weighted mean of the derivative over the time that it spans: a motion that keeps a
/// limit keeps it in them too, for any sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Differences {
    /// Position, u.
    pub(super) position: f64,
    /// Velocity between the last two positions, u/s.
    pub(super) velocity: f64,
    /// Acceleration of the last three positions, u/s².
    pub(super) acceleration: f64,
    /// Jerk of the last four positions, u/s³.
    pub(super) jerk: f64,
    /// Number of cycles between the last two positions, and between the two before.
    cycles: f64,
    cycles_before: f64,
}

impl Differences {
    /// Differences of a motion of constant acceleration that has reached a state.
    pub(super) fn up_to(state: &Kinematics, cycle_time: f64) -> Self {
        Self::each_cycle(
            state.position,
            // A difference is the mean velocity of a cycle: that in its middle, if the acceleration is constant.
            state.velocity - state.acceleration * cycle_time / 2.0,
            state.acceleration,
        )
    }

    /// Differences of positions one cycle apart.
    pub(super) const fn each_cycle(position: f64, velocity: f64, acceleration: f64) -> Self {
        Self {
            position,
            velocity,
            acceleration,
            jerk: 0.0,
            cycles: 1.0,
            cycles_before: 1.0,
        }
    }

    /// Appends the next position, this number of cycles later; `rate` is the number of cycles per second.
    #[inline]
    pub(super) fn then(&self, position: f64, cycles: f64, rate: f64) -> Self {
        let [first, second, third] = self.rates(cycles, rate);
        let velocity = (position - self.position) * first;
        let acceleration = (velocity - self.velocity) * second;
        Self {
            position,
            velocity,
            acceleration,
            jerk: (acceleration - self.acceleration) * third,
            cycles,
            cycles_before: self.cycles,
        }
    }

    /// Inverse of the times by which the first, second and third difference are divided.
    #[inline]
    fn rates(&self, cycles: f64, rate: f64) -> [f64; 3] {
        let (two, three) = (
            cycles + self.cycles,
            cycles + self.cycles + self.cycles_before,
        );
        // Without skipped cycles the factors are exactly the rate, and need no division: 2·rate/2 and 3·rate/3.
        if three == 3.0 {
            [rate; 3]
        } else {
            // Second and third divided differences, times 2! and 3!/2!: each is then a mean of the derivative.
            [rate / cycles, 2.0 * rate / two, 3.0 * rate / three]
        }
    }

    /// The cycles spanned by the last difference, and the age of the second one: the latter is the
    /// middle of the time of its weighted mean.
    pub(super) fn looks_back(&self) -> (f64, f64) {
        (self.cycles, (2.0 * self.cycles + self.cycles_before) / 3.0)
    }

    /// The mean velocity of the last cycle, u/s.
    #[inline]
    pub(super) fn velocity_of_cycle(&self, cycle_time: f64) -> f64 {
        // A difference over n cycles is the velocity in their middle, (n - 1)/2 cycles before that of the last one.
        self.velocity + self.acceleration * cycle_time * ((self.cycles - 1.0) / 2.0)
    }
}
