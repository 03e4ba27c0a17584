//! Steps of the set values that no mode explains.
//!
//! The blocks announce what they know of: a change of mode, a blend, data that stay away. Whatever else makes the set
//! values jump is found here, from what leaves the blocks: an extrapolation over a silence that the master did not
//! keep to, a position that was set, a clock that was wrong. It closes the loop: what is found is brought back along a
//! curve.

use coaxle_clock::Span;
use coaxle_curve::profile::Kinematics;

/// A share of the way per cycle that is never taken for a step: far more than a clock that is followed is slewed by,
/// far less than the 2 % of a ripple that a drive shows.
const EVENNESS: f64 = 1e-3;
/// A step is more than this multiple of what is usual, …
const UNUSUAL: f64 = 4.0;
/// … which is the largest of late, forgotten within some 10 000 cycles, …
const FORGETTING: f64 = 1e-4;
/// … and at most doubled by a cycle: a single jump is not usual.
const DOUBLING: f64 = 2.0;
/// Acceleration and jerk may be exceeded by a third: those seen are means over a cycle of the sender.
const RESERVE: f64 = 4.0 / 3.0;
/// Whatever was usual or may be explained, a jump by more than so many times the way of a cycle at the greatest
/// velocity is a step. What is usual learns from corrections of wrong extrapolations too, and a jerk × age² explains
/// any: the way to a master that is 150 ms off is not to be made up for in a cycle.
const LARGEST_WAY: f64 = 2.0;
/// Positions and velocities of the master that contradict each other, as those in increments do, jump by so much
/// more: from the one end of what was seen to the other.
const BOTH_ENDS: f64 = 2.0;
/// The mean of two velocities is off by at most so much of acceleration × time² (the trapezoidal rule).
const TRAPEZOID: f64 = 0.25;
/// Rounding of the position, and of a far time in nanoseconds.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
const CLOCK_ROUNDING: f64 = 2e-9;

/// What a far axis was seen to do: the limits that it is taken to have, unless it is given some.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SeenMotion {
    /// The greatest acceleration, u/s², stated or by differences of the velocity.
    acceleration: f64,
    /// The greatest jerk by differences of the stated acceleration, u/s³.
    jerk: f64,
    /// The greatest velocity, u/s.
    velocity: f64,
    /// How far positions are beside velocities, u, and velocities beside accelerations, u/s, from frame to frame.
    beside: [f64; 2],
}

impl SeenMotion {
    /// Set values, and how many seconds after the ones before they came; none of the first.
    pub(super) fn take(&mut self, set: &Kinematics, before: Option<(&Kinematics, f64)>) {
        self.velocity = self.velocity.max(set.velocity.abs());
        self.acceleration = self.acceleration.max(set.acceleration.abs());
        if let Some((before, passed)) = before
            && passed > 0.0
        {
            let rate = |now: f64, before: f64| ((now - before) / passed).abs();
            let by_velocity = rate(set.velocity, before.velocity);
            self.acceleration = self.acceleration.max(by_velocity);
            self.jerk = self.jerk.max(rate(set.acceleration, before.acceleration));
        }
    }

    /// Set values that came few cycles, so many seconds, after the ones before: how they contradict each other.
    pub(super) fn compare(&mut self, set: &Kinematics, before: &Kinematics, passed: f64) {
        let explained = TRAPEZOID * passed * passed;
        let mean = |one: f64, other: f64| 0.5 * (one + other) * passed;
        let by_velocity = set.position - before.position - mean(set.velocity, before.velocity);
        let by_acceleration =
            set.velocity - before.velocity - mean(set.acceleration, before.acceleration);
        let seen = [
            by_velocity.abs() - self.acceleration * explained,
            by_acceleration.abs() - self.jerk * explained,
        ];
        let least = [self.velocity * passed, self.velocity].map(|most| EVENNESS * most);
        for ((beside, seen), least) in self.beside.iter_mut().zip(seen).zip(least) {
            let most = DOUBLING * *beside + least;
            *beside = (*beside * (1.0 - FORGETTING)).max(seen.min(most));
        }
    }

    /// How far the axis moves in a cycle at the very most, u, with set values that are up to this old.
    fn largest_way(&self, age: f64, passed: f64) -> f64 {
        let [position, velocity] = self.beside;
        LARGEST_WAY * self.velocity * passed + BOTH_ENDS * (position + velocity * age)
    }

    /// How far the axis may be from where set values of this age are moved on to, u: half of the jerk × age³, or the
    /// change of the acceleration, from one end to the other, × age² / 2.
    pub(super) fn prediction_error(&self, age: f64) -> f64 {
        let age = age.abs();
        let by_jerk = 0.5 * self.jerk * age * age * age;
        let by_acceleration = self.acceleration * age * age;
        by_jerk.min(by_acceleration)
    }

    /// How much more than it moved the axis may move in a cycle, u, with set values of this age.
    fn explained(&self, age: f64, passed: f64) -> f64 {
        let by_acceleration = self.acceleration * passed * passed;
        let by_jerk = 0.5 * self.jerk * age * age * passed;
        RESERVE * (by_acceleration + by_jerk)
    }
}

/// The set values of an axis from cycle to cycle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StepWatch {
    last: Option<Kinematics>,
    /// How old its set values were, s.
    last_age: f64,
    /// The largest departure of late, u.
    usual: f64,
}

/// A cycle, as the clock has it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    /// The far time that passed; none where the set values stand for none, or the block blends.
    pub(super) far: Option<Span>,
    /// The own time that passed, s.
    pub(super) passed: f64,
    /// Of the set values, s.
    pub(super) age: f64,
}

impl StepWatch {
    /// The set values of a cycle; whether they are a step.
    pub(super) fn is_step(&mut self, set: &Kinematics, course: Course, seen: &SeenMotion) -> bool {
        let last = self.last.replace(*set);
        let age = course.age.abs();
        let oldest = age.max(std::mem::replace(&mut self.last_age, age));
        let (Some(last), Some(far)) = (last, course.far) else {
            return false;
        };
        let far = far.as_secs_f64();
        let expected = last.position + (last.velocity + 0.5 * last.acceleration * far) * far;
        let departure = (set.position - expected).abs();
        let even = EVENNESS * last.velocity.abs() * course.passed
            + CLOCK_ROUNDING * last.velocity.abs()
            + ROUNDING * set.position.abs();
        let known = even + seen.explained(course.age, course.passed);
        let most = even + seen.largest_way(oldest, course.passed);
        let is_step = departure > (known + UNUSUAL * self.usual).min(most);
        let most = DOUBLING * self.usual + even;
        self.usual = (self.usual * (1.0 - FORGETTING)).max(departure.min(most));
        is_step
    }

    /// The position of the newest cycle.
    pub(super) fn position(&self) -> Option<f64> {
        self.last.map(|last| last.position)
    }

    /// What comes next has nothing to do with what was.
    pub(super) const fn forget(&mut self) {
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: f64 = 1e-3;

    fn course() -> Course {
        Course {
            far: Some(Span::from_millis(1)),
            passed: CYCLE,
            age: 2e-3,
        }
    }

    fn steady(position: f64) -> Kinematics {
        Kinematics {
            position,
            velocity: 500.0,
            acceleration: 0.0,
        }
    }

    /// The cycles, of a hundred, that are steps.
    fn steps(seen: &SeenMotion, position: impl Fn(u32) -> f64) -> Vec<u32> {
        let mut watch = StepWatch::default();
        let is_step = |k: &u32| watch.is_step(&steady(position(*k)), course(), seen);
        (0..100).filter(is_step).collect()
    }

    #[test]
    fn a_jump_is_a_step_once_and_what_the_clock_slews_by_is_none() {
        let seen = SeenMotion::default();
        let even = |k: u32| 0.5 * f64::from(k) * (1.0 + 1e-4);
        assert!(steps(&seen, even).is_empty());
        let jump = |k: u32| 0.5 * f64::from(k) + if k < 50 { 0.0 } else { 8.4 };
        assert_eq!(steps(&seen, jump), [50]);
        let small = |k: u32| 0.5 * f64::from(k) + if k < 50 { 0.0 } else { 0.01 };
        assert_eq!(steps(&seen, small), [50]);
    }

    /// A master that is between 100 and 800 u/s and is heard every 150 ms.
    #[test]
    fn a_wrong_extrapolation_is_a_step_however_usual_it_is() {
        let mut seen = SeenMotion::default();
        let mut watch = StepWatch::default();
        let velocity = |t: f64| 450.0 + 350.0 * (4.0 * t).sin();
        let position = |t: f64| 450.0 * t - 87.5 * (4.0 * t).cos();
        let acceleration = |t: f64| 1_400.0 * (4.0 * t).cos();
        let (mut frame, mut steps) = (steady(0.0), Vec::new());
        let mut sent = 0.0;
        for k in 0..5_000 {
            let t = f64::from(k) * CYCLE;
            if k % 150 == 0 {
                let before = std::mem::replace(
                    &mut frame,
                    Kinematics {
                        position: position(t),
                        velocity: velocity(t),
                        acceleration: acceleration(t),
                    },
                );
                seen.take(&frame, Some((&before, t - sent)));
                sent = t;
            }
            let age = t - sent;
            let set = Kinematics {
                position: frame.position + (frame.velocity + 0.5 * frame.acceleration * age) * age,
                velocity: frame.velocity + frame.acceleration * age,
                ..frame
            };
            let before = watch.last;
            let is_step = watch.is_step(&set, Course { age, ..course() }, &seen);
            let jump = before.map_or(0.0, |before| {
                set.position - before.position - before.velocity * CYCLE
            });
            if k > 200 && jump.abs() > 1.7 {
                steps.push((k, jump, is_step));
            }
        }
        assert!(steps.len() > 5, "{steps:?}");
        assert!(steps.iter().all(|(.., is_step)| *is_step), "{steps:?}");
    }

    #[test]
    fn increments_are_usual_after_a_while_and_a_jump_beside_them_is_not() {
        let mut seen = SeenMotion::default();
        seen.take(&steady(0.0), None);
        let coarse = |k: u32| (0.523 * f64::from(k) / 0.01).floor() * 0.01;
        let found = steps(&seen, |k| coarse(k) - 0.023 * f64::from(k));
        assert!(found.iter().all(|k| *k < 20), "{found:?}");
        let jump = |k: u32| coarse(k) - 0.023 * f64::from(k) + if k < 50 { 0.0 } else { 1.0 };
        assert!(steps(&seen, jump).contains(&50));
    }

    #[test]
    fn what_the_axis_was_seen_to_do_is_no_step() {
        let mut seen = SeenMotion::default();
        let ramp = |k: u32| Kinematics {
            acceleration: 100.0 * f64::from(k.min(50)),
            ..steady(0.0)
        };
        for k in 1..100 {
            seen.take(&ramp(k), Some((&ramp(k - 1), CYCLE)));
        }
        assert!((seen.jerk / 1e5 - 1.0).abs() < 1e-9 && seen.acceleration == 5_000.0);
        // 5 000 mm/s² over a cycle is 5 µm.
        let kick = |k: u32| 0.5 * f64::from(k) + if k < 50 { 0.0 } else { 0.005 };
        assert!(steps(&seen, kick).is_empty());
        let error = |age: f64| seen.prediction_error(age);
        assert!((error(2e-3) - 0.5 * 1e5 * 8e-9).abs() < 1e-15);
        assert!((error(0.5) - 5_000.0 * 0.25).abs() < 1e-9);
    }
}
