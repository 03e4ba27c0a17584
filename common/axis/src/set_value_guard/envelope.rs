//! What a series of set positions may do: the limits of its differences, and the software limits, called
//! walls here.

use coaxle_curve::profile::{Kinematics, Limits};

use super::closed_forms::{acceleration_to_gain, least_peak, speed_gained, stop_way};
use super::differences::Differences;
use super::range::Range;
use super::root::last_not_above;

/// What rounding may add to a position, relative to the largest number on the way: of what is documented, a
/// quarter is left for the rounding of the guard.
pub(super) const ROUNDING: f64 = 3.0 * f64::EPSILON;

/// What rounding may add to a limit, relative.
const RELATIVE: f64 = 1e-9;

/// A target is calculated from numbers as large as its way of so long at the highest velocity, s,
const WAY_OF_TARGET: f64 = 1.0;
/// but from none larger than this, u: a velocity limit that means "none" shall not open the others.
const LARGEST_WAY: f64 = 1e6;

/// How far a target may be beyond a wall, relative: the rounding of whoever calculates it.
const WALL_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The share by which positions of a master are faster or slower than the velocity that it states. A master that is
/// brought to another time states what it does in its own: the blocks of TS5066 take a beat of up to three cycles away over ninety.
///
/// It is a fact of the master and not of the guard: a check of what leaves a guard may use it too, and sees no less by it.
pub const PACE: f64 = 0.03;

/// An axis is quick that reaches its highest velocity within this number of cycles. Of 10 000 motions along all limits one did not
/// pass to the bit with 4.
const QUICK: f64 = 8.0;

/// The limits of an axis at its cycle time, and the units of the closed forms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Envelope {
    limits: Limits,
    /// The part of them that [binds](Limits::binding_in_cycles) positions one cycle apart.
    binding: Limits,
    /// The jerk that the limit admits, in the units below, 1 where all of it binds: an acceleration beyond its limit
    /// comes back as fast as that.
    spare_jerk: f64,
    min: f64,
    max: f64,
    pub(super) cycle_time: f64,
    /// Cycles per second.
    pub(super) rate: f64,
    /// `1/(j·T)`, `1/(j·T²)` and `1/(j·T³)`, with the jerk that binds.
    per_acceleration: f64,
    per_velocity: f64,
    per_position: f64,
    /// The limits in these units.
    velocity: f64,
    pub(super) acceleration: f64,
    /// The most that is used to stop at a wall: harder, the velocity limit could not be kept afterwards.
    hardest: f64,
    /// No stop from within the limits takes a longer way.
    longest_stop: f64,
}

/// Velocity and acceleration of a cycle in units of the closed forms, and what rounding may add to both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scaled {
    pub(super) w: f64,
    pub(super) b: f64,
    slack: f64,
}

impl Envelope {
    pub(super) fn new(limits: &Limits, min: f64, max: f64, cycle_time: f64) -> Self {
        let binding = limits.binding_in_cycles(cycle_time);
        let per_acceleration = 1.0 / (binding.jerk() * cycle_time);
        let per_velocity = per_acceleration / cycle_time;
        let velocity = limits.velocity() * per_velocity;
        let acceleration = highest_acceleration(&binding) * per_acceleration;
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

    /// Tells an axis that may reach its highest velocity, and stand again, within a few cycles. Positions a cycle apart say little of
    /// such a motion.
    pub(super) fn is_quick(&self) -> bool {
        self.limits.velocity() <= QUICK * highest_acceleration(&self.limits) * self.cycle_time
    }

    /// Whether a target may be taken to accelerate so.
    pub(super) fn believes(&self, acceleration: f64) -> bool {
        acceleration.abs() <= highest_acceleration(&self.binding) * (1.0 + RELATIVE)
    }

    /// Whether a motion within the jerk limit that has gone through a series can have this velocity and acceleration now:
    /// it differs by what the jerk does in the time that the differences look back, by the [pace](PACE) of the clock that
    /// it is stated in, and by rounding.
    pub(super) fn bears_out(&self, series: &Differences, state: &Kinematics) -> bool {
        let seen = self.state_now(series);
        let rounding = self.rounding(series.position, series.position) * self.rate;
        let (cycles, back) = series.looks_back();
        let acceleration = (state.acceleration - seen.acceleration).abs();
        let velocity = (state.velocity - seen.velocity).abs();
        // Within a cycle the acceleration may be larger than any that leads from one velocity to another in a whole one.
        let most = highest_acceleration(&self.limits);
        let change = (self.limits.jerk() * self.cycle_time).min(2.0 * most);
        let by_pace = [
            PACE * seen.velocity.abs(),
            2.0 * PACE * seen.acceleration.abs(),
        ];
        // Nor can it change by more than the largest acceleration makes of the skipped cycles.
        let slower = 0.5 * change * self.cycle_time * back * cycles;
        let slower = slower.min(most * self.cycle_time * cycles);
        let weaker = (change * back).min(2.0 * most);
        velocity <= slower + by_pace[0] + 4.0 * rounding
            && acceleration <= weaker + by_pace[1] + 4.0 * rounding * self.rate
    }

    /// Velocity and acceleration of a state that come no faster from those of the last one than the limits say, or than the
    /// positions do where those began beyond the limits, in these cycles for each. Positions within the limits have such a state near by: what is cut off is less than what the jerk does
    /// in a cycle, and comes in the next.
    pub(super) fn steady(
        &self,
        last: &Kinematics,
        wanted: &Kinematics,
        series: &Differences,
        cycles: [f64; 2],
    ) -> Kinematics {
        let rounding = self.rounding(wanted.position, wanted.position) * self.rate;
        let times = cycles.map(|cycles| cycles * self.cycle_time * (1.0 + RELATIVE));
        let near = |last: f64, wanted: f64, most: f64| wanted.max(last - most).min(last + most);
        let (mut push, mut change) = (highest_acceleration(&self.limits), self.limits.jerk());
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

    /// In units of the closed forms.
    pub(super) fn scaled(&self, series: &Differences) -> Scaled {
        let rounding = self.rounding(series.position, series.position);
        Scaled {
            w: series.velocity_of_cycle(self.cycle_time) * self.per_velocity,
            b: series.acceleration * self.per_acceleration,
            slack: rounding * self.per_position,
        }
    }

    /// A way in units of the closed forms.
    pub(super) fn scaled_way(&self, way: f64) -> f64 {
        way * self.per_position
    }

    /// What rounding may add to a position.
    fn rounding(&self, from: f64, to: f64) -> f64 {
        let way = (WAY_OF_TARGET * self.limits.velocity()).min(LARGEST_WAY);
        ROUNDING * from.abs().max(to.abs()).max(way)
    }

    /// Whether a series that has come from a position keeps every limit, and can go on doing so.
    #[inline]
    pub(super) fn keeps(&self, series: &Differences, from: f64) -> bool {
        let rounding = self.rounding(from, series.position) * self.rate;
        series.velocity.abs() <= self.limits.velocity() * (1.0 + RELATIVE) + rounding
            && self.is_smooth(series, from)
            && self.can_keep_velocity(series)
            && self.can_keep_walls(series, from)
    }

    /// Whether acceleration and jerk of a series keep their limits.
    #[inline]
    fn is_smooth(&self, series: &Differences, from: f64) -> bool {
        self.is_smooth_within(&self.limits, series, from)
    }

    /// Whether a series is a motion that an axis could make, and not a jump that no limit forbids because they mean
    /// "none".
    pub(super) fn is_motion(&self, series: &Differences, from: f64) -> bool {
        self.is_smooth_within(&self.binding, series, from)
    }

    #[inline]
    fn is_smooth_within(&self, limits: &Limits, series: &Differences, from: f64) -> bool {
        let rounding = self.rounding(from, series.position) * self.rate * self.rate;
        series.acceleration.abs()
            <= highest_acceleration(limits) * (1.0 + RELATIVE) + 2.0 * rounding
            && series.jerk.abs() <= limits.jerk() * (1.0 + RELATIVE) + 4.0 * rounding * self.rate
    }

    /// Whether the speed stays within its limit while the acceleration is led to zero.
    #[inline]
    fn can_keep_velocity(&self, series: &Differences) -> bool {
        let Scaled { w, b, slack } = self.scaled(series);
        let gained = speed_gained((b.abs() - 2.0 * slack).max(0.0));
        w * 1.0_f64.copysign(b) + gained <= self.velocity * (1.0 + RELATIVE) + slack
    }

    /// Whether it can stop before the walls. From beyond one it may come back, or stay.
    #[inline]
    fn can_keep_walls(&self, series: &Differences, from: f64) -> bool {
        let at = series.position;
        let Scaled { w, b, slack } = self.scaled(series);
        let stops = |wall: f64, from: f64, at: f64, w: f64, b: f64| {
            if self.is_far((wall - at) * self.per_position, w, b) {
                return true;
            }
            let way = least_peak(w - slack, b - 2.0 * slack, self.hardest) / self.per_position;
            at + way <= (wall + WALL_ROUNDING * wall.abs().max(at.abs())).max(from)
        };
        stops(self.max, from, at, w, b) && stops(-self.min, -from, -at, -w, -b)
    }

    /// Whether a wall is farther away than any motion needs that goes no faster than the limits.
    #[inline]
    fn is_far(&self, room: f64, w: f64, b: f64) -> bool {
        room > self.longest_stop && w <= self.velocity && b <= self.acceleration
    }

    /// The accelerations that the next cycle may have. Of two limits that cannot be kept together, the one
    /// that comes first wins: jerk, acceleration, walls, velocity.
    pub(super) fn next_accelerations(&self, series: &Differences) -> Range {
        let Scaled { w, b, slack } = self.scaled(series);
        let position = series.position;
        let (most, hardest) = (self.acceleration, self.hardest);
        // What rounding has added to the acceleration of a target that passed may be taken back.
        let change = self.spare_jerk + 2.0 * slack;
        let range = Range::around(b, change).within(-most, most);
        let range = self.before_walls(range, position, w, hardest, |w, b| {
            least_peak(w, b, hardest)
        });
        let slower = acceleration_to_gain(self.velocity + w);
        let faster = acceleration_to_gain(self.velocity - w);
        let range = range.within(-slower, faster);
        // It can stop before a wall by now; it shall do so without turning back.
        let range = self.before_walls(range, position, w, most, |w, b| stop_way(w, b, most, most));
        range.within(b - self.spare_jerk, b + self.spare_jerk)
    }

    /// What of a range leads to motions that still go no farther than to the walls; where none does, what
    /// brakes hardest.
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
            let low = range.nearest(-hardest);
            let beyond = |b: f64| w + b + way(w + b, b) - room;
            range.up_to(last_not_above(low, range.high(), beyond))
        };
        let range = before_wall(range, w, self.farthest_up(position) - position);
        let room = position - self.farthest_down(position);
        before_wall(range.mirrored(), -w, room).mirrored()
    }

    /// How far the axis may go up: to the wall, or no farther beyond it.
    fn farthest_up(&self, position: f64) -> f64 {
        self.max.max(position)
    }

    fn farthest_down(&self, position: f64) -> f64 {
        self.min.min(position)
    }

    /// A series goes on for one cycle with an acceleration, in units of the closed forms.
    pub(super) fn after(&self, series: &Differences, acceleration: f64) -> Differences {
        let from = series.position;
        let acceleration = acceleration / self.per_acceleration;
        let velocity = series.velocity_of_cycle(self.cycle_time) + acceleration * self.cycle_time;
        let position = from + velocity * self.cycle_time;
        let confined = position
            .min(self.farthest_up(from))
            .max(self.farthest_down(from));
        let is_rounding = (position - confined).abs() <= self.rounding(from, position);
        let position = if is_rounding { confined } else { position };
        Differences::each_cycle(position, velocity, acceleration)
    }

    /// Where a series is, and how it moves at that moment.
    pub(super) fn state_now(&self, series: &Differences) -> Kinematics {
        let mean = series.velocity_of_cycle(self.cycle_time);
        let highest = self.limits.velocity().max(mean.abs());
        let velocity = mean + series.acceleration * self.cycle_time / 2.0;
        Kinematics {
            position: series.position,
            velocity: velocity.min(highest).max(-highest),
            acceleration: series.acceleration,
        }
    }
}

/// Which of the two applies turns on the direction of the motion; what keeps both keeps the larger.
fn highest_acceleration(limits: &Limits) -> f64 {
    limits.acceleration().max(limits.deceleration())
}
