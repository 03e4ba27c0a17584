//! The last stage of an axis: limits kept by the positions that leave it, for every motion.
//!
//! A [`SetValueGuard`] takes a target per cycle and returns the set values of the drive. A target
//! that keeps the limits passes with its own bits and without lag. From any other the guard departs
//! as little and as briefly as possible, and lands on it again exactly. It is not a filter: noise
//! is smoothed before, and the limits of the guard have to be some 20 % above those that a motion
//! is planned with, as a reserve for catching up.
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
//! # Guarantees
//!
//! The differences of the positions: velocity is the difference of two over the cycle time,
//! acceleration that of two velocities, jerk that of two accelerations. A motion that keeps a limit
//! keeps it in its differences too, so only rounding is added to a limit: with `δ = 4ε·max(|p|,
//! vmax·1 s)`, `δ/T` on the velocity, `2δ/T²` on the acceleration, `4δ/T³` on the jerk, and 1e-9 of
//! each. Beyond some 1e4 u that becomes noticeable; a modulo position or an offset helps.
//!
//! The larger of acceleration and deceleration applies, in both directions: the applicable one
//! depends on the direction of the motion, and a motion that keeps both keeps the larger.
//!
//! Software limits have priority over the velocity, after jerk and acceleration: if the axis cannot
//! stop in time, because limits were lowered or because it began too fast, it passes them as little
//! as possible. From beyond one it may return or stay, but move no farther. Rounding may add
//! `128ε·max(|p|, vmax·1 s)`.
//!
//! # Method
//!
//! There is no plan that could become stale. In each cycle the next acceleration is chosen such
//! that a stop from there, relative to the target, ends just at the target (see `closed_forms`),
//! within the limits of jerk, acceleration, walls and velocity. The positions of a target are
//! decisive; its stated velocity and acceleration only predict its course while its positions jump.
//!
//! A target that goes to and fro faster than the limits admit, such as one in beats or of coarse increments, is followed on average: at its
//! stated velocity, with half of the jerk. With all of the jerk, and the acceleration of each turn, a ripple of 0.2 µm at 400 Hz led an
//! axis 1.2 mm to and fro.

mod approach;
mod closed_forms;
mod differences;
mod envelope;
mod guarded;
mod long_gap;
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

/// State of a guard that changes from one cycle to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardHistory {
    /// Positions that have left it.
    set: Differences,
    /// Velocity and acceleration stated with the last position, and the cycles skipped before that,
    /// and before the one before.
    stated: Kinematics,
    skipped: [f64; 2],
    target: Target,
    /// Distance of the positions to follow from those of the target, u.
    offset: f64,
    /// Number of successive targets that have passed, up to [`LANDED`].
    passed: u8,
}

/// Number of successive targets from which on the differences of the set values are those of the target.
// A jerk spans four positions: the last one that did not pass is then no part of it.
const LANDED: u8 = 3;

/// Greatest number of skipped cycles that are simulated one by one, so that the time of an update is bounded.
// At 0.2 to 0.3 µs each (docs/SPEED.md) that takes some 1.5 ms.
const MOST_CYCLES: u32 = 5_000;

impl SetValueGuard {
    /// Creates the guard of an axis that is in the state `here`, as for [`start`](Self::start).
    ///
    /// Limits in u/s, u/s² and u/s³; software limits `min` and `max` in u, infinite if there is none.
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
        // A start that is not a number would stay in the differences for ever.
        let here = finite(here, 0.0);
        Ok(Self {
            envelope: Envelope::new(limits, min, max, received),
            policy: DistancePolicy::default(),
            history: GuardHistory::of(&here, received),
        })
    }

    /// Restarts at a state, without history: after power on, homing or setting a position, and to
    /// resume from a motion. The step to it is not guarded. Non-finite values count as zero, a
    /// non-finite position as the last one.
    pub fn start(&mut self, here: &Kinematics) {
        let here = finite(here, self.history.set.position);
        self.history = GuardHistory::of(&here, self.envelope.cycle_time);
    }

    /// The history of the cycles, to [go back to](Self::go_back).
    #[must_use]
    pub const fn history(&self) -> GuardHistory {
        self.history
    }

    /// Discards the cycles since then: their set values have not left the axis.
    pub const fn go_back(&mut self, history: GuardHistory) {
        self.history = history;
    }

    /// Sets other limits from the next cycle on, in u/s, u/s² and u/s³. The jerk keeps them at
    /// once; acceleration and velocity return within them as fast as that allows, and stay.
    pub fn set_limits(&mut self, limits: &Limits) {
        self.envelope = self.envelope.with_limits(limits);
    }

    /// Sets other software limits from the next cycle on, u; infinite if there is none.
    pub fn set_software_limits(&mut self, min: f64, max: f64) {
        self.envelope = self.envelope.with_walls(min, max);
    }

    /// Sets the policy for a distance left behind, from the next cycle on. Without
    /// [`DistancePolicy::VeloSync`], a remaining one is caught up.
    pub fn set_distance_policy(&mut self, policy: DistancePolicy) {
        self.policy = policy;
        if policy != DistancePolicy::VeloSync {
            self.history.offset = 0.0;
        }
    }

    /// Number of its cycles in a time.
    #[must_use]
    pub fn cycles_in(&self, elapsed: Seconds) -> u32 {
        // Rounded, not cut: clocks jitter around whole cycles. The cast saturates, and turns NaN into 0.
        (elapsed.0 / self.envelope.cycle_time + 0.5) as u32
    }

    /// Runs one cycle: returns the set values for a target, in u, u/s and u/s².
    ///
    /// `elapsed` is the number of cycles since the last update: 1, or more if cycles were skipped.
    /// Positions further apart in time are checked by their divided differences, which a motion
    /// within the limits keeps for any skipped cycles; if the guard moves the axis itself, it
    /// simulates the skipped cycles one by one, along the path of the target, and returns the last.
    /// (The closed forms have steps of one length only.) Of more than 5 000 it does so with the last
    /// ones, and brakes in those before. A gap hides the end of a target's braking:
    /// from a target that uses its limits fully the guard may depart there, for a moment, before
    /// the highest velocity or a software limit.
    ///
    /// A target with a non-finite value is not followed; the axis stops.
    pub fn update(&mut self, target: &Kinematics, elapsed: u32) -> Guarded {
        // 0 cycles would divide by zero.
        let elapsed = elapsed.max(1);
        let cycles = f64::from(elapsed);
        // Before the decision: the course of the target includes its newest position.
        self.history.target = self.history.target.then(target, cycles, &self.envelope);
        let state = if is_finite(target) {
            self.follow(target, elapsed)
        } else {
            self.stop(elapsed)
        };
        let distance = self.history.set.position - self.history.target.last_position();
        self.history.target.meet(distance, &self.envelope);
        let changed_in = self.cycles_of_change(cycles);
        self.history.stated = self.set_values(target, state, changed_in);
        Guarded {
            set: self.history.stated,
            state,
            distance,
        }
    }

    /// Numbers of cycles over which the stated velocity and acceleration have changed: after
    /// skipped cycles, positions show the velocity only one cycle later, and the acceleration two.
    fn cycles_of_change(&mut self, cycles: f64) -> [f64; 2] {
        let [last, before] = self.history.skipped;
        self.history.skipped = [cycles - 1.0, last];
        [cycles + last, cycles + last + before]
    }

    /// The last set values, as another motion takes them over: velocity and acceleration as stated
    /// if their positions confirm them, within the possible deviation of a motion within the jerk
    /// limit from its differences, and else those of the positions.
    #[must_use]
    pub fn borne_out(&self, set: &Kinematics) -> Kinematics {
        if self.envelope.confirms(&self.history.set, set) {
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
            // Only on landing: a target that has passed until now is not held back by what it might do next.
            && (self.history.passed >= LANDED || self.passes_next(next))
    }

    /// True if the next two targets will pass too, provided this one does and its course continues:
    /// otherwise the axis would touch the target and leave it again.
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
        // A single bad target is possible: the axis waits a cycle for the next, and is far less disturbed.
        let waits = self.history.passed >= LANDED;
        self.history.passed = 0;
        self.go_on(wanted, &course, elapsed, waits);
        // Not in the first cycle: a single wrong position would leave a distance.
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

    /// Simulates cycle by cycle along the path of the target.
    fn go_on(&mut self, wanted: f64, course: &Course, elapsed: u32, waits: bool) {
        let cycle_time = self.envelope.cycle_time;
        // The last ones of a longer gap, which end at the target: where that was before is unknown anyway, and the axis brakes.
        // Without that it would stand still at its velocity, which no motion within the jerk limit does (wide schedule 608381).
        let cycles = elapsed.min(MOST_CYCLES);
        self.brake_for(elapsed - cycles);
        for left in (0..cycles).rev() {
            // Without jerk: at the same acceleration the target is met again if it goes on as before.
            if waits && left + 1 == cycles {
                self.advance(self.envelope.scaled(&self.history.set).b);
                continue;
            }
            let (wanted_then, course_then) = if left == 0 {
                (wanted, *course)
            } else {
                let (then, course) = self.history.target.before(left.into(), course, cycle_time);
                // The offset of a distance left behind applies along the whole path.
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
        let cycles = elapsed.min(MOST_CYCLES);
        self.brake_for(elapsed - cycles);
        for _ in 0..cycles {
            self.advance(stopping(&self.envelope, &self.history.set));
        }
        GuardState::Coasting
    }

    /// Advances one cycle with an acceleration, or with the nearest possible one, in units of the
    /// closed forms.
    fn advance(&mut self, acceleration: f64) {
        let possible = self.envelope.next_accelerations(&self.history.set);
        self.history.set = self
            .envelope
            .after(&self.history.set, possible.nearest(acceleration));
    }

    /// The set values that leave the guard. Drives feed velocity and acceleration forward: they are
    /// those stated by the target as long as its positions confirm them, else those of the
    /// positions, and change no faster than the limits allow, over these numbers of cycles.
    fn set_values(&self, target: &Kinematics, state: GuardState, cycles: [f64; 2]) -> Kinematics {
        let (envelope, set) = (&self.envelope, &self.history.set);
        let is_stated = state == GuardState::Tracking
            && envelope.allows_velocity(target.velocity)
            && envelope.allows_acceleration(target.acceleration)
            // A quick axis may start and stop between two positions, which then confirm no stated velocity.
            && (envelope.is_quick() || self.history.target.is_consistent())
            && envelope.confirms(set, target);
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
    /// Starts a history at the current state of the axis.
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

/// The finite values of a state.
fn finite(state: &Kinematics, position: f64) -> Kinematics {
    let or = |value: f64, other: f64| if value.is_finite() { value } else { other };
    Kinematics {
        position: or(state.position, position),
        velocity: or(state.velocity, 0.0),
        acceleration: or(state.acceleration, 0.0),
    }
}
