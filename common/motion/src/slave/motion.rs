//! What moves a slave axis: a profile of its own, or a coupling.

use coaxle_clock::Seconds;

use crate::profile::{Kinematics, Profile, to_velocity};
use crate::saw::RollbackStop;

use super::bounds::Bounds;
use super::cams::Cams;
use super::coupling::{Coupling, CouplingPhase};

/// What moves a slave axis.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "it lives in place: nothing is allocated on the cycle path"
)]
pub(super) enum Motion {
    /// A profile of its own.
    Planned(Planned),
    /// The master.
    Coupled(Coupling),
    /// The stop after the master of a flying saw has run back.
    RollingBack(RollingBack),
}

impl Motion {
    /// How far the coupling is; none without one.
    pub(super) fn coupling_phase(&self, cams: &Cams) -> Option<CouplingPhase> {
        match self {
            Self::Planned(_) | Self::RollingBack(_) => None,
            Self::Coupled(coupling) => coupling.phase(cams),
        }
    }
}

/// A profile under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planned {
    profile: Profile,
    since: Seconds,
}

impl Planned {
    pub(super) const fn new(profile: Profile) -> Self {
        Self {
            profile,
            since: Seconds::ZERO,
        }
    }

    /// Standing somewhere.
    pub(super) fn rest(position: f64, bounds: &Bounds) -> Self {
        Self::new(bounds.brake(&Kinematics::at_rest(position)))
    }

    /// Keeping a velocity.
    pub(super) fn keep_velocity(from: &Kinematics, bounds: &Bounds) -> Self {
        let free = Kinematics {
            acceleration: 0.0,
            ..*from
        };
        Self::new(to_velocity(&free, free.velocity, bounds.limits()))
    }

    pub(super) fn advance(&mut self, elapsed: Seconds) -> Kinematics {
        self.since = self.since + elapsed;
        self.profile.at(self.since)
    }

    pub(super) fn is_over(&self) -> bool {
        self.since >= self.profile.duration()
    }

    /// Where it ends, or where it passes into a constant velocity.
    pub(super) const fn end(&self) -> Kinematics {
        self.profile.end()
    }
}

/// The stop after a rollback, under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct RollingBack {
    stop: RollbackStop,
    since: Seconds,
}

impl RollingBack {
    /// `since` that long ago the master passed the coupling position.
    pub(super) const fn new(stop: RollbackStop, since: Seconds) -> Self {
        Self { stop, since }
    }

    pub(super) fn advance(&mut self, elapsed: Seconds) -> Kinematics {
        self.since = self.since + elapsed;
        self.stop.at(self.since)
    }

    pub(super) fn is_over(&self) -> bool {
        self.since >= self.stop.duration()
    }

    /// Where it ends, u.
    pub(super) fn end(&self) -> f64 {
        self.stop.end_position()
    }
}

/// How far and how fast a profile goes until it is at its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extremes {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) speed: f64,
}

impl Extremes {
    /// Exact: within a phase of constant jerk they lie at its ends or where the velocity, or the
    /// acceleration, passes through zero.
    pub(super) fn of(profile: &Profile) -> Self {
        let end = profile.end();
        let mut extremes = Self {
            low: end.position,
            high: end.position,
            speed: end.velocity.abs(),
        };
        for begin in profile.phase_begins() {
            let from = profile.at(begin);
            let jerk = profile.jerk_at(begin);
            extremes.take(&from);
            for turn in turning_times(&from, jerk) {
                // Beyond the phase this looks at a state of the next one, which does no harm.
                if turn > 0.0 && turn <= profile.duration().0 - begin.0 {
                    extremes.take(&profile.at(begin + Seconds(turn)));
                }
            }
        }
        extremes
    }

    fn take(&mut self, state: &Kinematics) {
        self.low = self.low.min(state.position);
        self.high = self.high.max(state.position);
        self.speed = self.speed.max(state.velocity.abs());
    }
}

/// When the velocity, and when the acceleration passes through zero under a constant jerk, in
/// seconds from now; not a number where it does not.
fn turning_times(from: &Kinematics, jerk: f64) -> [f64; 3] {
    let (v, a) = (from.velocity, from.acceleration);
    // v + a·t + jerk/2·t² = 0 in the form that does not cancel.
    let q = -(a + libm::sqrt(a * a - 2.0 * jerk * v).copysign(a));
    [q / jerk, 2.0 * v / q, -a / jerk]
}
