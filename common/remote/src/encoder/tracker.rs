//! A jerk-limited tracker: set values that follow any estimate.
//!
//! A third-order loop whose bandwidth falls if its errors require more than the jerk limit, so that
//! it never reaches that limit; without it the loop diverges in ramps. It never moves against the
//! direction of the axis: it brakes so that its velocity reaches 0 without undershoot.

use coaxle_axis::TravelDirection;
use coaxle_curve::profile::Kinematics;

use super::parameters::CheckedEncoder;
use super::smoothing::LEAST_BANDWIDTH;
use super::walk::Walk;

/// Set values and the state that follows them up.
#[derive(Clone, Debug)]
pub(super) struct Tracker {
    /// rad/s.
    bandwidth: f64,
    jerk: f64,
    acceleration: f64,
    trim_speed: f64,
    /// Length too far ahead at rest, u.
    ahead: f64,
    cycle: f64,
    /// Parts of an error that are corrected in a cycle at full bandwidth.
    part: f64,
    state: Kinematics,
    /// Time at rest, s.
    rest: f64,
    walk: Option<Walk>,
    /// True if the newest step was one of a walk, or the end of one that was broken off.
    walked: bool,
}

/// Jerk that each single error may require, in jerk limits. Together they mostly require less; one
/// that requires more is of a motion that changes too fast to be caught up with at once.
const EACH: f64 = 2.0;
/// Number of steps that find the largest bandwidth within the jerk limit.
const BISECTIONS: u32 = 8;
/// Time at rest before it may walk back, s.
const REST_BEFORE_WALK: f64 = 0.05;
/// Largest number of steps at once: more cycles are calculated in longer steps.
const MOST_STEPS: u32 = 8;

impl Tracker {
    /// At rest at a position.
    pub(super) fn new(checked: &CheckedEncoder, position: f64) -> Self {
        let given = &checked.given;
        Self {
            bandwidth: checked.bandwidth,
            jerk: given.jerk_limit,
            acceleration: given.acceleration_limit,
            trim_speed: given.trim_speed,
            ahead: 0.5 * given.increment,
            cycle: checked.cycle,
            part: part(checked.bandwidth, checked.cycle),
            state: Kinematics::at_rest(position),
            rest: 0.0,
            walk: None,
            walked: false,
        }
    }

    pub(super) const fn state(&self) -> &Kinematics {
        &self.state
    }

    pub(super) const fn is_walking(&self) -> bool {
        self.walked
    }

    /// Moves to the goal at once.
    pub(super) fn jump(&mut self, goal: &Kinematics) {
        self.state = *goal;
        self.rest = 0.0;
        self.walk = None;
        self.walked = false;
    }

    /// Moves for `elapsed` cycles, after which the axis is at the goal.
    pub(super) fn follow(
        &mut self,
        goal: &Kinematics,
        direction: Option<TravelDirection>,
        elapsed: u32,
    ) {
        let (steps, time) = self.steps(elapsed);
        for left in (0..steps).rev() {
            self.walk_if_ahead(goal, direction);
            // A walk that is broken off still ends with its velocity against the direction, which stays announced
            // until then.
            self.walked = self.walk.is_some() || (self.walked && self.is_against(direction));
            // The goal is the axis after all steps, and a step takes it at its own beginning: as many steps back as
            // are left.
            let now = moved(goal, -f64::from(left + 1) * time);
            self.step(&now, direction, time);
        }
    }

    /// Comes to rest at any position.
    pub(super) fn stop(&mut self, direction: Option<TravelDirection>, elapsed: u32) {
        self.walk = None;
        let (steps, time) = self.steps(elapsed);
        for _ in 0..steps {
            self.walked = self.walked && self.is_against(direction);
            let here = Kinematics::at_rest(self.state.position);
            self.step(&here, direction, time);
        }
    }

    /// Number of steps for this number of cycles, and the length of one.
    fn steps(&self, elapsed: u32) -> (u32, f64) {
        // A stall of seconds must not cost thousands of steps in the cycle after it.
        let steps = elapsed.clamp(1, MOST_STEPS);
        let whole = f64::from(elapsed.max(1)) * self.cycle;
        (steps, whole / f64::from(steps))
    }

    /// Runs one step; `goal` is the axis at its beginning.
    fn step(&mut self, goal: &Kinematics, direction: Option<TravelDirection>, time: f64) {
        match &mut self.walk {
            Some(walk) => {
                self.state = walk.advance(time);
                if walk.is_done() {
                    self.walk = None;
                    self.rest = 0.0;
                }
            }
            None => {
                let jerk = self.jerk(goal, direction, time);
                self.move_by(jerk, time);
            }
        }
    }

    fn is_against(&self, direction: Option<TravelDirection>) -> bool {
        direction.is_some_and(|direction| self.state.velocity * direction.sign() < 0.0)
    }

    fn walk_if_ahead(&mut self, goal: &Kinematics, direction: Option<TravelDirection>) {
        if let Some(walk) = &self.walk {
            // The axis moved on during the walk, which would end at the wrong place.
            let is_left = (goal.position - walk.target()).abs() > self.ahead;
            if is_left {
                self.walk = None;
            }
            return;
        }
        let sign = direction.map_or(0.0, TravelDirection::sign);
        let ahead = (self.state.position - goal.position) * sign;
        // All conditions of rest: the loop has settled, the axis stands, and the difference is one that the count
        // excludes.
        if self.rest >= REST_BEFORE_WALK && ahead > self.ahead && goal.velocity == 0.0 {
            let limits = (self.trim_speed, self.acceleration, self.jerk);
            self.walk = Some(Walk::new(self.state.position, goal.position, limits));
        }
    }

    /// The jerk until the end of the step.
    fn jerk(&self, goal: &Kinematics, direction: Option<TravelDirection>, time: f64) -> f64 {
        let wanted = self.wanted_jerk(goal, time);
        let now = self.state.acceleration;
        // Jerk first, then acceleration, then the way to 0: each later bound only reduces the result of the one
        // before.
        let limited = wanted.clamp(-self.jerk, self.jerk);
        let next = (now + limited * time).clamp(-self.acceleration, self.acceleration);
        let next = match direction {
            Some(direction) => self.without_undershoot(next, direction.sign(), time),
            None => next,
        };
        // Keeping the last two may take more than the jerk limit, which wins.
        ((next - now) / time).clamp(-self.jerk, self.jerk)
    }

    /// Jerk of the largest bandwidth that keeps the limit.
    fn wanted_jerk(&self, goal: &Kinematics, time: f64) -> f64 {
        let errors = Kinematics {
            position: goal.position - self.state.position,
            velocity: goal.velocity - self.state.velocity,
            acceleration: goal.acceleration - self.state.acceleration,
        };
        // Bisection starts from the bandwidth at which no single error needs too much, which is mostly right at once.
        let most = self.part_for_each(&errors, time);
        let jerk = jerk_for(&errors, most, time);
        if jerk.abs() <= self.jerk {
            return jerk;
        }
        let (mut low, mut high) = (part(LEAST_BANDWIDTH, time).min(most), most);
        // Eight halvings leave 1/256 of the interval. The lower end keeps the limit if any bandwidth does.
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if jerk_for(&errors, middle, time).abs() <= self.jerk {
                low = middle;
            } else {
                high = middle;
            }
        }
        jerk_for(&errors, low, time)
    }

    /// Part of the errors that is corrected in one step, so that no single one requires too much.
    fn part_for_each(&self, errors: &Kinematics, time: f64) -> f64 {
        let limit = EACH * self.jerk;
        let position = errors.position.abs();
        let velocity = errors.velocity.abs();
        let acceleration = errors.acceleration.abs();
        let full = self.bandwidth;
        let mut bandwidth = full;
        // Bandwidth at which an error e needs the jerk J: ω³·e = J for a position, ω²·e for a velocity, ω·e for an
        // acceleration.
        if position * full * full * full > limit {
            bandwidth = libm::cbrt(limit / position);
        }
        if velocity * bandwidth * bandwidth > limit {
            bandwidth = libm::sqrt(limit / velocity);
        }
        if acceleration * bandwidth > limit {
            bandwidth = limit / acceleration;
        }
        // The usual case, whose exponential was calculated at the start. Exact comparison: both are copies.
        if bandwidth == full && time == self.cycle {
            return self.part;
        }
        part(bandwidth.max(LEAST_BANDWIDTH), time)
    }

    /// Bounds the acceleration at the end of a step so that the velocity can still reach 0 without
    /// changing its sign, with jerks that are constant over steps.
    ///
    /// Braking that ends in n steps with the acceleration falling evenly takes the velocity a·n·T/2.
    fn without_undershoot(&self, next: f64, sign: f64, time: f64) -> f64 {
        let (velocity, now) = (self.state.velocity * sign, self.state.acceleration * sign);
        // An undershoot that exists already may end as fast as the jerk allows.
        if velocity < 0.0 {
            return next;
        }
        let step = self.jerk * time;
        // Velocity and acceleration of now in units of T/2. A braking b at the end of this step, released in n even
        // steps, takes b·(n + 1) of it.
        let left = (2.0 * velocity / time + now).max(0.0);
        if next * sign >= 0.0 && left > 0.0 {
            return next;
        }
        // Largest n with n(n + 1) steps of jerk inside the rest: b = n·j·T in n further steps.
        let steps = libm::floor(0.5 * (libm::sqrt(1.0 + 4.0 * left / step) - 1.0));
        // A step more with b = left/(n + 2) may brake harder than n full ones.
        let most = (steps * step).max(left / (steps + 2.0));
        sign * (next * sign).max(-most)
    }

    fn move_by(&mut self, jerk: f64, time: f64) {
        let Kinematics {
            position,
            velocity,
            acceleration,
        } = self.state;
        self.state = Kinematics {
            position: position
                + time * (velocity + time * (0.5 * acceleration + time * jerk / 6.0)),
            velocity: velocity + time * (acceleration + 0.5 * time * jerk),
            acceleration: acceleration + time * jerk,
        };
        // The rounding residue of a velocity of 0 is no motion.
        let least = 1e-9 * self.jerk * time * time;
        if self.state.velocity.abs() <= least && self.state.acceleration.abs() * time <= least {
            self.state = Kinematics::at_rest(self.state.position);
            self.rest += time;
        } else {
            self.rest = 0.0;
        }
    }
}

/// Part of an error that is corrected in a time.
fn part(bandwidth: f64, time: f64) -> f64 {
    // 1 - e^(-x) cancels at small x, where `expm1` keeps all digits.
    -libm::expm1(-bandwidth * time)
}

/// Jerk that corrects a part of the errors in a step: it places all three poles of the loop at 1 −
/// `part`.
fn jerk_for(errors: &Kinematics, part: f64, time: f64) -> f64 {
    let d = part;
    let rate = 1.0 / time;
    let by_acceleration = d * (3.0 + d * (d / 3.0 - 1.5));
    let by_velocity = d * d * (3.0 - d);
    let by_position = d * d * d;
    rate * (by_acceleration * errors.acceleration
        + rate * (by_velocity * errors.velocity + rate * by_position * errors.position))
}

/// State of a motion of constant acceleration after a time.
pub(super) fn moved(state: &Kinematics, time: f64) -> Kinematics {
    Kinematics {
        position: state.position + time * (state.velocity + 0.5 * time * state.acceleration),
        velocity: state.velocity + time * state.acceleration,
        acceleration: state.acceleration,
    }
}
