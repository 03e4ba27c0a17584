//! Set values without steps in every state of the node that they come from.
//!
//! The blocks of TS5066 freeze an axis without data, and jump to its position when the data are
//! back. Here it is braked instead, and brought back along a curve: positions, velocities and
//! accelerations are continuous. In normal operation set values pass through unchanged, to the bit.
//! Not in the manual.

use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::Kinematics;

use super::prediction::moved_on;

/// An axis without data comes to rest within this time, s.
const BRAKING: f64 = 0.5;
/// While it is brought back it is faster or slower than its master by at most this part of its greatest velocity up to
/// then, however long that takes: a follower of the axis needs one and a half times the velocity of the master, and no more.
/// A clock that flipped for 40 s left it 24 m behind, and a return within 30 s took four times the velocity of its master.
const FASTER: f64 = 0.5;
/// Longest return, s, to a master that has not moved yet, whose velocity is unknown, …
const TO_A_RESTING_MASTER: f64 = 30.0;
/// … and to one that has moved, even if only by its noise.
const LONGEST: f64 = 3_600.0;
/// Set values whose positions and velocity differ by more than this part of the greatest velocity
/// up to then are evaluated by their positions: those of a mode that shows every beat, or that
/// stand still without new data.
const CONTRADICTION: f64 = 0.05;
/// Positions at most this number of cycles apart give the velocity: the mean over a pause of the
/// node says nothing of its end.
const SAID_OVER: u32 = 8;
/// A way back that was planned while the master's velocity was below this part of its present
/// maximum is planned again: one that had just begun to move was brought back over a micrometre in
/// 22 s.
const OUTGROWN: f64 = 0.5;
/// Largest slope of the curve of the way back, …
const STEEPEST: f64 = 1.875;
/// … and its largest curvature: 10/√3.
const MOST_CURVED: f64 = 5.774;
/// An axis that is brought back is accelerated as its master was at most, but never less than
/// braking it requires: the quartic begins with at most this multiple of its velocity over its
/// length.
const BRAKED: f64 = 1.5;

/// Part of the way back after which the axis is brought from the motion of its master to the shown values, which are beside it by a beat
/// or the lag of a filter. The difference of the velocities is mostly gone by then.
const TO_SHOWN: f64 = 0.5;
/// Time constant of following the positions of a master whose frames come in beats, s: a beat of a cycle of 1 ms is 2 % of its velocity.
const TRACKING: f64 = 0.05;

/// Keeps the set values of an axis continuous.
#[derive(Clone, Debug)]
pub struct Continuity {
    cycle_time: f64,
    /// Minimum time for bringing back, s.
    shortest: f64,
    /// The newest set values, and the difference of the velocity of their positions from theirs, u/s.
    last: Option<(Kinematics, f64)>,
    motion: Motion,
}

/// Knowledge of the master in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MasterCycle {
    /// Own cycles since the one before.
    pub elapsed: u32,
    /// Largest motion up to now, which bounds the acceleration and speed at which the axis is brought back.
    pub reach: Reach,
    /// True if positions come in beats, as in mode bypass. The velocity that comes with them is then that of the axis.
    pub shows_beats: bool,
    /// The newest frame, in a mode that shows values as received.
    pub newest: Option<ReceivedMotion>,
}

/// The set values of the newest frame, and their age.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceivedMotion {
    /// As received.
    pub set: Kinematics,
    /// Time since it was received, s.
    pub age: f64,
}

/// Largest motion that a master has shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reach {
    /// Greatest velocity up to now, u/s.
    pub velocity: f64,
    /// Greatest acceleration up to now, u/s².
    pub acceleration: f64,
}

/// State of the axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ContinuityState {
    /// The set values are those of the master.
    #[default]
    Following,
    /// Without a master: the axis is braked, or at rest.
    Braking,
    /// The axis is brought back to its master.
    Rejoining,
}

#[derive(Clone, Copy, Debug)]
enum Motion {
    Following,
    Braking {
        braking: Braking,
        since: f64,
    },
    /// The axis is to be brought to the next set values of the master.
    Returning,
    Rejoining(Rejoin),
}

impl Continuity {
    /// Creates it for an axis of a node with this cycle time. Bringing back takes `shortest` or longer.
    #[must_use]
    pub fn new(cycle_time: Span, shortest: Seconds) -> Self {
        Self {
            cycle_time: cycle_time.as_secs_f64(),
            shortest: shortest.0,
            last: None,
            motion: Motion::Following,
        }
    }

    /// Runs a cycle in which the master has set values; returns those of the axis.
    pub fn follow(&mut self, master: &Kinematics, cycle: &MasterCycle) -> Kinematics {
        let passed = self.passed(cycle);
        let reach = &cycle.reach;
        let set = match (&mut self.motion, &self.last) {
            // Without a previous position there is no step to avoid, so that an axis begins at its master.
            (Motion::Following, _) | (_, None) => {
                self.motion = Motion::Following;
                *master
            }
            // A plan stays in force while its master stays alike: planned again in each cycle it would never arrive.
            (Motion::Rejoining(rejoin), _) if rejoin.fastest >= OUTGROWN * reach.velocity => {
                rejoin.since += passed;
                rejoin.track(cycle.moved_on(), passed);
                rejoin.over(&rejoin.target(master))
            }
            (Motion::Braking { .. } | Motion::Returning | Motion::Rejoining(_), Some(_)) => {
                // The difference starts at the position at which the axis would be now, not where it was a cycle ago.
                let standing = self
                    .moving(reach)
                    .map_or(*master, |last| moved_on(&last, passed));
                let moved_on = cycle.moved_on();
                // Velocities beyond those of the master are of a jump, and the plan would begin with them.
                let master = reach.possible(&moved_on.unwrap_or(*master));
                let mut rejoin = self.rejoin_from(&standing, &master, reach);
                rejoin.master = moved_on;
                self.motion = Motion::Rejoining(rejoin);
                rejoin.over(&master)
            }
        };
        // Past its length the curve is the master itself, and from then on set values pass through to the bit.
        if let Motion::Rejoining(rejoin) = &self.motion
            && rejoin.since >= rejoin.length
        {
            self.motion = Motion::Following;
        }
        self.keep(set, cycle);
        set
    }

    /// Runs a cycle in which the master's position is unknown; none before it was ever known.
    pub fn brake(&mut self, cycle: &MasterCycle) -> Option<Kinematics> {
        let passed = self.passed(cycle);
        let last = self.moving(&cycle.reach)?;
        let (braking, since) = match self.motion {
            // A braking once begun keeps its curve, whose start is the last state with data.
            Motion::Braking { braking, since } => (braking, since + passed),
            Motion::Following | Motion::Returning | Motion::Rejoining(_) => {
                let length = BRAKING;
                // The braking begins at the last set values, which are one call ago: the first step has that length.
                (Braking { from: last, length }, passed)
            }
        };
        self.motion = Motion::Braking { braking, since };
        let set = braking.at(since);
        self.keep(set, cycle);
        Some(set)
    }

    /// The next set values of the master are unrelated to the previous ones: the axis is brought there.
    pub const fn rejoin(&mut self) {
        self.motion = Motion::Returning;
    }

    /// State of the axis.
    #[must_use]
    pub const fn state(&self) -> ContinuityState {
        match self.motion {
            Motion::Following => ContinuityState::Following,
            Motion::Braking { .. } => ContinuityState::Braking,
            Motion::Returning | Motion::Rejoining(_) => ContinuityState::Rejoining,
        }
    }

    /// Seconds since the cycle before.
    fn passed(&self, cycle: &MasterCycle) -> f64 {
        self.cycle_time * f64::from(cycle.elapsed)
    }

    fn keep(&mut self, set: Kinematics, cycle: &MasterCycle) {
        let passed = self.passed(cycle);
        // A pause's mean velocity and the jumps of beats would be mistaken for the velocity at its end.
        let says_velocity = (1..=SAID_OVER).contains(&cycle.elapsed) && !cycle.shows_beats;
        let beside = match &self.last {
            Some((last, _)) if says_velocity => {
                (set.position - last.position) / passed - set.velocity
            }
            _ => 0.0,
        };
        self.last = Some((set, beside));
    }

    /// The motion of the axis by its positions, within its limits.
    fn moving(&self, reach: &Reach) -> Option<Kinematics> {
        let (last, beside) = self.last?;
        // Positions win over the reported velocity: a drive follows positions.
        let is_true = beside.abs() <= CONTRADICTION * reach.velocity;
        let (velocity, acceleration) = match is_true {
            true => (last.velocity, last.acceleration),
            // An acceleration reported beside a wrong velocity deserves no more trust than it.
            false => (last.velocity + beside, 0.0),
        };
        Some(reach.possible(&Kinematics {
            velocity,
            acceleration,
            ..last
        }))
    }

    fn rejoin_from(&self, standing: &Kinematics, master: &Kinematics, reach: &Reach) -> Rejoin {
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
        let slowing = Braking {
            from: Kinematics {
                position: 0.0,
                ..ahead
            },
            length: (BRAKING * share).max(self.shortest),
        };
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
        Rejoin {
            slowing,
            way,
            length: for_way.max(slowing.length),
            since: 0.0,
            fastest,
            master: None,
        }
    }
}

impl MasterCycle {
    /// The motion of the master now, in a mode that shows values as received. Those stand until the next frame: an axis that is brought
    /// back relative to a standing position goes off with the difference of the velocities. Wide schedule 300893: at bursts of loss it ran
    /// away from a master of −500 u/s with up to +750, for a second.
    fn moved_on(&self) -> Option<Kinematics> {
        let ReceivedMotion { set, age } = self.newest?;
        // At its velocity alone: with its acceleration over a silence, one that moves to and fro by 5 u was taken to be 30 u away.
        Some(Kinematics {
            position: set.position + set.velocity * age,
            acceleration: 0.0,
            ..set
        })
    }
}

impl Reach {
    /// Set values with a velocity and an acceleration that the axis can have. A position that jumped says nothing of either: an axis
    /// that took the jump for its velocity went on at 100 m/s.
    fn possible(&self, set: &Kinematics) -> Kinematics {
        // An axis brought back may be half as fast again as its master.
        let (fastest, hardest) = ((1.0 + FASTER) * self.velocity, self.hardest());
        Kinematics {
            velocity: set.velocity.clamp(-fastest, fastest),
            acceleration: set.acceleration.clamp(-hardest, hardest),
            ..*set
        }
    }

    /// The greatest acceleration of an axis that is braked or brought back, u/s².
    fn hardest(&self) -> f64 {
        // Velocity of a braking from v over t: v·(1 - 3x² + 2x³), whose slope is largest at x = ½, 1.5·v/t.
        let by_braking = BRAKED * (1.0 + FASTER) * self.velocity / BRAKING;
        self.acceleration.max(by_braking)
    }
}

/// A difference that decreases to zero: that of the velocity soon, that of the position along the way.
#[derive(Clone, Copy, Debug)]
struct Rejoin {
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
    /// Follows the motion of the master in a mode that shows values as received, without its beats.
    fn track(&mut self, now: Option<Kinematics>, passed: f64) {
        self.master = match (self.master, now) {
            (Some(before), Some(now)) => {
                let on = before.position + now.velocity * passed;
                let share = (passed / TRACKING).min(1.0);
                let position = on + share * (now.position - on);
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
    fn over(&self, master: &Kinematics) -> Kinematics {
        // The sum below leaves a rounding residue, and the end is the master exactly.
        if self.since >= self.length {
            return *master;
        }
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

/// A motion that comes to rest: the quartic whose velocity and acceleration reach zero together.
#[derive(Clone, Copy, Debug)]
struct Braking {
    from: Kinematics,
    /// s, above 0.
    length: f64,
}

impl Braking {
    /// State this number of seconds after it began.
    fn at(&self, since: f64) -> Kinematics {
        let x = since / self.length;
        if x >= 1.0 {
            return Kinematics::at_rest(self.from.position + self.way());
        }
        let (v, a) = self.scaled();
        // Conditions at x = 1: v + 2c₂ + 3c₃ + 4c₄ = 0 and 2c₂ + 6c₃ + 12c₄ = 0, with c₂ = a/2.
        let (c2, c3, c4) = (0.5 * a, -v - 2.0 / 3.0 * a, 0.5 * v + 0.25 * a);
        let velocity = v + x * (2.0 * c2 + x * (3.0 * c3 + x * 4.0 * c4));
        let acceleration = 2.0 * c2 + x * (6.0 * c3 + x * 12.0 * c4);
        Kinematics {
            position: self.from.position + x * (v + x * (c2 + x * (c3 + x * c4))),
            velocity: velocity / self.length,
            acceleration: acceleration / (self.length * self.length),
        }
    }

    /// Distance to rest, u.
    fn way(&self) -> f64 {
        let (v, a) = self.scaled();
        // The quartic at x = 1: v + c₂ + c₃ + c₄.
        0.5 * v + a / 12.0
    }

    /// Initial velocity and acceleration, as ways.
    fn scaled(&self) -> (f64, f64) {
        let Kinematics {
            velocity,
            acceleration,
            ..
        } = self.from;
        (
            velocity * self.length,
            acceleration * self.length * self.length,
        )
    }
}

#[cfg(test)]
mod tests;
