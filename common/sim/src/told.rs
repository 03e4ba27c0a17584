//! Whether the velocity and the acceleration that leave an axis are those of the positions that leave it.

use coaxle_axis::set_value_guard::PACE;
use coaxle_curve::profile::{Kinematics, Limits};

/// What a number of a calculated position may be rounded by, relative to the largest one on the way, and what rounding may add to
/// a limit, relative: as of the set positions themselves.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
const RELATIVE: f64 = 1e-9;
/// Where a target and what its limits have left of it follow each other, accelerations of two motions are compared, each beside its
/// positions by what a cycle of the jerk makes.
const MOTIONS: f64 = 2.0;
/// What two velocities may be beside their positions by, in units of what the jerk of a cycle makes of a velocity.
const VELOCITIES: f64 = 1.0;
/// The same in units of what the acceleration limit makes of a velocity in a cycle, where no jerk binds. An acceleration that turns round
/// from one cycle to the next puts the mean of two velocities off by ½, and each velocity may be beside its positions by 1.
const FREE: f64 = 1.5;
/// A position is calculated from numbers as large as the way of so long at the highest velocity, s.
const WAY: f64 = 1.0;

/// Compares what an axis reports beside its set positions with their differences.
///
/// A drive feeds both forward. With the time `t` since the cycle before, jerk limit `j` and acceleration limit `a`:
///
/// * The mean of two velocities is the way between the positions over `t`, to `j·t²`: the trapezoidal rule is off by
///   `j·t²/12` on a motion with that jerk, what half a cycle adds to a difference by `j·t²/4`, and a velocity may be beside that by
///   `½·j·t²`, or by as much more as the next one may not make up for while the acceleration grows. A master that is slewed adds its
///   [pace](PACE) of the velocity. What was told after skipped cycles, and in the cycle after that, could be all that the limits admit
///   within those: of three positions that lie that far apart none says where in between the axis was accelerated. A cycle later that
///   is made up for as fast as the acceleration admits.
/// * An acceleration is the second difference to twice `j` times the time from there to the middle of the three positions, which is
///   `t` for equal cycles.
/// * Both keep their limits, and the velocity its own from cycle to cycle: it changes by `a·t` at most, and by what the first
///   point allows.
///
/// The pace is a fact of the master, which the guard of an axis assumes as well; of what the guard makes of its master nothing is
/// assumed here.
///
/// While the jerk is free, and where it is so high that it means nothing, `1½·a·t` and `2·a` take the place of what it allows.
#[derive(Clone, Copy, Debug)]
pub struct ToldCheck {
    velocity: f64,
    acceleration: f64,
    jerk: f64,
    cycle_time: f64,
    /// The newest set values, and the difference of their position to the one before.
    last: Option<Kinematics>,
    difference: Option<Difference>,
    /// The times that were skipped before the newest differences, s.
    skipped: [f64; 3],
    /// Positions since the jerk was free.
    since_free: u8,
}

/// A velocity by two positions, u/s, and the time between them, s.
#[derive(Clone, Copy, Debug)]
struct Difference {
    velocity: f64,
    time: f64,
}

/// What is told beside positions that say otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WronglyTold {
    /// Which of the values.
    pub what: Told,
    /// By how much it is beside them, or what it is where it is beyond a limit: u/s, u/s².
    pub value: f64,
    /// What is allowed of that, without what rounding may add.
    pub limit: f64,
}

/// A value that an axis tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// Its velocity, or the step of it.
    Velocity,
    /// Its acceleration.
    Acceleration,
}

impl ToldCheck {
    /// The check of an axis with these limits, in a node of this cycle time, s.
    #[must_use]
    pub fn new(limits: &Limits, cycle_time: f64) -> Self {
        Self {
            velocity: limits.velocity(),
            acceleration: limits.acceleration().max(limits.deceleration()),
            jerk: limits.jerk(),
            cycle_time,
            last: None,
            difference: None,
            skipped: [0.0; 3],
            since_free: 0,
        }
    }

    /// The next set values are no step of a motion: the axis was switched on, homed or reset.
    pub const fn restart(&mut self) {
        self.last = None;
        self.difference = None;
        self.skipped = [0.0; 3];
        self.since_free = 0;
    }

    /// The next set values may need any jerk.
    pub const fn free_jerk(&mut self) {
        self.since_free = 0;
    }

    /// The next set values, a number of cycles after those before. Gives what is wrong with each of the two that are told.
    pub fn push(&mut self, set: &Kinematics, cycles: u32) -> [Option<WronglyTold>; 2] {
        let is_finite = [set.position, set.velocity, set.acceleration]
            .iter()
            .all(|value| value.is_finite());
        let Some(last) = self.last.replace(*set).filter(|_| is_finite) else {
            self.difference = None;
            self.since_free = 0;
            self.last = is_finite.then_some(*set);
            return [None; 2];
        };
        let time = f64::from(cycles.max(1)) * self.cycle_time;
        let now = Difference {
            velocity: (set.position - last.position) / time,
            time,
        };
        let before = self.difference.replace(now);
        let skipped = before.map_or(0.0, |before| before.time - self.cycle_time);
        self.skipped = [skipped, self.skipped[0], self.skipped[1]];
        let rounding = self.rounding(set, &last) / time;
        let found = [
            self.of_velocity(set, &last, now, rounding),
            before.and_then(|before| self.of_acceleration(set, now, before, rounding)),
        ];
        self.since_free = (self.since_free + 1).min(4);
        found
    }

    fn of_velocity(
        &self,
        set: &Kinematics,
        last: &Kinematics,
        now: Difference,
        rounding: f64,
    ) -> Option<WronglyTold> {
        let time = now.time + self.skipped.into_iter().fold(0.0, f64::max);
        let by_acceleration = self.acceleration * time;
        let free = FREE * by_acceleration;
        let by_jerk = match self.has_jerk() {
            true => free.min(VELOCITIES * self.jerk * time * time),
            false => free,
        };
        let fastest = now
            .velocity
            .abs()
            .max(set.velocity.abs())
            .max(last.velocity.abs());
        let beside = by_jerk + PACE * fastest;
        let found = |value: f64, limit: f64, more: f64| {
            let most = limit + more + RELATIVE * self.velocity + rounding;
            (value > most).then_some(WronglyTold {
                what: Told::Velocity,
                value,
                limit,
            })
        };
        let mean = 0.5 * (set.velocity + last.velocity);
        let step = (set.velocity - last.velocity).abs();
        found((now.velocity - mean).abs(), beside, 0.0)
            .or_else(|| found(set.velocity.abs(), self.velocity, beside))
            .or_else(|| found(step, by_acceleration, beside))
    }

    fn of_acceleration(
        &self,
        set: &Kinematics,
        now: Difference,
        before: Difference,
        rounding: f64,
    ) -> Option<WronglyTold> {
        let spanned = now.time + before.time;
        let second = 2.0 * (now.velocity - before.velocity) / spanned;
        let to_middle = (2.0 * now.time + before.time) / 3.0;
        let most = 2.0 * self.acceleration;
        let beside = match self.has_jerk() {
            true => most.min(MOTIONS * self.jerk * to_middle),
            false => most,
        };
        let found = |value: f64, limit: f64, more: f64| {
            let rounding = RELATIVE * self.acceleration + 4.0 * rounding / spanned;
            (value > limit * (1.0 + RELATIVE) + more + rounding).then_some(WronglyTold {
                what: Told::Acceleration,
                value,
                limit,
            })
        };
        let slewed = 2.0 * PACE * second.abs();
        found((set.acceleration - second).abs(), beside + slewed, 0.0)
            .or_else(|| found(set.acceleration.abs(), self.acceleration, beside))
    }

    const fn has_jerk(&self) -> bool {
        self.since_free >= 3
    }

    /// What rounding may have added to one of the positions at hand, u.
    fn rounding(&self, set: &Kinematics, last: &Kinematics) -> f64 {
        let largest = set.position.abs().max(last.position.abs());
        4.0 * ROUNDING * largest.max(WAY * self.velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::Seconds;
    use coaxle_curve::profile::{Profile, to_position};
    use proptest::prelude::*;

    const T: f64 = 1e-3;

    fn limits() -> Limits {
        Limits::new(1_000.0, 5_000.0, 5_000.0, 1e5).unwrap()
    }

    fn set(position: f64, velocity: f64, acceleration: f64) -> Kinematics {
        Kinematics {
            position,
            velocity,
            acceleration,
        }
    }

    /// What is found in the last of these set values.
    fn found(all: &[Kinematics]) -> [Option<WronglyTold>; 2] {
        let mut check = ToldCheck::new(&limits(), T);
        let mut last = [None; 2];
        for set in all {
            last = check.push(set, 1);
        }
        last
    }

    #[test]
    fn a_slave_that_stands_is_not_told_the_velocity_of_its_master() {
        let told = [set(7.0, 500.0, 0.0); 5];
        let [velocity, acceleration] = found(&told);
        let velocity = velocity.expect("it stands");
        assert_eq!((velocity.what, velocity.value), (Told::Velocity, 500.0));
        assert!((velocity.limit - 15.1).abs() < 1e-9);
        assert_eq!(acceleration, None);
    }

    #[test]
    fn a_velocity_that_steps_is_found_where_positions_do_not_show_it() {
        // Half a cycle's worth of a step is within what the trapezoidal rule may be off by here.
        let coarse = Limits::new(1_000.0, 5_000.0, 5_000.0, 1e9).unwrap();
        let mut check = ToldCheck::new(&coarse, T);
        for velocity in [0.0, 0.0, 0.0, 0.0] {
            assert_eq!(check.push(&set(0.0, velocity, 0.0), 1), [None; 2]);
        }
        let [velocity, _] = check.push(&set(0.0, 500.0, 0.0), 1);
        assert_eq!(velocity.map(|told| told.what), Some(Told::Velocity));
    }

    #[test]
    fn an_acceleration_beside_the_second_difference_is_found() {
        let told = |acceleration| [set(7.0, 0.0, acceleration); 5];
        assert_eq!(found(&told(199.0)), [None; 2]);
        let [_, acceleration] = found(&told(310.0));
        let acceleration = acceleration.expect("3 times the jerk of a cycle");
        assert_eq!(acceleration.value, 310.0);
        assert!((acceleration.limit - 200.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_set_anew_is_no_step() {
        let mut check = ToldCheck::new(&limits(), T);
        check.push(&set(0.0, 0.0, 0.0), 1);
        check.restart();
        assert_eq!(check.push(&set(90.0, 0.0, 0.0), 1), [None; 2]);
    }

    proptest! {
        #[test]
        fn a_motion_tells_what_it_does_whatever_cycles_were_skipped(
            offset in -1e4..1e4f64,
            from in -900.0..900.0f64,
            way in -400.0..400.0f64,
            skipped in prop::collection::vec(1..9u32, 1..300),
        ) {
            let start = set(offset, from, 0.0);
            let profile: Profile = to_position(&start, offset + way, &limits());
            let mut check = ToldCheck::new(&limits(), T);
            let mut now = 0;
            for cycles in std::iter::once(0).chain(skipped) {
                now += cycles;
                let set = profile.at(Seconds(f64::from(now) * T));
                prop_assert_eq!(check.push(&set, cycles), [None; 2]);
            }
        }
    }
}
