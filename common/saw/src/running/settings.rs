//! What a coupling is started with, and how it may fail.

use crate::command::{GearInPos, GearInVelo, SyncLimits};
use crate::moment::{CouplingMoment, SlaveLimits};
use crate::plan::SawPlan;
use crate::refusal::{SawRefusal, Violation};
use crate::remedy::SawRemedy;
use crate::sync_mode::SyncMask;
use coaxle_clock::Seconds;
use coaxle_curve::profile::Limits;

use super::keeping_velocity;

/// What a [`SawCoupling`](super::SawCoupling) is started with.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum SawCommand {
    /// `MC_GearInPos`.
    GearInPos(GearInPos),
    /// `MC_GearInVelo`.
    GearInVelo(GearInVelo),
}

impl SawCommand {
    /// A dry run: see [`GearInPos::plan`] and [`GearInVelo::plan`].
    ///
    /// # Errors
    /// [`SawRefusal`].
    pub fn plan(&self, moment: &CouplingMoment) -> Result<SawPlan, SawRefusal> {
        match self {
            Self::GearInPos(command) => command.plan(moment),
            Self::GearInVelo(command) => command.plan(moment),
        }
    }

    /// What would make a refused command pass; nothing where nothing is looked for. It plans some
    /// hundred times: not for the cycle.
    #[must_use]
    pub fn remedy(&self, moment: &CouplingMoment) -> SawRemedy {
        match self {
            _ if !self.looks_for_a_remedy() => SawRemedy::default(),
            Self::GearInPos(command) => command.remedy(moment),
            Self::GearInVelo(command) => command.remedy(moment),
        }
    }

    /// Whether a remedy is looked for: not where the slave would wait for a start distance, as
    /// distance and speed of the master then belong to a later moment, and not for a position that
    /// is no number.
    #[must_use]
    pub const fn looks_for_a_remedy(&self) -> bool {
        match self {
            Self::GearInPos(command) => {
                command.master_start_distance.is_none() && command.master_sync_position.is_finite()
            }
            Self::GearInVelo(_) => true,
        }
    }

    pub(super) const fn mask(&self) -> SyncMask {
        match self {
            Self::GearInPos(command) => command.sync_mode.mask,
            Self::GearInVelo(command) => command.sync_mode.mask,
        }
    }

    pub(super) const fn limits(&self) -> &SyncLimits {
        match self {
            Self::GearInPos(command) => &command.limits,
            Self::GearInVelo(command) => &command.limits,
        }
    }
}

/// How much a coupling in motion lets pass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct SawTolerances {
    /// How far behind the coupling position the master may be before that counts as running back,
    /// u. Noise of its position is not a reversal.
    pub master_noise: f64,
    /// By which part the slave may exceed its axis's highest velocity while coupled: a profile at
    /// the limit shall survive a master whose velocity ripples.
    pub velocity_margin: f64,
}

impl Default for SawTolerances {
    fn default() -> Self {
        Self {
            master_noise: 1e-3,
            velocity_margin: 0.01,
        }
    }
}

/// Why a coupling failed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SawFault {
    /// It could not be planned.
    #[error(transparent)]
    Refused(SawRefusal),
    /// The master led the slave beyond a limit.
    #[error("while coupled: {}", SawRefusal::Violation(*.0))]
    Limit(Violation),
    /// The master's values are not numbers.
    #[error("0x4b06: master values that are not finite")]
    MasterNotFinite,
}

impl SawFault {
    /// The NC error code.
    #[must_use]
    pub const fn code(&self) -> u32 {
        match self {
            Self::Refused(refusal) => refusal.code(),
            Self::Limit(violation) => violation.code(),
            Self::MasterNotFinite => 0x4b06,
        }
    }
}

/// The coupling moment as it is to be expected if the master is still farther away than its start
/// distance.
pub(super) fn prephase(
    command: &SawCommand,
    moment: &CouplingMoment,
) -> Result<Option<CouplingMoment>, SawRefusal> {
    let SawCommand::GearInPos(command) = command else {
        return Ok(None);
    };
    let Some(start_distance) = command.master_start_distance else {
        return Ok(None);
    };
    if !(start_distance.is_finite() && start_distance > 0.0) {
        return Err(SawRefusal::StartDistance {
            received: start_distance,
        });
    }
    let distance = command.master_sync_position - moment.master.position;
    let early = distance - start_distance.copysign(distance);
    if early * distance <= 0.0 || early * moment.master.velocity < 0.0 {
        return Ok(None);
    }
    let mut expected = *moment;
    expected.master.position += early;
    if moment.master.velocity != 0.0 {
        let wait = Seconds(early / moment.master.velocity);
        expected.slave = keeping_velocity(&moment.slave, &moment.axis).at(wait);
    }
    Ok(Some(expected))
}

/// The limits of a synchronisation.
pub(super) fn limits(
    command: &SawCommand,
    axis: &SlaveLimits,
    tolerances: &SawTolerances,
) -> Result<Limits, SawRefusal> {
    let (given, own) = (command.limits(), &axis.dynamics);
    Ok(Limits::new(
        own.velocity() * (1.0 + tolerances.velocity_margin),
        axis.in_force(given.acceleration, own.acceleration(), 0.0),
        axis.in_force(given.deceleration, own.deceleration(), 0.0),
        axis.jerk_in_force(given.jerk),
    )?)
}
