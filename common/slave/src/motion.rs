//! Motions of a slave axis: a profile of its own, or a coupling.

use coaxle_clock::Seconds;

use coaxle_curve::profile::{Kinematics, Profile, ProfileExtremes, to_velocity};

use super::couplings::Kind;
use coaxle_axis::guard::Guard;

/// Current motion of a slave axis.
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "it lives in place: nothing is allocated on the cycle path"
)]
pub(super) enum Motion {
    /// A profile of its own.
    Own(Planned),
    /// Coupling of this kind to its masters.
    Coupled(Kind),
}

/// A profile under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planned {
    profile: Profile,
    since: Seconds,
    /// State from which it was planned, before its first cycle: the start state without a coupling,
    /// from the stated set values.
    taken_over: Option<Kinematics>,
}

impl Planned {
    pub(super) const fn new(profile: Profile) -> Self {
        Self {
            profile,
            since: Seconds::ZERO,
            taken_over: None,
        }
    }

    /// Sets the state at which it begins.
    pub(super) const fn from(self, start: Kinematics) -> Self {
        Self {
            taken_over: Some(start),
            ..self
        }
    }

    /// State at which it begins; none after its first cycle.
    pub(super) const fn taken_over(&self) -> Option<Kinematics> {
        self.taken_over
    }

    /// Standing at a position.
    pub(super) fn rest(position: f64, guard: &Guard) -> Self {
        // A brake from rest takes no time.
        Self::new(guard.brake(&Kinematics::at_rest(position)))
    }

    /// Keeping a velocity: an acceleration is led to zero within the jerk, and the velocity change
    /// meanwhile is compensated.
    pub(super) fn keep_velocity(from: &Kinematics, guard: &Guard) -> Self {
        // To the velocity of now, and not to the one at which the acceleration would end.
        Self::new(to_velocity(from, from.velocity, guard.limits())).from(*from)
    }

    pub(super) fn advance(&mut self, elapsed: Seconds) -> Kinematics {
        // From the first cycle on the set values are the state of the motion.
        self.taken_over = None;
        self.since = self.since + elapsed;
        self.profile.at(self.since)
    }

    pub(super) fn is_over(&self) -> bool {
        self.since >= self.profile.duration()
    }

    /// Remaining duration, s.
    pub(super) fn left(&self) -> f64 {
        // A motion that is over goes on being advanced.
        (self.profile.duration().0 - self.since.0).max(0.0)
    }

    /// Extremes of the whole profile.
    pub(super) fn extremes(&self) -> ProfileExtremes {
        ProfileExtremes::of(&self.profile)
    }

    /// The largest acceleration or deceleration from now on. It changes linearly within a phase.
    pub(super) fn largest_acceleration_left(&self) -> f64 {
        let begins = self.profile.phase_begins();
        let later = begins.filter(|begin| *begin >= self.since);
        // The phase under way began earlier, so it is evaluated from now on.
        core::iter::once(self.since)
            .chain(later)
            .map(|time| self.profile.at(time).acceleration.abs())
            .fold(0.0, f64::max)
    }

    /// The largest jerk from now on. It is constant within a phase.
    pub(super) fn largest_jerk_left(&self) -> f64 {
        let begins = self.profile.phase_begins();
        let later = begins.filter(|begin| *begin >= self.since);
        core::iter::once(self.since)
            .chain(later)
            .map(|time| self.profile.jerk_at(time).abs())
            .fold(0.0, f64::max)
    }

    /// End state, or the state at which it becomes a constant velocity.
    pub(super) const fn end(&self) -> Kinematics {
        self.profile.end()
    }
}
