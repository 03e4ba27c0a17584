//! The inputs of the two blocks.

use super::{SyncMode, SyncStrategy};

/// `MC_GearInPos`: the slave runs at the gear's velocity from a given pair of positions on, at the
/// latest. TS5055 12.1.2, TF5055 4.2.
///
/// Limits that are not given are the axis's own; they bind only where `sync_mode` checks them. An axis
/// with a [`LimitGuard`](super::LimitGuard) keeps its own in any case, and refuses what does not. The
/// bounds of a synchronisation with two ramps use acceleration and deceleration in any case, and with a
/// strategy the limits shape the profile and are kept in any case.
///
/// Positions are numbers wherever it is planned; whoever says them in another way has a `P` for that.
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
    /// Where the master is when the slave is synchronous at the latest, u.
    #[doc(alias = "MasterSyncPosition")]
    pub master_sync_position: P,
    /// Where the slave is then, u.
    #[doc(alias = "SlaveSyncPosition")]
    pub slave_sync_position: P,
    /// How far before its synchronisation position the master is when the synchronisation begins,
    /// u; until then the slave keeps its velocity. At once if not given. The original does not
    /// implement it.
    #[doc(alias = "MasterStartDistance")]
    #[cfg_attr(feature = "serde", serde(default))]
    pub master_start_distance: Option<f64>,
    /// When and how hard the slave is synchronised, within its limits. If not given, by the profiles of
    /// TS5055 7 over the whole way.
    #[doc(alias = "SyncStrategy")]
    #[cfg_attr(feature = "serde", serde(default))]
    pub strategy: Option<SyncStrategy>,
    /// Checks and ways of operation. Position-based only.
    #[cfg_attr(feature = "serde", serde(default))]
    pub sync_mode: SyncMode,
    /// Limits of the synchronisation.
    #[cfg_attr(feature = "serde", serde(default))]
    pub limits: SyncLimits,
}

impl<P: Copy> GearInPos<P> {
    /// The positions of master and slave.
    #[must_use]
    pub const fn positions(&self) -> (P, P) {
        (self.master_sync_position, self.slave_sync_position)
    }

    /// The same at these positions of master and slave.
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

/// `MC_GearInVelo`: the slave takes up the gear's velocity as soon as it can. TS5055 12.1.1,
/// TF5055 4.1.
///
/// Limits that are not given are the axis's own. Acceleration, deceleration and jerk shape the
/// profile and hence are kept whether `sync_mode` checks them or not.
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
    /// Position- or time-based, checks and ways of operation.
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
    /// The ratio as one number.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.numerator / f64::from(self.denominator)
    }

    /// A ratio given as one number.
    #[must_use]
    pub const fn of(ratio: f64) -> Self {
        Self {
            numerator: ratio,
            denominator: 1,
        }
    }
}

/// What a synchronisation may do to the slave. What is not given is the axis's own limit, or, for
/// positions, no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct SyncLimits {
    /// Highest speed, u/s.
    #[doc(alias = "Velocity")]
    pub velocity: Option<f64>,
    /// Highest acceleration, u/s².
    #[doc(alias = "Acceleration")]
    pub acceleration: Option<f64>,
    /// Highest deceleration, u/s².
    #[doc(alias = "Deceleration")]
    pub deceleration: Option<f64>,
    /// Highest jerk, u/s³.
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
    /// How fast the master will be, u/s of the master, above 0, where it stands when it is planned and the slave does too:
    /// everything is checked at that velocity then, and not at 0. Without a strategy.
    pub master_velocity: Option<f64>,
}
