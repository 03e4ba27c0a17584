//! What moves a slave axis: a profile of its own, or a coupling.

use coaxle_clock::Seconds;

use coaxle_curve::profile::{Kinematics, Profile, to_velocity};

use super::coupling::Coupling;
use super::rolling_back::RollingBack;
use coaxle_axis::CouplingPhase;
use coaxle_axis::guard::Guard;
use coaxle_cam::Cams;

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
    pub(super) fn rest(position: f64, guard: &Guard) -> Self {
        Self::new(guard.brake(&Kinematics::at_rest(position)))
    }

    /// Keeping a velocity.
    pub(super) fn keep_velocity(from: &Kinematics, guard: &Guard) -> Self {
        let free = Kinematics {
            acceleration: 0.0,
            ..*from
        };
        Self::new(to_velocity(&free, free.velocity, guard.limits()))
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
