//! Limits of a series of set positions: of its differences, and the software limits, called walls here.

use coaxle_curve::profile::{Kinematics, Limits};

use super::closed_forms::{acceleration_to_gain, least_peak, speed_gained, stop_way};
use super::differences::Differences;
use super::range::Range;
use super::root::last_not_above;

/// Rounding of a position, relative to the largest number on the way: a quarter of the documented
/// value is left for the rounding of the guard.
pub(super) const ROUNDING: f64 = 3.0 * f64::EPSILON;

/// Rounding of a limit, relative.
const RELATIVE: f64 = 1e-9;

/// Time at the highest velocity whose distance is the largest number in the calculation of a target, s,
const WAY_OF_TARGET: f64 = 1.0;
/// but at most this, u: a velocity limit that means "none" shall not open the others.
// 3ε·1e15 would be a rounding of 0.7 u, 3ε·1e6 is 7e-10 u.
const LARGEST_WAY: f64 = 1e6;

/// Greatest distance of a target beyond a wall, relative: the rounding of its calculation.
const WALL_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The share by which positions of a master are faster or slower than its stated velocity. A master
/// that is moved to another time states the velocity in its own: the blocks of TS5066 remove a beat
/// of up to three cycles over ninety.
///
/// It is a property of the master and not of the guard: a check of a guard's output may use it,
/// too, without becoming weaker.
pub const PACE: f64 = 0.03;

/// Multiple of the jerk limit beyond which an axis does not nearly follow: a plan along the limits that goes with a master is beyond them by
/// the ripple of that, some percent.
const FAR_BEYOND: f64 = 2.0;

/// Greatest number of cycles in which a quick axis reaches its highest velocity. With 4, one of 10
/// 000 motions along all limits did not pass to the bit.
const QUICK: f64 = 8.0;

/// The limits of an axis at its cycle time, and the units of the closed forms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Envelope {
    limits: Limits,
    /// The part of them that is [binding](Limits::binding_in_cycles) for positions one cycle apart.
    binding: Limits,
    /// The jerk that the limit admits, in the units below, 1 if all of it is binding: an
    /// acceleration beyond its limit returns at this rate.
    spare_jerk: f64,
    min: f64,
    max: f64,
    pub(super) cycle_time: f64,
    /// Cycles per second.
    pub(super) rate: f64,
    /// `1/(j·T)`, `1/(j·T²)` and `1/(j·T³)`, with the binding jerk.
    per_acceleration: f64,
    per_velocity: f64,
    per_position: f64,
    /// The limits in these units.
    velocity: f64,
    pub(super) acceleration: f64,
    /// Hardest braking for a wall: a harder one could not keep the velocity limit afterwards.
    hardest: f64,
    /// Greatest distance of a stop from within the limits.
    longest_stop: f64,
}

/// Velocity and acceleration of a cycle in units of the closed forms, and the rounding of both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scaled {
    pub(super) w: f64,
    pub(super) b: f64,
    slack: f64,
}

impl Envelope {
    pub(super) fn new(limits: &Limits, min: f64, max: f64, cycle_time: f64) -> Self {
        // In units of a jerk limit of 1e13, which means "none", the root search is left without digits.
        let binding = limits.binding_in_cycles(cycle_time);
        let per_acceleration = 1.0 / (binding.jerk() * cycle_time);
        let per_velocity = per_acceleration / cycle_time;
        let velocity = limits.velocity() * per_velocity;
        let acceleration = highest_acceleration(&binding) * per_acceleration;
        // Velocity after the cycle that is chosen: at most one acceleration above the limit.
        let fastest = velocity + acceleration;
        Self {
            limits: *limits,
            binding,
            spare_jerk: limits.jerk() / binding.jerk(),
            min,
            max,
            cycle_time,
            rate: 1.0 / cycle_time,
            per_acceleration,
            per_velocity,
            per_position: per_velocity / cycle_time,
            velocity,
            acceleration,
            // Released from standstill on, it gains the highest velocity backwards, and no more.
            hardest: acceleration.min(acceleration_to_gain(velocity)),
            longest_stop: fastest + stop_way(fastest, acceleration, acceleration, acceleration),
        }
    }

    pub(super) fn with_limits(&self, limits: &Limits) -> Self {
        Self::new(limits, self.min, self.max, self.cycle_time)
    }

    pub(super) fn with_walls(&self, min: f64, max: f64) -> Self {
        Self { min, max, ..*self }
    }

    pub(super) const fn highest_velocity(&self) -> f64 {
        self.limits.velocity()
    }

    pub(super) fn allows_position(&self, position: f64) -> bool {
        (self.min..=self.max).contains(&position)
    }

    pub(super) fn allows_velocity(&self, velocity: f64) -> bool {
        velocity.abs() <= self.limits.velocity() * (1.0 + RELATIVE)
    }

    pub(super) fn allows_acceleration(&self, acceleration: f64) -> bool {
        acceleration.abs() <= highest_acceleration(&self.limits) * (1.0 + RELATIVE)
    }

    /// True for an axis that may reach its highest velocity, and stand again, within a few cycles.
    /// Positions a cycle apart show little of such a motion.
    pub(super) fn is_quick(&self) -> bool {
        self.limits.velocity() <= QUICK * highest_acceleration(&self.limits) * self.cycle_time
    }

    /// True if this acceleration of a target is credible.
    pub(super) fn is_credible(&self, acceleration: f64) -> bool {
        acceleration.abs() <= highest_acceleration(&self.binding) * (1.0 + RELATIVE)
    }

    /// True if a motion within the jerk limit that has passed through a series can have this
    /// velocity and acceleration now: the differences are the effect of the jerk in the time that
    /// they look back, the [pace](PACE) of the clock in which it is stated, and rounding.
    pub(super) fn confirms(&self, series: &Differences, state: &Kinematics) -> bool {
        let seen = self.state_now(series);
        let rounding = self.rounding(series.position, series.position) * self.rate;
        let (cycles, back) = series.looks_back();
        let acceleration = (state.acceleration - seen.acceleration).abs();
        let velocity = (state.velocity - seen.velocity).abs();
        // Within a cycle the acceleration may be larger than any that leads from one velocity to
        // another in a whole one.
        let most = highest_acceleration(&self.limits);
        // From one limit of the acceleration to the other: no jerk changes it by more.
        let change = (self.limits.jerk() * self.cycle_time).min(2.0 * most);
        let by_pace = [
            PACE * seen.velocity.abs(),
            2.0 * PACE * seen.acceleration.abs(),
        ];
        // Nor can it change by more than the effect of the largest acceleration in the skipped cycles.
        // A jerk over the time that the second difference looks back, integrated over half of the last one.
        let slower = 0.5 * change * self.cycle_time * back * cycles;
        let slower = slower.min(most * self.cycle_time * cycles);
        let weaker = (change * back).min(2.0 * most);
        velocity <= slower + by_pace[0] + 4.0 * rounding
            && acceleration <= weaker + by_pace[1] + 4.0 * rounding * self.rate
    }

    /// Velocity and acceleration of a state, limited in their change from the last one by the
    /// limits, or by the positions' changes if those began beyond the limits, over these numbers of
    /// cycles. Positions within the limits have such a state nearby: the part cut off is less than
    /// the effect of the jerk in a cycle, and follows in the next.
    pub(super) fn steady(
        &self,
        last: &Kinematics,
        wanted: &Kinematics,
        series: &Differences,
        cycles: [f64; 2],
    ) -> Kinematics {
        let rounding = self.rounding(wanted.position, wanted.position) * self.rate;
        let times = cycles.map(|cycles| cycles * self.cycle_time * (1.0 + RELATIVE));
        // No `clamp`, which panics if `most` is NaN.
        let near = |last: f64, wanted: f64, most: f64| wanted.max(last - most).min(last + most);
        let (mut push, mut change) = (highest_acceleration(&self.limits), self.limits.jerk());
        // Limits that were lowered in motion: stated values must follow the positions, which need time to return.
        if series.acceleration.abs() > push * (1.0 + RELATIVE) + 4.0 * rounding * self.rate {
            push = push.max(series.acceleration.abs());
            change = change.max(series.jerk.abs());
        }
        let push = push * times[0] + 2.0 * rounding;
        let change = change * times[1] + 4.0 * rounding * self.rate;
        Kinematics {
            position: wanted.position,
            velocity: near(last.velocity, wanted.velocity, push),
            acceleration: near(last.acceleration, wanted.acceleration, change),
        }
    }

    /// Converts to units of the closed forms.
    pub(super) fn scaled(&self, series: &Differences) -> Scaled {
        let rounding = self.rounding(series.position, series.position);
        Scaled {
            // Mean velocity of the last cycle even after skipped ones, as one step of the closed forms has it.
            w: series.velocity_of_cycle(self.cycle_time) * self.per_velocity,
            b: series.acceleration * self.per_acceleration,
            slack: rounding * self.per_position,
        }
    }

    /// Converts a distance to units of the closed forms.
    pub(super) fn scaled_way(&self, way: f64) -> f64 {
        way * self.per_position
    }

    /// Rounding of a position.
    fn rounding(&self, from: f64, to: f64) -> f64 {
        // Near position 0 a target's sums are still as large as the way it travels.
        let way = (WAY_OF_TARGET * self.limits.velocity()).min(LARGEST_WAY);
        ROUNDING * from.abs().max(to.abs()).max(way)
    }

    /// True if a series that comes from a position keeps every limit, and can continue to do so.
    #[inline]
    pub(super) fn keeps(&self, series: &Differences, from: f64) -> bool {
        let rounding = self.rounding(from, series.position) * self.rate;
        // Cheapest check first. Comparisons with NaN are false, so such a series is never kept.
        series.velocity.abs() <= self.limits.velocity() * (1.0 + RELATIVE) + rounding
            && self.is_smooth(series, from)
            && self.can_keep_velocity(series)
            && self.can_keep_walls(series, from)
    }

    /// True if acceleration and jerk of a series keep their limits.
    #[inline]
    fn is_smooth(&self, series: &Differences, from: f64) -> bool {
        self.is_smooth_within(&self.limits, series, from)
    }

    /// True if a series is a motion that an axis could make, and not a jump permitted only because
    /// limits mean "none".
    pub(super) fn is_motion(&self, series: &Differences, from: f64) -> bool {
        self.is_smooth_within(&self.binding, series, from)
    }

    /// True if the jerk of a series is far beyond its limit.
    #[inline]
    pub(super) fn is_rough(&self, series: &Differences, from: f64) -> bool {
        let rounding = self.rounding(from, series.position) * self.rate * self.rate * self.rate;
        series.jerk.abs() > FAR_BEYOND * self.binding.jerk() + 4.0 * rounding
    }

    #[inline]
    fn is_smooth_within(&self, limits: &Limits, series: &Differences, from: f64) -> bool {
        let rounding = self.rounding(from, series.position) * self.rate * self.rate;
        series.acceleration.abs()
            <= highest_acceleration(limits) * (1.0 + RELATIVE) + 2.0 * rounding
            && series.jerk.abs() <= limits.jerk() * (1.0 + RELATIVE) + 4.0 * rounding * self.rate
    }

    /// True if the speed stays within its limit while the acceleration is led to zero.
    #[inline]
    fn can_keep_velocity(&self, series: &Differences) -> bool {
        let Scaled { w, b, slack } = self.scaled(series);
        // Far out rounding alone shows an acceleration: without slack it would refuse a target at the highest
        // velocity.
        let gained = speed_gained((b.abs() - 2.0 * slack).max(0.0));
        // Only the direction in which the acceleration leads: the other one is checked by the velocity itself.
        w * 1.0_f64.copysign(b) + gained <= self.velocity * (1.0 + RELATIVE) + slack
    }

    /// True if it can stop before the walls. From beyond one it may return, or stay.
    #[inline]
    fn can_keep_walls(&self, series: &Differences, from: f64) -> bool {
        let at = series.position;
        let Scaled { w, b, slack } = self.scaled(series);
        let stops = |wall: f64, from: f64, at: f64, w: f64, b: f64| {
            // Mostly true, and it saves the closed form and its square root in each cycle that passes.
            if self.is_far((wall - at) * self.per_position, w, b) {
                return true;
            }
            let way = least_peak(w - slack, b - 2.0 * slack, self.hardest) / self.per_position;
            // From beyond the wall the present position takes its place: no farther, but it may stay.
            at + way <= (wall + WALL_ROUNDING * wall.abs().max(at.abs())).max(from)
        };
        stops(self.max, from, at, w, b) && stops(-self.min, -from, -at, -w, -b)
    }

    /// True if a wall is farther away than the stopping distance of any motion within the limits.
    #[inline]
    fn is_far(&self, room: f64, w: f64, b: f64) -> bool {
        room > self.longest_stop && w <= self.velocity && b <= self.acceleration
    }

    /// Possible accelerations of the next cycle. If two limits cannot both be kept, the first of
    /// these has priority: jerk, acceleration, walls, velocity.
    pub(super) fn next_accelerations(&self, series: &Differences) -> Range {
        let Scaled { w, b, slack } = self.scaled(series);
        let position = series.position;
        let (most, hardest) = (self.acceleration, self.hardest);
        // The rounding in the acceleration of a passed target may be reversed.
        // Twice the slack of a position, as accelerations have it: 2δ/T².
        let change = self.spare_jerk + 2.0 * slack;
        let range = Range::around(b, change).within(-most, most);
        let range = self.before_walls(range, position, w, hardest, |w, b| {
            least_peak(w, b, hardest)
        });
        // Greatest accelerations in this cycle whose release at the jerk limit ends at the highest velocity,
        // backwards and forwards.
        let slower = acceleration_to_gain(self.velocity + w);
        let faster = acceleration_to_gain(self.velocity - w);
        let range = range.within(-slower, faster);
        // The axis can stop before a wall by now; it shall do so without reversing.
        let range = self.before_walls(range, position, w, most, |w, b| stop_way(w, b, most, most));
        // Last, since nothing has priority over the jerk: the rounding granted above ends here.
        range.within(b - self.spare_jerk, b + self.spare_jerk)
    }

    /// The part of a range that leads to motions ending before the walls; if empty, the hardest braking.
    fn before_walls(
        &self,
        range: Range,
        position: f64,
        w: f64,
        hardest: f64,
        way: impl Fn(f64, f64) -> f64,
    ) -> Range {
        let before_wall = |range: Range, w: f64, room: f64| {
            let room = room * self.per_position;
            if self.is_far(room, w, range.high()) {
                return range;
            }
            // If even the hardest braking ends beyond the wall, the search returns it: as little beyond as possible.
            let low = range.nearest(-hardest);
            let beyond = |b: f64| w + b + way(w + b, b) - room;
            range.up_to(last_not_above(low, range.high(), beyond))
        };
        let range = before_wall(range, w, self.farthest_up(position) - position);
        let room = position - self.farthest_down(position);
        // The lower wall by the same code, mirrored at zero.
        before_wall(range.mirrored(), -w, room).mirrored()
    }

    /// Highest position allowed: the wall, or the current position beyond it.
    fn farthest_up(&self, position: f64) -> f64 {
        self.max.max(position)
    }

    fn farthest_down(&self, position: f64) -> f64 {
        self.min.min(position)
    }

    /// Continues a series for one cycle with an acceleration, in units of the closed forms.
    pub(super) fn after(&self, series: &Differences, acceleration: f64) -> Differences {
        let from = series.position;
        let acceleration = acceleration / self.per_acceleration;
        let velocity = series.velocity_of_cycle(self.cycle_time) + acceleration * self.cycle_time;
        let position = self.without_rounding(from, from + velocity * self.cycle_time);
        Differences::each_cycle(position, velocity, acceleration)
    }

    /// Continues a series for a number of cycles in each of which the acceleration changes by `change`, in units of the closed forms.
    pub(super) fn after_change(
        &self,
        series: &Differences,
        change: f64,
        cycles: f64,
    ) -> Differences {
        let Scaled { w, b, .. } = self.scaled(series);
        let (n, from) = (cycles, series.position);
        // Sums of b + k·u, and of these, over k = 1 … n.
        let triangle = n * (n + 1.0) / 2.0;
        let acceleration = b + n * change;
        let velocity = w + n * b + triangle * change;
        let way = n * w + triangle * (b + (n + 2.0) / 3.0 * change);
        let position = self.without_rounding(from, from + way / self.per_position);
        let velocity = velocity / self.per_velocity;
        Differences::each_cycle(position, velocity, acceleration / self.per_acceleration)
    }

    /// A next position, within the walls if only rounding is cut off.
    fn without_rounding(&self, from: f64, position: f64) -> f64 {
        let confined = position
            .min(self.farthest_up(from))
            .max(self.farthest_down(from));
        // Only rounding is cut off. A step back to a wall that came closer would break the jerk limit.
        let is_rounding = (position - confined).abs() <= self.rounding(from, position);
        if is_rounding { confined } else { position }
    }

    /// Current position and motion of a series.
    pub(super) fn state_now(&self, series: &Differences) -> Kinematics {
        let mean = series.velocity_of_cycle(self.cycle_time);
        // Half a cycle of acceleration may exceed the highest velocity, where its release has begun already.
        let highest = self.limits.velocity().max(mean.abs());
        // From the mean of the last cycle to its end.
        let velocity = mean + series.acceleration * self.cycle_time / 2.0;
        Kinematics {
            position: series.position,
            velocity: velocity.min(highest).max(-highest),
            acceleration: series.acceleration,
        }
    }
}

/// The larger limit, which a motion that keeps both keeps. The applicable one depends on the
/// direction of the motion.
fn highest_acceleration(limits: &Limits) -> f64 {
    limits.acceleration().max(limits.deceleration())
}
