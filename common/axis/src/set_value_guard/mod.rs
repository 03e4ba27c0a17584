//! The last stage of an axis: limits that hold on the positions that leave it, whatever moves it.
//!
//! A [`SetValueGuard`] gets a target per cycle and gives the set values of the drive. A target that keeps
//! the limits passes with its own bits and without lag. From any other the guard departs as little and as
//! briefly as it can, and lands on it again exactly. It is no filter: noise is smoothed before, and the
//! limits of the guard lie some 20 % above those that a motion is planned with, or nothing is left to
//! catch up with.
//!
//! ```
//! use coaxle_axis::set_value_guard::{GuardState, SetValueGuard};
//! use coaxle_clock::Seconds;
//! use coaxle_curve::profile::{Kinematics, Limits};
//!
//! let limits = Limits::new(100.0, 1_000.0, 1_000.0, 50_000.0)?;
//! let start = Kinematics::at_rest(0.0);
//! let mut guard = SetValueGuard::new(&limits, -1e3, 1e3, Seconds(0.001), &start)?;
//!
//! // The target jumps by 2 mm: the axis goes there within its limits, and is there exactly.
//! let target = Kinematics::at_rest(2.0);
//! let mut cycles = 0;
//! while guard.update(&target, 1).state != GuardState::Tracking {
//!     cycles += 1;
//! }
//! assert_eq!(guard.update(&target, 1).set.position, target.position);
//! assert!((100..130).contains(&cycles));
//! # Ok::<(), coaxle_curve::profile::InvalidLimit>(())
//! ```
//!
//! # What is kept
//!
//! The differences of the positions: velocity is the difference of two over the cycle time, acceleration
//! that of two velocities, jerk that of two accelerations. A motion that keeps a limit keeps it in its
//! differences too, so nothing is added to a limit but what rounding may: with `δ = 4ε·max(|p|, vmax·1 s)`,
//! `δ/T` on the velocity, `2δ/T²` on the acceleration, `4δ/T³` on the jerk, and 1e-9 of each. Beyond some
//! 1e4 u that becomes noticeable; a modulo position or an offset helps.
//!
//! Of acceleration and deceleration the larger holds, either way: which of the two applies turns on the
//! direction of the motion, and a motion that keeps both keeps that one.
//!
//! Software limits come before the velocity, after jerk and acceleration: where the axis cannot stop any
//! more, because limits were lowered or because it began too fast, it passes them as little as it can.
//! From beyond one it may come back or stay, but go no farther. Rounding may add `128ε·max(|p|, vmax·1 s)`.
//!
//! # How
//!
//! There is no plan that could go stale. In each cycle the next acceleration is chosen such that a stop
//! from there, relative to the target, ends just at the target (see `closed_forms`), within what jerk,
//! acceleration, walls and velocity admit. The positions of a target decide about everything; what it
//! states of its velocity and acceleration only predicts where it goes while its positions jump.

mod approach;
mod closed_forms;
mod differences;
mod envelope;
mod guarded;
mod range;
mod root;
mod target;

#[cfg(test)]
mod tests;

use coaxle_clock::Seconds;
use coaxle_curve::profile::{InvalidLimit, Kinematics, Limits};

pub use self::envelope::PACE;
pub use self::guarded::{DistancePolicy, GuardState, Guarded};

use self::approach::{stopping, towards_position, towards_velocity};
use self::differences::Differences;
use self::envelope::Envelope;
use self::target::{Course, Target};

/// Keeps the set values of an axis within its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetValueGuard {
    envelope: Envelope,
    policy: DistancePolicy,
    history: GuardHistory,
}

/// What a guard knows of the cycles so far: all of it that changes from one to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardHistory {
    /// What has left it.
    set: Differences,
    /// Velocity and acceleration that were stated beside it, and the cycles skipped before that, and before the one before.
    stated: Kinematics,
    skipped: [f64; 2],
    target: Target,
    /// How far the positions to follow are from those of the target, u.
    offset: f64,
    /// How many targets in a row have passed, up to [`LANDED`].
    passed: u8,
}

/// From so many targets in a row on, the differences of the set values are those of the target.
const LANDED: u8 = 3;

/// Where more cycles were skipped, the axis goes on as if it had been so many: the time that an update
/// takes is bounded.
const MOST_CYCLES: u32 = 5_000;

impl SetValueGuard {
    /// The guard of an axis that is in the state `here`, as [`start`](Self::start) takes it.
    ///
    /// Limits in u/s, u/s² and u/s³; software limits `min` and `max` in u, infinite where there is none.
    ///
    /// # Errors
    /// [`InvalidLimit`] unless the cycle time is a finite number above zero.
    pub fn new(
        limits: &Limits,
        min: f64,
        max: f64,
        cycle_time: Seconds,
        here: &Kinematics,
    ) -> Result<Self, InvalidLimit> {
        let received = cycle_time.0;
        if !(received.is_finite() && received > 0.0) {
            let field = "cycle time";
            return Err(InvalidLimit { field, received });
        }
        let here = finite(here, 0.0);
        Ok(Self {
            envelope: Envelope::new(limits, min, max, received),
            policy: DistancePolicy::default(),
            history: GuardHistory::of(&here, received),
        })
    }

    /// Begins anew at a state, without history: after power on, homing or setting a position, and to resume
    /// from a motion. The step to it is not guarded. What is no number counts as zero, a position as the
    /// last one.
    pub fn start(&mut self, here: &Kinematics) {
        let here = finite(here, self.history.set.position);
        self.history = GuardHistory::of(&here, self.envelope.cycle_time);
    }

    /// What it knows of the cycles so far, to [go back to](Self::go_back).
    #[must_use]
    pub const fn history(&self) -> GuardHistory {
        self.history
    }

    /// What came since then did not happen: no set values of it have left.
    pub const fn go_back(&mut self, history: GuardHistory) {
        self.history = history;
    }

    /// Other limits from the next cycle on, in u/s, u/s² and u/s³. The jerk keeps them at once; acceleration
    /// and velocity come back within them as fast as that allows, and stay.
    pub fn set_limits(&mut self, limits: &Limits) {
        self.envelope = self.envelope.with_limits(limits);
    }

    /// Other software limits from the next cycle on, u; infinite where there is none.
    pub fn set_software_limits(&mut self, min: f64, max: f64) {
        self.envelope = self.envelope.with_walls(min, max);
    }

    /// What becomes of a distance left behind, from the next cycle on. Without
    /// [`DistancePolicy::VeloSync`], one that has stayed is caught up.
    pub fn set_distance_policy(&mut self, policy: DistancePolicy) {
        self.policy = policy;
        if policy != DistancePolicy::VeloSync {
            self.history.offset = 0.0;
        }
    }

    /// How many of its cycles a time comes to.
    #[must_use]
    pub fn cycles_in(&self, elapsed: Seconds) -> u32 {
        (elapsed.0 / self.envelope.cycle_time + 0.5) as u32
    }

    /// One cycle: the set values for a target, in u, u/s and u/s².
    ///
    /// `elapsed` is how many cycles the last update is ago: 1, or more where cycles were skipped. Positions
    /// further apart in time are judged by their divided differences, which a motion that keeps the limits
    /// keeps whatever was skipped; where the guard moves the axis itself, it goes through the skipped cycles
    /// one by one, along the way that the target has come, and gives the last. (The closed forms know steps of
    /// one length only.) A gap hides the last of how a target brakes: from one that
    /// uses all of its limits the guard may depart there, for a moment, before the highest velocity or a
    /// software limit.
    ///
    /// A target with anything that is not a finite number is not followed; the axis comes to a stop.
    pub fn update(&mut self, target: &Kinematics, elapsed: u32) -> Guarded {
        let elapsed = elapsed.max(1);
        let cycles = f64::from(elapsed);
        self.history.target = self.history.target.then(target, cycles, self.envelope.rate);
        let state = if is_finite(target) {
            self.follow(target, elapsed)
        } else {
            self.stop(elapsed)
        };
        let changed_in = self.cycles_of_change(cycles);
        self.history.stated = self.set_values(target, state, changed_in);
        Guarded {
            set: self.history.stated,
            state,
            distance: self.history.set.position - self.history.target.last_position(),
        }
    }

    /// In how many cycles the velocity and the acceleration that are stated have changed: what they were at the end of
    /// skipped cycles, positions say only one cycle later of the velocity, and two of the acceleration.
    fn cycles_of_change(&mut self, cycles: f64) -> [f64; 2] {
        let [last, before] = self.history.skipped;
        self.history.skipped = [cycles - 1.0, last];
        [cycles + last, cycles + last + before]
    }

    /// The set values that left last, as another motion takes them over: velocity and acceleration as they
    /// state them where their positions bear that out, to what a motion within the jerk limit can differ
    /// from its differences, and else as the positions say.
    #[must_use]
    pub fn borne_out(&self, set: &Kinematics) -> Kinematics {
        if self.envelope.bears_out(&self.history.set, set) {
            *set
        } else {
            Kinematics {
                position: set.position,
                ..self.envelope.state_now(&self.history.set)
            }
        }
    }

    fn follow(&mut self, target: &Kinematics, elapsed: u32) -> GuardState {
        let wanted = self.position_to_follow(target);
        let rate = self.envelope.rate;
        let next = self.history.set.then(wanted, f64::from(elapsed), rate);
        if self.passes(&next) {
            self.history.set = next;
            self.history.passed = LANDED.min(self.history.passed + 1);
            GuardState::Tracking
        } else {
            self.depart(wanted, elapsed)
        }
    }

    fn position_to_follow(&self, target: &Kinematics) -> f64 {
        // Adding zero would change the sign of a zero.
        if self.history.offset == 0.0 {
            target.position
        } else {
            target.position + self.history.offset
        }
    }

    fn passes(&self, next: &Differences) -> bool {
        self.envelope.keeps(next, self.history.set.position)
            && (self.history.passed >= LANDED || self.passes_next(next))
    }

    /// Whether the next two targets will pass too, if this one does and its course goes on: without that,
    /// the axis would touch the target and leave it again.
    fn passes_next(&self, next: &Differences) -> bool {
        let cycle_time = self.envelope.cycle_time;
        let (mut from, mut course) = (*next, self.history.target.course(&self.envelope));
        (1..LANDED).all(|_| {
            course = course.later(1.0, cycle_time);
            let position = from.position + course.velocity * cycle_time;
            let to = from.then(position, 1.0, self.envelope.rate);
            let kept = self.envelope.keeps(&to, from.position);
            from = to;
            kept
        })
    }

    fn depart(&mut self, wanted: f64, elapsed: u32) -> GuardState {
        let course = self.history.target.course(&self.envelope);
        // It may be one bad target: the axis waits a cycle for the next, and is less disturbed by far.
        let waits = self.history.passed >= LANDED;
        self.history.passed = 0;
        self.go_on(wanted, &course, elapsed, waits);
        if self.policy == DistancePolicy::VeloSync && !waits {
            self.history.offset = self.history.set.position - self.history.target.last_position();
        }
        let possible =
            self.envelope.allows_velocity(course.velocity) && self.envelope.allows_position(wanted);
        match (possible, waits) {
            (false, _) => GuardState::Cannot,
            (true, true) => GuardState::Coasting,
            (true, false) => GuardState::CatchingUp,
        }
    }

    /// Cycle by cycle along the way of the target.
    fn go_on(&mut self, wanted: f64, course: &Course, elapsed: u32, waits: bool) {
        let cycle_time = self.envelope.cycle_time;
        let cycles = elapsed.min(MOST_CYCLES);
        for left in (0..cycles).rev() {
            if waits && left + 1 == cycles {
                self.advance(self.envelope.scaled(&self.history.set).b);
                continue;
            }
            let (wanted_then, course_then) = if left == 0 {
                (wanted, *course)
            } else {
                let (then, course) = self.history.target.before(left.into(), course, cycle_time);
                (then + self.history.offset, course)
            };
            self.advance(match self.policy {
                DistancePolicy::VeloSync => {
                    towards_velocity(&self.envelope, &self.history.set, &course_then)
                }
                DistancePolicy::PosSync1 => {
                    towards_position(&self.envelope, &self.history.set, wanted_then, &course_then)
                }
            });
        }
    }

    fn stop(&mut self, elapsed: u32) -> GuardState {
        self.history.passed = 0;
        for _ in 0..elapsed.min(MOST_CYCLES) {
            self.advance(stopping(&self.envelope, &self.history.set));
        }
        GuardState::Coasting
    }

    /// One cycle of an acceleration, or of the nearest that is possible, in units of the closed forms.
    fn advance(&mut self, acceleration: f64) {
        let possible = self.envelope.next_accelerations(&self.history.set);
        self.history.set = self
            .envelope
            .after(&self.history.set, possible.nearest(acceleration));
    }

    /// What leaves it. Drives feed velocity and acceleration forward: they are those that a target states as long as its
    /// positions bear them out, else those of the positions, and change no faster than the limits say, in as many cycles.
    fn set_values(&self, target: &Kinematics, state: GuardState, cycles: [f64; 2]) -> Kinematics {
        let (envelope, set) = (&self.envelope, &self.history.set);
        let is_stated = state == GuardState::Tracking
            && envelope.allows_velocity(target.velocity)
            && envelope.allows_acceleration(target.acceleration)
            && (envelope.is_quick() || self.history.target.is_consistent())
            && envelope.bears_out(set, target);
        let wanted = if is_stated {
            Kinematics {
                position: set.position,
                ..*target
            }
        } else {
            envelope.state_now(set)
        };
        envelope.steady(&self.history.stated, &wanted, set, cycles)
    }
}

impl GuardHistory {
    /// None: the axis is here.
    fn of(here: &Kinematics, cycle_time: f64) -> Self {
        Self {
            set: Differences::up_to(here, cycle_time),
            stated: *here,
            skipped: [0.0; 2],
            target: Target::at(here, cycle_time),
            offset: 0.0,
            passed: LANDED,
        }
    }
}

fn is_finite(state: &Kinematics) -> bool {
    [state.position, state.velocity, state.acceleration]
        .iter()
        .all(|value| value.is_finite())
}

/// What of a state is a number.
fn finite(state: &Kinematics, position: f64) -> Kinematics {
    let or = |value: f64, other: f64| if value.is_finite() { value } else { other };
    Kinematics {
        position: or(state.position, position),
        velocity: or(state.velocity, 0.0),
        acceleration: or(state.acceleration, 0.0),
    }
}
