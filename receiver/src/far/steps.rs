//! Steps of the set values that no mode explains.
//!
//! The blocks report the causes that they know: a change of mode, a blend, missing data. All other
//! jumps of the set values are found here, in the output of the blocks: an extrapolation over a
//! silence from which the master deviated, a position that was set, a clock that was wrong. The
//! loop is closed: a step found is brought back along a curve.

use coaxle_clock::Span;
use coaxle_curve::profile::Kinematics;
use coaxle_remote::FilterState;

use super::seen::{ObservedMotion, RecentPeak};

/// A share of the way per cycle that is never taken for a step: far more than the slewing of a
/// clock that is followed, far less than the 2 % of a drive's ripple.
const EVENNESS: f64 = 1e-3;
/// A step is more than this multiple of the usual departure, …
const UNUSUAL: f64 = 4.0;
/// … which is the largest recent one, forgotten within some 10 000 cycles, …
const FORGETTING: f64 = 1e-4;
/// … and at most doubled by a cycle: a single jump is not usual.
const DOUBLING: f64 = 2.0;
/// Far time passes at most twice as fast as time in TS5066's blocks ([`super::course`]), …
const PACE_OF_BLOCKS: f64 = 1.0;
/// … and an axis may be a tenth faster than its master was up to now.
const FASTER: f64 = 0.1;
/// Cycles of the receiver by which set values of two modes may be apart in addition to their corrections.
const APART: f64 = 3.0;
/// Cycles that a blend may take longer than its time: its beginning and its end lie within one.
const ENDS: f64 = 2.0;
/// Largest lag of a filter, in time constants, …
const FILTERED: f64 = 2.0;
/// … and the number of ways that may be added at once: the newest, and one still in the filter.
const AT_ONCE: f64 = 2.0;
/// Rounding of the position, and of a far time in nanoseconds.
// A position passes a handful of sums, each of which rounds by half an ulp.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
// Far time that passed is a difference of two instants in whole nanoseconds.
const CLOCK_ROUNDING: f64 = 2e-9;

/// Parameters of an axis that bound its way in a cycle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Blending {
    /// Time over which a change of mode is blended, s.
    pub(super) time: f64,
    /// Time constant of the PT1 filter, s.
    pub(super) filter_time: f64,
}

/// The set values of an axis from cycle to cycle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StepWatch {
    last: Option<Kinematics>,
    /// Largest recent departure, u.
    usual: f64,
    /// Ages of the set values, s.
    ages: RecentPeak,
    /// Time since the last mode that shows values as received, s.
    shown_ago: f64,
}

/// A cycle, as given by the clock.
#[derive(Clone, Copy, Debug)]
pub(super) struct FarCycle {
    /// Mode that calculated the set values.
    pub(super) mode: FilterState,
    /// True while a change of mode is being blended.
    pub(super) is_blending: bool,
    /// Far time that passed; none if the set values stand for none.
    pub(super) far: Option<Span>,
    /// Received position, u.
    pub(super) received: f64,
    /// Own time that passed, s, and the cycle time.
    pub(super) passed: f64,
    pub(super) cycle_time: f64,
    /// Age of the set values, s; negative before the newest frame.
    pub(super) age: f64,
    /// The part of it that is predicted, s.
    pub(super) predicted: f64,
}

impl StepWatch {
    /// Takes the set values of a cycle; returns true if they are a step.
    pub(super) fn is_step(
        &mut self,
        set: &Kinematics,
        course: &FarCycle,
        blending: &Blending,
        seen: &ObservedMotion,
    ) -> bool {
        let last = self.last.replace(*set);
        self.ages.see(course.age.abs());
        self.ages.pass(course.passed);
        // Beats remain in the output of other modes until the blend from those modes has ended.
        self.shown_ago = match shows_what_comes(course.mode) {
            true => 0.0,
            false => self.shown_ago + course.passed,
        };
        let Some(last) = last else {
            return false;
        };
        // After months of motion a position rounds more coarsely than a slow axis moves in a cycle.
        let rounding = ROUNDING * set.position.abs();
        let way = (set.position - last.position).abs();
        let beside = (set.position - course.received).abs();
        let is_too_far = way > self.most(course, blending, seen) + rounding
            || beside > self.farthest(course, blending, seen) + rounding;
        // A blend departs from any continuation on purpose. Then only the bounds of its way hold.
        let is_unusual = match course.far.filter(|_| !course.is_blending) {
            Some(far) => self.is_unusual(set, &last, far, course, seen),
            None => false,
        };
        is_too_far || is_unusual
    }

    /// True if set values depart from a continuation of the previous cycle's by more than the
    /// observed motion of the master and more than is usual.
    fn is_unusual(
        &mut self,
        set: &Kinematics,
        last: &Kinematics,
        far: Span,
        course: &FarCycle,
        seen: &ObservedMotion,
    ) -> bool {
        let far = far.as_secs_f64();
        // p + v·t + a·t²/2 over the far time that passed: a clock that is slewed is no departure.
        let expected = last.position + (last.velocity + 0.5 * last.acceleration * far) * far;
        let departure = (set.position - expected).abs();
        let even = EVENNESS * last.velocity.abs() * course.passed
            + CLOCK_ROUNDING * last.velocity.abs()
            + ROUNDING * set.position.abs();
        let known = even + seen.explained(course.predicted, course.passed);
        let is_unusual = departure > known + UNUSUAL * self.usual;
        // The even part lets the usual departure grow from 0.
        let most = DOUBLING * self.usual + even;
        // Learned from steps, too: an axis whose every cycle departs has no steps.
        self.usual = (self.usual * (1.0 - FORGETTING)).max(departure.min(most));
        is_unusual
    }

    /// Largest way of the axis in a cycle, u, regardless of the usual departure: by the observed
    /// motion of its master, at the pace of the far time, with the addition of a blend, and with
    /// the ways shown at once by a mode that shows values as received.
    fn most(&self, course: &FarCycle, blending: &Blending, seen: &ObservedMotion) -> f64 {
        let FarCycle { mode, passed, .. } = *course;
        let age = self.ages.largest();
        let velocity = seen.greatest_velocity(age);
        let pace = match mode {
            FilterState::Sync | FilterState::Time => PACE_OF_BLOCKS,
            FilterState::Bypass | FilterState::Pt1 | FilterState::Observer => 0.0,
        };
        let blended = match course.is_blending {
            // A blend moves the distance of two modes, at most v·(age + filter + cycles apart), within its time. A
            // blend of 0 s takes a cycle.
            true => (age + blending.filter_time + APART * passed) / blending.time.max(passed),
            false => 0.0,
        };
        let is_shown = self.shown_ago <= blending.time + ENDS * passed;
        let at_once = if is_shown { seen.received_way() } else { 0.0 };
        velocity * (1.0 + pace + FASTER + blended) * passed + seen.unexplained(age) + at_once
    }

    /// Largest distance of the axis from the received position, u: by the correction, the lag of a
    /// filter, and the recent ways. A blend that begins farther away is one over a silence.
    fn farthest(&self, course: &FarCycle, blending: &Blending, seen: &ObservedMotion) -> f64 {
        let age = self.ages.largest();
        let time = age + FILTERED * blending.filter_time + APART * course.cycle_time;
        seen.greatest_velocity(age) * time + seen.unexplained(age) + AT_ONCE * seen.received_way()
    }

    /// The position of the newest cycle.
    pub(super) fn position(&self) -> Option<f64> {
        self.last.map(|last| last.position)
    }

    /// The next set values come after these.
    pub(super) const fn go_on_from(&mut self, set: &Kinematics) {
        self.last = Some(*set);
    }

    /// Restarts: the next set values are unrelated to the previous ones.
    pub(super) const fn forget(&mut self) {
        self.last = None;
    }
}

/// True if a mode shows values as received, including beats.
pub(super) const fn shows_what_comes(mode: FilterState) -> bool {
    matches!(mode, FilterState::Bypass | FilterState::Pt1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: f64 = 1e-3;

    const BLENDING: Blending = Blending {
        time: 0.06,
        filter_time: 3.0 * CYCLE,
    };

    fn course() -> FarCycle {
        FarCycle {
            mode: FilterState::Observer,
            is_blending: false,
            far: Some(Span::from_millis(1)),
            received: f64::NAN,
            passed: CYCLE,
            cycle_time: CYCLE,
            age: 2e-3,
            predicted: 2e-3,
        }
    }

    fn steady(position: f64) -> Kinematics {
        Kinematics {
            position,
            velocity: 500.0,
            acceleration: 0.0,
        }
    }

    /// A master with an observed velocity of 500 u/s.
    fn seen() -> ObservedMotion {
        let mut seen = ObservedMotion::default();
        seen.take(&steady(0.0), None);
        seen
    }

    /// The cycles, of a hundred, that are steps.
    fn steps(course: FarCycle, position: impl Fn(u32) -> f64) -> Vec<u32> {
        let (mut watch, seen) = (StepWatch::default(), seen());
        let mut is_step = |k: &u32| watch.is_step(&steady(position(*k)), &course, &BLENDING, &seen);
        (0..100).filter(|k| is_step(k)).collect()
    }

    #[test]
    fn a_jump_is_a_step_once_and_what_the_clock_slews_by_is_none() {
        let even = |k: u32| 0.5 * f64::from(k) * (1.0 + 1e-4);
        assert!(steps(course(), even).is_empty());
        let jump = |k: u32| 0.5 * f64::from(k) + if k < 50 { 0.0 } else { 8.4 };
        assert_eq!(steps(course(), jump), [50]);
        let small = |k: u32| 0.5 * f64::from(k) + if k < 50 { 0.0 } else { 0.01 };
        assert_eq!(steps(course(), small), [50]);
    }

    #[test]
    fn a_jump_that_no_mode_explains_is_a_step_in_each_of_them() {
        let jump = |k: u32| 0.5 * f64::from(k) + if k < 50 { 0.0 } else { 8.4 };
        let modes = [
            FilterState::Bypass,
            FilterState::Pt1,
            FilterState::Sync,
            FilterState::Time,
            FilterState::Observer,
        ];
        for mode in modes {
            for is_blending in [false, true] {
                let course = FarCycle {
                    mode,
                    is_blending,
                    far: None,
                    ..course()
                };
                assert_eq!(steps(course, jump), [50], "{mode:?}");
            }
        }
    }

    /// Wide schedule 6006: a receiver that stood still for 0.6 s went on with a blend from where the axis would have been.
    #[test]
    fn a_blend_from_far_away_is_a_step() {
        let (mut watch, seen) = (StepWatch::default(), seen());
        let mut is_step = |position: f64, passed: f64| {
            let course = FarCycle {
                is_blending: true,
                received: 0.0,
                passed,
                ..course()
            };
            watch.is_step(&steady(position), &course, &BLENDING, &seen)
        };
        assert!(!is_step(0.0, CYCLE));
        assert!(!is_step(1.0, 2.0 * CYCLE), "a change of mode");
        assert!(is_step(184.0, 0.6));
    }

    /// A master between 100 and 800 u/s that is received every 150 ms.
    #[test]
    fn a_wrong_extrapolation_is_a_step_however_usual_it_is() {
        let (mut seen, mut watch) = (ObservedMotion::default(), StepWatch::default());
        let master = |t: f64| Kinematics {
            position: 450.0 * t - 87.5 * (4.0 * t).cos(),
            velocity: 450.0 + 350.0 * (4.0 * t).sin(),
            acceleration: 1_400.0 * (4.0 * t).cos(),
        };
        let (mut frame, mut sent, mut jumps) = (master(0.0), 0.0, Vec::new());
        for k in 0..5_000 {
            let t = f64::from(k) * CYCLE;
            if k % 150 == 0 {
                let before = std::mem::replace(&mut frame, master(t));
                seen.take(&frame, Some((&before, t - sent, 150)));
                sent = t;
            }
            let age = t - sent;
            let set = Kinematics {
                position: frame.position + (frame.velocity + 0.5 * frame.acceleration * age) * age,
                velocity: frame.velocity + frame.acceleration * age,
                ..frame
            };
            let before = watch.position();
            let predicted = age;
            let course = FarCycle {
                age,
                predicted,
                ..course()
            };
            let is_step = watch.is_step(&set, &course, &BLENDING, &seen);
            let way = before.map_or(0.0, |before| (set.position - before).abs());
            if k > 200 && way > 2.0 {
                jumps.push((k, way, is_step));
            }
        }
        assert!(jumps.len() > 5, "{jumps:?}");
        assert!(jumps.iter().all(|(.., is_step)| *is_step), "{jumps:?}");
    }

    #[test]
    fn increments_are_usual_after_a_while_and_a_jump_beside_them_is_not() {
        let coarse = |k: u32| (0.523 * f64::from(k) / 0.01).floor() * 0.01;
        let found = steps(course(), |k| coarse(k) - 0.023 * f64::from(k));
        assert!(found.iter().all(|k| *k < 20), "{found:?}");
        let jump = |k: u32| coarse(k) - 0.023 * f64::from(k) + if k < 50 { 0.0 } else { 1.0 };
        assert!(steps(course(), jump).contains(&50));
    }

    #[test]
    fn what_the_axis_was_seen_to_do_is_no_step() {
        let (mut seen, mut watch) = (seen(), StepWatch::default());
        let ramp = |k: u32| Kinematics {
            acceleration: 100.0 * f64::from(k.min(50)),
            ..steady(0.0)
        };
        for k in 1..100 {
            seen.take(&ramp(k), Some((&ramp(k - 1), CYCLE, 1)));
        }
        // 5 000 mm/s² over a cycle is 5 µm.
        let kick = |k: u32| 0.5 * f64::from(k) + if k < 50 { 0.0 } else { 0.005 };
        let mut is_step = |k: u32| watch.is_step(&steady(kick(k)), &course(), &BLENDING, &seen);
        assert!((0..100).all(|k| !is_step(k)));
    }
}
