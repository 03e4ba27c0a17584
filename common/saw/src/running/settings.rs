//! Settings and faults of a coupling.

use crate::command::{GearInPos, GearInVelo, SyncLimits};
use crate::coupling_moment::{CouplingMoment, SlaveLimits};
use crate::path_limits::PathLimits;
use crate::plan::SawPlan;
use crate::refusal::{SawRefusal, Violation};
use crate::strategy::SyncStrategy;
use crate::sync_mode::SyncMask;
use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits};

use super::pursuit::PositionRange;
use super::{keeping_velocity, sign};

/// Command that starts a [`SawCoupling`](super::SawCoupling).
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
    /// Plans a dry run: see [`GearInPos::plan`] and [`GearInVelo::plan`].
    ///
    /// # Errors
    /// [`SawRefusal`].
    pub fn plan(&self, moment: &CouplingMoment) -> Result<SawPlan, SawRefusal> {
        match self {
            Self::GearInPos(command) => command.plan(moment),
            Self::GearInVelo(command) => command.plan(moment),
        }
    }

    /// Returns the direction of its master to the synchronisation position: 1 or −1, 0 if it does not
    /// matter.
    pub(super) fn direction(&self, moment: &CouplingMoment) -> f64 {
        let Self::GearInPos(command) = self else {
            return 0.0;
        };
        let CouplingMoment { master, .. } = moment;
        match command.strategy {
            None => 0.0,
            // An early slave may be in sync behind its positions, so the motion of the master counts.
            Some(SyncStrategy::Early) if master.velocity != 0.0 => master.velocity.signum(),
            Some(_) => sign(command.master_sync_position - master.position),
        }
    }

    /// Returns the synchronisation position of its master, if it has a strategy, u.
    pub(super) fn strategic_sync_position(&self) -> Option<f64> {
        match self {
            Self::GearInPos(command) => {
                let position = command.master_sync_position;
                command.strategy.map(|_| position)
            }
            Self::GearInVelo(_) => None,
        }
    }

    /// Returns the pair of positions that the line of an early synchronisation goes through.
    pub(super) fn early_positions(&self) -> Option<(f64, f64)> {
        match self {
            Self::GearInPos(command) if command.strategy == Some(SyncStrategy::Early) => {
                Some((command.master_sync_position, command.slave_sync_position))
            }
            _ => None,
        }
    }

    /// Returns the limits of the slave on its path onto a line.
    pub(super) fn chase(&self, axis: &SlaveLimits, slave: &Kinematics) -> PathLimits {
        let (given, own) = (self.limits(), &axis.dynamics);
        let limits = Limits::new(
            axis.in_force(given.velocity, own.velocity(), slave.velocity),
            axis.in_force(given.acceleration, own.acceleration(), slave.acceleration),
            axis.in_force(given.deceleration, own.deceleration(), slave.acceleration),
            axis.jerk_in_force(given.jerk),
        );
        PathLimits {
            limits: limits.unwrap_or(*own),
            fastest_line: given.velocity.unwrap_or(own.velocity()).min(own.velocity()),
            mask: self.mask(),
        }
    }

    /// Returns the range of positions of the slave on its path, from `start`, u: the requested checks of
    /// position, and the axis's own limits in any case.
    pub(super) fn range(&self, axis: &SlaveLimits, start: f64) -> PositionRange {
        let (mask, given) = (self.mask(), self.limits());
        let asked = |flag: SyncMask, limit: Option<f64>| limit.filter(|_| mask.contains(flag));
        let kept = |flag: SyncMask, limit: Option<f64>| {
            limit.filter(|_| mask.contains(flag) || axis.guard.is_some())
        };
        // The narrower of both; without any, the folds leave infinity.
        let low = kept(SyncMask::MIN_POS, axis.min_position)
            .into_iter()
            .chain(asked(SyncMask::OPTIONAL_MIN_POS, given.min_position));
        let high = kept(SyncMask::MAX_POS, axis.max_position)
            .into_iter()
            .chain(asked(SyncMask::OPTIONAL_MAX_POS, given.max_position));
        PositionRange {
            low: low.fold(f64::NEG_INFINITY, f64::max),
            high: high.fold(f64::INFINITY, f64::min),
            start,
            no_undershoot: mask.contains(SyncMask::UNDERSHOOT_POS),
            no_overshoot: mask.contains(SyncMask::OVERSHOOT_POS),
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

/// Tolerances of a coupling in motion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct SawTolerances {
    /// Tolerance of the master behind the coupling position before it counts as running back, u. Noise of
    /// its position is not a reversal.
    pub master_noise: f64,
    /// Part by which the slave may exceed its axis's greatest velocity while coupled, so that a profile
    /// at the limit survives a master whose velocity ripples.
    pub velocity_margin: f64,
}

impl Default for SawTolerances {
    fn default() -> Self {
        Self {
            // A micrometre on an axis in mm.
            master_noise: 1e-3,
            velocity_margin: 0.01,
        }
    }
}

/// Fault of a coupling.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SawFault {
    /// Refused plan.
    #[error(transparent)]
    Refused(SawRefusal),
    /// Limit violated by following the master.
    #[error("while coupled: {}", SawRefusal::Violation(*.0))]
    Limit(Violation),
    /// Master values that are not finite.
    #[error("0x4b06: master values that are not finite")]
    MasterNotFinite,
}

impl SawFault {
    /// Returns the NC error code.
    #[must_use]
    pub const fn code(&self) -> u32 {
        match self {
            Self::Refused(refusal) => refusal.code(),
            Self::Limit(violation) => violation.code(),
            Self::MasterNotFinite => 0x4b06,
        }
    }
}

/// Predicts the coupling moment, if it is later: the master is still farther away than its start
/// distance, or the slave is synchronised as late as possible.
pub(super) fn prephase(
    command: &SawCommand,
    moment: &CouplingMoment,
) -> Result<Option<CouplingMoment>, SawRefusal> {
    let expected = before_start_distance(command, moment)?;
    let SawCommand::GearInPos(gear_in_pos) = command else {
        return Ok(expected);
    };
    if gear_in_pos.strategy != Some(SyncStrategy::Late) {
        return Ok(expected);
    }
    let from = expected.unwrap_or(*moment);
    let latest = gear_in_pos.latest(&from)?;
    // Nothing to wait for, so that the plan is made for the moment itself.
    Ok(if latest == from {
        expected
    } else {
        Some(latest)
    })
}

/// True if a coupling would start from a moment, at once or after a wait.
pub(crate) fn starts(command: &SawCommand, moment: &CouplingMoment) -> bool {
    prephase(command, moment)
        .and_then(|expected| command.plan(expected.as_ref().unwrap_or(moment)))
        .is_ok()
}

/// True if the slave keeps its motion for one more cycle. `direction` is that of the master at the plan.
pub(super) fn waits(
    command: &SawCommand,
    moment: &CouplingMoment,
    direction: f64,
    dt: f64,
) -> Result<bool, SawRefusal> {
    if before_start_distance(command, moment)?.is_some() {
        return Ok(true);
    }
    let SawCommand::GearInPos(command) = command else {
        return Ok(false);
    };
    let CouplingMoment { master, .. } = moment;
    let ahead = (command.master_sync_position - master.position) * direction;
    match command.strategy {
        // The master stands, or moves away: there is time.
        Some(SyncStrategy::Late) if ahead > 0.0 && master.velocity * direction <= 0.0 => Ok(true),
        // Asked for one cycle ahead: in the cycle after the last moment it would be too late.
        Some(SyncStrategy::Late) => command.can_wait(moment, Seconds(dt)),
        _ => Ok(false),
    }
}

/// Predicts the coupling moment if the master is still farther away than its start distance.
fn before_start_distance(
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
    // The distance that the master still has to go before the wait ends.
    let early = distance - start_distance.copysign(distance);
    // Within the start distance already, or running away from it: the plan decides.
    if early * distance <= 0.0 || early * moment.master.velocity < 0.0 {
        return Ok(None);
    }
    let mut expected = *moment;
    expected.master.position += early;
    // A standing master never arrives; its slave is planned from where it is now.
    if moment.master.velocity != 0.0 {
        let wait = Seconds(early / moment.master.velocity);
        expected.slave = keeping_velocity(&moment.slave, &moment.axis).at(wait);
    }
    Ok(Some(expected))
}

/// Returns the limits of a synchronisation.
pub(super) fn limits(
    command: &SawCommand,
    axis: &SlaveLimits,
    tolerances: &SawTolerances,
) -> Result<Limits, SawRefusal> {
    let (given, own) = (command.limits(), &axis.dynamics);
    Ok(Limits::new(
        // The monitored velocity, not the planned one: a ripple of the master may exceed the plan.
        own.velocity() * (1.0 + tolerances.velocity_margin),
        // No present motion: these limits hold for a stop at any later time.
        axis.in_force(given.acceleration, own.acceleration(), 0.0),
        axis.in_force(given.deceleration, own.deceleration(), 0.0),
        axis.jerk_in_force(given.jerk),
    )?)
}
