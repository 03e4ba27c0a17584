//! Bringing an axis back to its master.

use coaxle_curve::profile::Kinematics;

use super::braking::{BRAKED, BRAKING, Braking};
use super::reach::{FASTER, Reach};

/// Longest return, s, to a master that has not moved yet, whose velocity is unknown, …
const TO_A_RESTING_MASTER: f64 = 30.0;
/// … and to one that has moved, even if only by its noise.
const LONGEST: f64 = 3_600.0;
/// Largest slope of the curve of the way back, …
const STEEPEST: f64 = 1.875;
/// … and its largest curvature: 10/√3.
const MOST_CURVED: f64 = 5.774;
/// Part of the way back after which the axis is brought from the motion of its master to the shown values, which are beside it by a beat
/// or the lag of a filter. The difference of the velocities is mostly gone by then.
const TO_SHOWN: f64 = 0.5;
/// Time constant of following the positions of a master whose frames come in beats, s: a beat of a cycle of 1 ms is 2 % of its velocity.
pub(super) const TRACKING: f64 = 0.05;
/// A way back that was planned while the master's velocity was below this part of its present
/// maximum is planned again: one that had just begun to move was brought back over a micrometre in
/// 22 s.
const OUTGROWN: f64 = 0.5;

/// A difference that decreases to zero: that of the velocity soon, that of the position along the way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rejoin {
    slowing: Braking,
    /// Difference of the position once that of the velocity is zero, u.
    way: f64,
    /// s.
    length: f64,
    since: f64,
    /// Greatest velocity of the master at the planning, u/s.
    fastest: f64,
    /// Motion of the master, in a mode that shows values as received.
    master: Option<Kinematics>,
}

impl Rejoin {
    /// Plans the way from `standing` to the motion of the master, of `shortest` seconds or more.
    pub(super) fn plan(
        standing: &Kinematics,
        master: &Kinematics,
        reach: &Reach,
        shortest: f64,
    ) -> Self {
        let ahead = Kinematics {
            position: standing.position - master.position,
            velocity: standing.velocity - master.velocity,
            acceleration: standing.acceleration - master.acceleration,
        };
        // Largest velocity of the difference: the master's, but at least that whose braking begins
        // with its greatest acceleration.
        let Reach {
            velocity: fastest,
            acceleration: hardest,
        } = *reach;
        let velocity = fastest.max(hardest * BRAKING / BRAKED);
        // Both 0 is a master that never moved: 0/0 would be NaN.
        let share = if velocity > 0.0 {
            (ahead.velocity.abs() / velocity).min(1.0)
        } else {
            1.0
        };
        // A small difference of the velocity takes a share of the time, so that its acceleration stays alike.
        let difference = Kinematics {
            position: 0.0,
            ..ahead
        };
        let length = (BRAKING * share).max(shortest);
        let slowing = Braking::new(difference, length, reach.gained());
        // The difference of the velocity travels a way by itself while it fades, which the second curve includes.
        let way = ahead.position + slowing.way();
        let longest = if fastest > 0.0 {
            LONGEST
        } else {
            TO_A_RESTING_MASTER
        };
        // A way so long that it would take more than the longest time is covered faster instead.
        let faster = (FASTER * fastest).max(STEEPEST * way.abs() / longest);
        // A master that has moved at constant speed only has shown no acceleration to take as a measure.
        let harder = hardest.max(BRAKED * fastest / BRAKING);
        // Without a measure neither bounds the time: 0/0 would be NaN, and a way over 0 endless.
        let by = |most: f64, length: f64| if most > 0.0 { length } else { 0.0 };
        // Quintic over the way w in the time t: largest velocity 1.875·w/t, …
        let for_velocity = by(faster, STEEPEST * way.abs() / faster);
        // … and largest acceleration 10/√3·w/t².
        let for_acceleration = by(harder, libm::sqrt(MOST_CURVED * way.abs() / harder));
        let for_way = for_velocity.max(for_acceleration.min(longest));
        Self {
            slowing,
            way,
            length: for_way.max(length),
            since: 0.0,
            fastest,
            master: None,
        }
    }

    /// The plan relative to this motion of the master, in a mode that shows values as received.
    pub(super) const fn beside(self, master: Option<Kinematics>) -> Self {
        Self { master, ..self }
    }

    /// Returns true as long as the plan stays in force: while its master stays alike, and moves as the axis can. The plan adds the
    /// velocity of the master. In wide schedule 500647 an extrapolated position moved at −245 000 u/s for 20 cycles, and the axis with it.
    pub(super) fn holds(&self, shown: &Kinematics, reach: &Reach) -> bool {
        self.fastest >= OUTGROWN * reach.velocity && reach.admits(self.target(shown).velocity)
    }

    /// Moves on by `passed` seconds; `master` is its motion now, in a mode that shows values as received.
    pub(super) fn go_on(&mut self, master: Option<Kinematics>, passed: f64) {
        self.since += passed;
        self.track(master, passed);
    }

    /// Greatest velocity of the way itself, beside that of its master, u/s.
    pub(super) fn own_velocity(&self) -> f64 {
        // Without a length there is no way left, and no quotient.
        match self.length > 0.0 {
            true => STEEPEST * self.way.abs() / self.length,
            false => 0.0,
        }
    }

    /// Distance of the motion of its master from where it is tracked in the next cycle, u: the beat in which it came.
    pub(super) fn beat(&self, now: Option<&Kinematics>, passed: f64) -> f64 {
        let tracked = self.master.zip(now);
        tracked.map_or(0.0, |(before, now)| {
            now.position - (before.position + now.velocity * passed)
        })
    }

    /// Returns true past its length, where the curve is the master itself, and from then on set values pass through to the bit.
    pub(super) fn is_over(&self) -> bool {
        self.since >= self.length
    }

    /// The axis beside this motion of its master.
    pub(super) fn over(&self, shown: &Kinematics) -> Kinematics {
        // The sum of the differences leaves a rounding residue, and the end is the master exactly.
        if self.is_over() {
            return *shown;
        }
        self.difference_over(&self.target(shown))
    }

    /// Follows the motion of the master in a mode that shows values as received, without its beats.
    fn track(&mut self, now: Option<Kinematics>, passed: f64) {
        self.master = match (self.master, now) {
            (Some(before), Some(now)) => {
                let on = before.position + now.velocity * passed;
                let position = on + tracked(self.beat(Some(&now), passed), passed);
                Some(Kinematics { position, ..now })
            }
            (_, now) => now,
        };
    }

    /// The motion to which the axis is brought back: first that of the master, in the end the shown values.
    fn target(&self, shown: &Kinematics) -> Kinematics {
        let Some(master) = self.master else {
            return *shown;
        };
        let x = ((self.since / self.length - TO_SHOWN) / (1.0 - TO_SHOWN)).clamp(0.0, 1.0);
        let share = x * x * (3.0 - 2.0 * x);
        let between = |from: f64, to: f64| from + share * (to - from);
        Kinematics {
            position: between(master.position, shown.position),
            velocity: between(master.velocity, shown.velocity),
            acceleration: between(master.acceleration, shown.acceleration),
        }
    }

    /// The master, with the rest of the difference on top.
    fn difference_over(&self, master: &Kinematics) -> Kinematics {
        let slowing = self.slowing.at(self.since);
        let left = self.way_left();
        Kinematics {
            // The differences are added up first: they vanish together, and only their sum meets the large position.
            position: master.position + (slowing.position - self.slowing.way() + left.position),
            velocity: master.velocity + slowing.velocity + left.velocity,
            acceleration: master.acceleration + slowing.acceleration + left.acceleration,
        }
    }

    /// Rest of the way: the quintic from it to 0, at rest at both ends.
    fn way_left(&self) -> Kinematics {
        let (way, t) = (self.way, self.length);
        let x = self.since / t;
        let y = 1.0 - x;
        Kinematics {
            // 1 - 10x³ + 15x⁴ - 6x⁵, with the triple root at x = 1 taken out: the expanded form cancels near the end.
            position: way * y * y * y * (1.0 + x * (3.0 + 6.0 * x)),
            velocity: -30.0 * way * x * x * y * y / t,
            acceleration: -60.0 * way * x * y * (1.0 - 2.0 * x) / (t * t),
        }
    }
}

/// Part of a beat that is tracked within `passed` seconds, u.
pub(super) fn tracked(beat: f64, passed: f64) -> f64 {
    (passed / TRACKING).min(1.0) * beat
}
