//! The inputs of the two blocks.

use super::{SyncMode, SyncStrategy};

/// `MC_GearInPos`: the slave runs at the gear's velocity from a given pair of positions on, at the
/// latest. TS5055 12.1.2, TF5055 4.2.
///
/// Omitted limits default to those of the axis; they are only checked if `sync_mode` says so. An axis
/// with a [`LimitGuard`](super::LimitGuard) keeps its own in any case, and refuses a profile that does
/// not. The bounds of a synchronisation with two ramps use acceleration and deceleration in any case, and
/// with a strategy the limits shape the profile and are kept in any case.
///
/// Positions are numbers when it is planned; `P` is for other ways to state them.
#[doc(alias = "MC_GearInPos")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(rename = "GearInPosAt{P}")
)]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct GearInPos<P = f64> {
    /// The gear.
    pub ratio: Ratio,
    /// Position of the master at which the slave is synchronous at the latest, u.
    #[doc(alias = "MasterSyncPosition")]
    pub master_sync_position: P,
    /// Position of the slave then, u.
    #[doc(alias = "SlaveSyncPosition")]
    pub slave_sync_position: P,
    /// Distance of the master before its synchronisation position at which the synchronisation begins, u;
    /// until then the slave keeps its velocity. At once if omitted. The original does not implement it.
    #[doc(alias = "MasterStartDistance")]
    #[cfg_attr(feature = "serde", serde(default))]
    pub master_start_distance: Option<f64>,
    /// Timing and dynamics of the synchronisation, within the slave's limits. If omitted, the profiles of
    /// TS5055 7 over the whole distance.
    #[doc(alias = "SyncStrategy")]
    #[cfg_attr(feature = "serde", serde(default))]
    pub strategy: Option<SyncStrategy>,
    /// Checks and modes of operation. Position-based only.
    #[cfg_attr(feature = "serde", serde(default))]
    pub sync_mode: SyncMode,
    /// Limits of the synchronisation.
    #[cfg_attr(feature = "serde", serde(default))]
    pub limits: SyncLimits,
}

impl<P: Copy> GearInPos<P> {
    /// Returns the positions of master and slave.
    #[must_use]
    pub const fn positions(&self) -> (P, P) {
        (self.master_sync_position, self.slave_sync_position)
    }

    /// Returns the command with these positions of master and slave.
    #[must_use]
    pub const fn at<Q: Copy>(&self, master: Q, slave: Q) -> GearInPos<Q> {
        GearInPos {
            ratio: self.ratio,
            master_sync_position: master,
            slave_sync_position: slave,
            master_start_distance: self.master_start_distance,
            strategy: self.strategy,
            sync_mode: self.sync_mode,
            limits: self.limits,
        }
    }
}

/// `MC_GearInVelo`: the slave reaches the gear's velocity as soon as it can. TS5055 12.1.1, TF5055 4.1.
///
/// Omitted limits default to those of the axis. Acceleration, deceleration and jerk shape the profile and
/// hence are kept whether `sync_mode` checks them or not.
#[doc(alias = "MC_GearInVelo")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct GearInVelo {
    /// The gear.
    pub ratio: Ratio,
    /// Position- or time-based, checks and modes of operation.
    #[cfg_attr(feature = "serde", serde(default))]
    pub sync_mode: SyncMode,
    /// Limits of the synchronisation.
    #[cfg_attr(feature = "serde", serde(default))]
    pub limits: SyncLimits,
}

/// The gear ratio: slave units per master unit, as a fraction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct Ratio {
    /// Numerator, other than 0 and of either sign; with denominator 1 the ratio itself.
    #[doc(alias = "RatioNumerator")]
    pub numerator: f64,
    /// Denominator, other than 0; 1 unless given.
    #[doc(alias = "RatioDenominator")]
    #[cfg_attr(feature = "serde", serde(default = "one"))]
    pub denominator: u16,
}

#[cfg(feature = "serde")]
const fn one() -> u16 {
    1
}

impl Ratio {
    /// Returns the ratio as one number.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.numerator / f64::from(self.denominator)
    }

    /// Makes a ratio of one number.
    #[must_use]
    pub const fn of(ratio: f64) -> Self {
        Self {
            numerator: ratio,
            denominator: 1,
        }
    }
}

/// Limits of the slave during a synchronisation. Omitted ones default to the axis's own limit; positions
/// are unlimited by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct SyncLimits {
    /// Greatest speed, u/s.
    #[doc(alias = "Velocity")]
    pub velocity: Option<f64>,
    /// Greatest acceleration, u/s².
    #[doc(alias = "Acceleration")]
    pub acceleration: Option<f64>,
    /// Greatest deceleration, u/s².
    #[doc(alias = "Deceleration")]
    pub deceleration: Option<f64>,
    /// Greatest jerk, u/s³.
    #[doc(alias = "Jerk")]
    pub jerk: Option<f64>,
    /// Lowest position, u: `ST_GearInPosOptions`, `ST_GearInVeloOptions` (TF5055 5.4, 5.5).
    #[doc(alias = "PositionLimitMin")]
    #[doc(alias = "ST_GearInPosOptions")]
    #[doc(alias = "ST_GearInVeloOptions")]
    pub min_position: Option<f64>,
    /// Highest position, u.
    #[doc(alias = "PositionLimitMax")]
    pub max_position: Option<f64>,
    /// Expected velocity of the master, u/s of the master, above 0, if master and slave stand still at
    /// the plan: everything is checked at that velocity then, and not at 0. Without a strategy.
    pub master_velocity: Option<f64>,
}
