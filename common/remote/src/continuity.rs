//! Set values without steps in every state of the node that they come from.
//!
//! The blocks of TS5066 freeze an axis without data, and jump to its position when the data are
//! back. Here it is braked instead, and brought back along a curve: positions, velocities and
//! accelerations are continuous. In normal operation set values pass through unchanged, to the bit.
//! Not in the manual.

mod braking;
mod reach;
mod rejoin;

use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::Kinematics;

pub use self::reach::Reach;

use self::braking::{BRAKING, Braking};
use self::rejoin::{Rejoin, TRACKING, tracked};
use super::prediction::moved_on;

/// Set values whose positions and velocity differ by more than this part of the greatest velocity
/// up to then are evaluated by their positions: those of a mode that shows every beat, or that
/// stand still without new data.
const CONTRADICTION: f64 = 0.05;
/// Positions at most this number of cycles apart give the velocity: the mean over a pause of the
/// node says nothing of its end.
const SAID_OVER: u32 = 8;
/// Change of the velocity from one cycle to the next that is no step, as a part of the greatest one: a clock that is 0.1 µs off shows as much
/// in a cycle of 1 ms.
const NO_STEP: f64 = 1e-4;

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
    /// The axis is to be brought to the next set values of the master; with the way back that it was on, if any.
    Returning(Option<Rejoin>),
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
        if let Motion::Returning(Some(way)) = self.motion
            && self.goes_on(way, master, cycle)
        {
            self.motion = Motion::Rejoining(way);
        }
        let set = match (&mut self.motion, &self.last) {
            // Without a previous position there is no step to avoid, so that an axis begins at its master.
            (Motion::Following, _) | (_, None) => {
                self.motion = Motion::Following;
                *master
            }
            // A plan stays in force while its master stays alike: planned again in each cycle it would never arrive.
            (Motion::Rejoining(rejoin), _) if rejoin.holds(master, reach) => {
                rejoin.go_on(cycle.moved_on(), passed);
                rejoin.over(master)
            }
            (Motion::Braking { .. } | Motion::Returning(_) | Motion::Rejoining(_), Some(_)) => {
                // The difference starts at the position at which the axis would be now, not where it was a cycle ago.
                let standing = self.standing(cycle).unwrap_or(*master);
                let moved_on = cycle.moved_on();
                // Velocities beyond those of the master are of a jump, and the plan would begin with them.
                let master = reach.possible(&moved_on.unwrap_or(*master));
                let rejoin = Rejoin::plan(&standing, &master, reach, self.shortest);
                self.motion = Motion::Rejoining(rejoin.beside(moved_on));
                rejoin.over(&master)
            }
        };
        // Past its length the curve is the master itself, and from then on set values pass through to the bit.
        if let Motion::Rejoining(rejoin) = &self.motion
            && rejoin.is_over()
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
            Motion::Following | Motion::Returning(_) | Motion::Rejoining(_) => {
                let braking = Braking::new(last, BRAKING, cycle.reach.gained());
                // The braking begins at the last set values, which are one call ago: the first step has that length.
                (braking, passed)
            }
        };
        self.motion = Motion::Braking { braking, since };
        let set = braking.at(since);
        self.keep(set, cycle);
        Some(set)
    }

    /// The next set values of the master are unrelated to the previous ones: the axis is brought there.
    pub const fn rejoin(&mut self) {
        let way = match self.motion {
            Motion::Rejoining(way) => Some(way),
            Motion::Returning(way) => way,
            Motion::Following | Motion::Braking { .. } => None,
        };
        self.motion = Motion::Returning(way);
    }

    /// State of the axis.
    #[must_use]
    pub const fn state(&self) -> ContinuityState {
        match self.motion {
            Motion::Following => ContinuityState::Following,
            Motion::Braking { .. } => ContinuityState::Braking,
            Motion::Returning(_) | Motion::Rejoining(_) => ContinuityState::Rejoining,
        }
    }

    /// True if the axis goes on without a step on the way back that it was on. In swarm schedule 4937 a way of 700 u to a master at rest
    /// began from its start whenever the clock was found again.
    fn goes_on(&self, mut way: Rejoin, master: &Kinematics, cycle: &MasterCycle) -> bool {
        let (passed, reach) = (self.passed(cycle), &cycle.reach);
        let Some(standing) = self.standing(cycle) else {
            return false;
        };
        let moved_on = cycle.moved_on();
        let reach = self.reach(reach);
        let beat = way.beat(moved_on.as_ref(), passed).abs();
        // What a beat moves the axis by is no step, as long as its stated velocity counts. In swarm schedule 50274 a master 1000 u ahead
        // came in beats, each of which began the way back from its start.
        let is_usual = beat <= CONTRADICTION * TRACKING * reach.velocity;
        let tracked = if is_usual { tracked(beat, passed) } else { 0.0 };
        way.go_on(moved_on, passed);
        let on = way.over(master);
        let step = NO_STEP * reach.velocity;
        (on.position - standing.position).abs() <= step * passed + tracked
            && (on.velocity - standing.velocity).abs() <= step
    }

    /// The motion of the axis in this cycle, if it went on from the one before.
    fn standing(&self, cycle: &MasterCycle) -> Option<Kinematics> {
        let last = self.moving(&cycle.reach)?;
        Some(moved_on(&last, self.passed(cycle)))
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

    /// Reach of the axis: that of its master or, if that has never moved, of the curve that the axis is on.
    fn reach(&self, master: &Reach) -> Reach {
        master.or_own(match &self.motion {
            Motion::Following | Motion::Returning(None) => 0.0,
            Motion::Braking { braking, .. } => braking.own_velocity(),
            Motion::Returning(Some(way)) | Motion::Rejoining(way) => way.own_velocity(),
        })
    }

    /// The motion of the axis by its positions, within its limits.
    fn moving(&self, reach: &Reach) -> Option<Kinematics> {
        let (last, beside) = self.last?;
        let reach = self.reach(reach);
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

#[cfg(test)]
mod tests;
