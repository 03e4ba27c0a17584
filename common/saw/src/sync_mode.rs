//! Checks and mode of operation of a synchronisation.

/// `ST_SyncMode`: the mode of a synchronisation, the limits that are checked while it is planned,
/// and how it behaves. TF5055 5.1, TS5055 5.
#[doc(alias = "ST_SyncMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct SyncMode {
    /// Variable that the slave's profile depends on.
    #[doc(alias = "GearInSyncMode")]
    pub base: GearInSyncMode,
    /// Checks and modes of operation.
    pub mask: SyncMask,
}

impl SyncMode {
    /// Makes a profile over the master's position.
    #[must_use]
    pub const fn position_based(mask: SyncMask) -> Self {
        Self {
            base: GearInSyncMode::PositionBased,
            mask,
        }
    }

    /// Makes a profile over time.
    #[must_use]
    pub const fn time_based(mask: SyncMask) -> Self {
        Self {
            base: GearInSyncMode::TimeBased,
            mask,
        }
    }
}

/// `E_GearInSyncMode`, TF5055 5.2.
#[doc(alias = "E_GearInSyncMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum GearInSyncMode {
    /// The slave's path is a function of the master's position: a change of the master's velocity changes
    /// the slave's.
    #[doc(alias = "GEARINSYNCMODE_POSITIONBASED")]
    #[default]
    PositionBased,
    /// The slave's path is a profile of its own over time that keeps all its limits, for any motion of
    /// the master. For `MC_GearInVelo` only.
    #[doc(alias = "GEARINSYNCMODE_TIMEBASED")]
    TimeBased,
}

bitflags::bitflags! {
    /// The flags of `ST_SyncMode` with the values of `GEARINSYNC_CHECKMASK_…` and
    /// `GEARINSYNC_OPMASK_…` (TS5055 5, TF5055 5.1).
    ///
    /// Overshoot and undershoot are in the axis's own coordinates: over is towards larger values, under
    /// towards smaller ones, in either direction of travel.
    ///
    /// The manuals give no values for the two user position limits, for `IgnoreSlaveAcc` and for
    /// `DetailedErrorCodes`; they have the free bits at their places in the structure.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct SyncMask: u32 {
        /// Position not below the software limit.
        #[doc(alias = "GearInSync_CheckMask_MinPos")]
        const MIN_POS = 0x0000_0001;
        /// Position not above the software limit.
        #[doc(alias = "GearInSync_CheckMask_MaxPos")]
        const MAX_POS = 0x0000_0002;
        /// Speed not above the limit, in either direction.
        #[doc(alias = "GearInSync_CheckMask_MaxVelo")]
        const MAX_VELO = 0x0000_0004;
        /// Acceleration within its limit while the slave speeds up.
        #[doc(alias = "GearInSync_CheckMask_MaxAcc")]
        const MAX_ACC = 0x0000_0008;
        /// Deceleration within its limit while the slave slows down.
        #[doc(alias = "GearInSync_CheckMask_MaxDec")]
        const MAX_DEC = 0x0000_0010;
        /// Jerk within its limit, either sign.
        #[doc(alias = "GearInSync_CheckMask_MaxJerk")]
        const MAX_JERK = 0x0000_0020;
        /// Position not below the command's own limit.
        #[doc(alias = "GearInSync_CheckMask_OptionalMinPos")]
        const OPTIONAL_MIN_POS = 0x0000_0040;
        /// Position not above the command's own limit.
        #[doc(alias = "GearInSync_CheckMask_OptionalMaxPos")]
        const OPTIONAL_MAX_POS = 0x0000_0080;
        /// Position not above both its start and its synchronisation position.
        #[doc(alias = "GearInSync_CheckMask_OvershootPos")]
        const OVERSHOOT_POS = 0x0000_0100;
        /// Position not below both its start and its synchronisation position.
        #[doc(alias = "GearInSync_CheckMask_UndershootPos")]
        const UNDERSHOOT_POS = 0x0000_0200;
        /// Velocity not above both its start and its synchronous velocity.
        #[doc(alias = "GearInSync_CheckMask_OvershootVelo")]
        const OVERSHOOT_VELO = 0x0000_0400;
        /// Velocity not below both its start and its synchronous velocity.
        #[doc(alias = "GearInSync_CheckMask_UndershootVelo")]
        const UNDERSHOOT_VELO = 0x0000_0800;
        /// Velocity never above zero, unless the slave starts or ends above it.
        #[doc(alias = "GearInSync_CheckMask_OvershootVeloZero")]
        const OVERSHOOT_VELO_ZERO = 0x0000_1000;
        /// Velocity never below zero, unless the slave starts or ends below it.
        #[doc(alias = "GearInSync_CheckMask_UndershootVeloZero")]
        const UNDERSHOOT_VELO_ZERO = 0x0000_2000;
        /// Once synchronous, a master that runs back past the coupling position stops the slave.
        #[doc(alias = "GearInSync_OpMask_RollbackLock")]
        const ROLLBACK_LOCK = 0x0001_0000;
        /// The stop after a rollback takes one cycle instead of a ramp.
        #[doc(alias = "GearInSync_OpMask_InstantStopOnRollback")]
        const INSTANT_STOP_ON_ROLLBACK = 0x0002_0000;
        /// Ramps at the acceleration limit with a phase of constant velocity between them.
        #[doc(alias = "GearInSync_OpMask_PreferConstVelo")]
        const PREFER_CONST_VELO = 0x0010_0000;
        /// Plans as if the master did not accelerate.
        #[doc(alias = "GearInSync_OpMask_IgnoreMasterAcc")]
        const IGNORE_MASTER_ACC = 0x0020_0000;
        /// Plans as if the slave did not accelerate.
        #[doc(alias = "GearInSync_OpMask_IgnoreSlaveAcc")]
        const IGNORE_SLAVE_ACC = 0x0040_0000;
        /// A violated check reports its own code instead of 0x42DF.
        #[doc(alias = "GearInSync_OpMask_DetailedErrorCodes")]
        const DETAILED_ERROR_CODES = 0x0080_0000;
    }
}

impl SyncMask {
    /// Checks of the slave's dynamic limits.
    pub const MAX_DYNAMICS: Self = Self::MAX_VELO
        .union(Self::MAX_ACC)
        .union(Self::MAX_DEC)
        .union(Self::MAX_JERK);

    /// Checks of the slave's position.
    pub const POSITIONS: Self = Self::MIN_POS
        .union(Self::MAX_POS)
        .union(Self::OPTIONAL_MIN_POS)
        .union(Self::OPTIONAL_MAX_POS)
        .union(Self::OVERSHOOT_POS)
        .union(Self::UNDERSHOOT_POS);

    /// Checks of all kinds.
    // Bits 0 to 13: operation modes begin at bit 16.
    pub const CHECKS: Self = Self::from_bits_truncate(0x0000_3fff);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bits_have_the_manuals_values() {
        // The four flags without a value in the manuals are missing here.
        for (mask, value) in [
            (SyncMask::MIN_POS, 1),
            (SyncMask::MAX_POS, 2),
            (SyncMask::MAX_VELO, 4),
            (SyncMask::MAX_ACC, 8),
            (SyncMask::MAX_DEC, 16),
            (SyncMask::MAX_JERK, 32),
            (SyncMask::OVERSHOOT_POS, 256),
            (SyncMask::UNDERSHOOT_POS, 512),
            (SyncMask::OVERSHOOT_VELO, 1024),
            (SyncMask::UNDERSHOOT_VELO, 2048),
            (SyncMask::OVERSHOOT_VELO_ZERO, 4096),
            (SyncMask::UNDERSHOOT_VELO_ZERO, 8192),
            (SyncMask::ROLLBACK_LOCK, 65_536),
            (SyncMask::INSTANT_STOP_ON_ROLLBACK, 131_072),
            (SyncMask::PREFER_CONST_VELO, 1_048_576),
            (SyncMask::IGNORE_MASTER_ACC, 2_097_152),
        ] {
            assert_eq!(mask.bits(), value, "{mask:?}");
        }
    }
}
