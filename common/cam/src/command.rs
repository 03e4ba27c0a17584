//! Commands to a coupling.

use super::error::{CouplingError, TableId};
use super::modes::{ActivationMode, JumpHandling, OperationMode, ScalingMode, StartMode};

/// Ends the coupling, of either kind: `MC_CamOut`. The slave keeps its velocity, without acceleration.
#[doc(alias = "MC_CamOut")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CamOut {}

/// The names of the blocks.
macro_rules! names {
    ($($command:ident $name:literal)*) => { $(
        impl $command {
            /// PLC name of the command.
            pub const NAME: &str = $name;
        }
    )* };
}

names! {
    CamOut "MC_CamOut"
    CamIn "MC_CamIn"
    CamScaling "MC_CamScaling"
    CamInV2 "MC_CamIn_V2"
    CamAdd "MC_CamAdd"
    CamExchange "MC_CamExchange"
    CamRemove "MC_CamRemove"
    CamScalingV2 "MC_CamScaling_V2"
}

/// Moment at which a change takes effect: `ActivationMode` and `ActivationPosition`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct Activation {
    /// Mode of the activation.
    #[doc(alias = "ActivationMode")]
    pub mode: ActivationMode,
    /// Position of the master at the activation, if the mode uses it: on the unscaled plate, in x, or on
    /// its axis, in u.
    #[doc(alias = "ActivationPosition")]
    pub position: f64,
    /// Alternative for modes that use the position of the master axis: the next time it passes this
    /// position within its turn, u. The coupled axis converts it to a position of its master when the
    /// command is planned.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub in_turn: Option<f64>,
}

impl Activation {
    /// Makes a mode that needs no position.
    #[must_use]
    pub const fn new(mode: ActivationMode) -> Self {
        Self::at(mode, 0.0)
    }

    /// Makes a mode and its position.
    #[must_use]
    pub const fn at(mode: ActivationMode, position: f64) -> Self {
        Self {
            mode,
            position,
            in_turn: None,
        }
    }
}

/// `ST_CamScalingData`, TF5050 chapter 8.19: placement of a plate in the axes of master and slave.
///
/// ```text
/// master on the plate = (master + master offset) / master scaling
/// slave               = slave on the plate * slave scaling + slave offset
/// ```
#[doc(alias = "ST_CamScalingData")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct ScalingData {
    /// For the master.
    pub master: AxisScaling,
    /// For the slave.
    pub slave: AxisScaling,
}

/// Placement of a plate in one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct AxisScaling {
    /// Source of scaling and offset.
    #[doc(alias = "MasterScalingMode")]
    #[doc(alias = "SlaveScalingMode")]
    pub mode: ScalingMode,
    /// True if the plate's origin is the axis position at the activation. Not used for an automatic
    /// offset of the slave.
    #[doc(alias = "MasterRelative")]
    #[doc(alias = "SlaveRelative")]
    pub relative: bool,
    /// The offset, u of that axis.
    #[doc(alias = "MasterOffset")]
    #[doc(alias = "SlaveOffset")]
    pub offset: f64,
    /// The scaling. A master's is not 0.
    #[doc(alias = "MasterScaling")]
    #[doc(alias = "SlaveScaling")]
    pub scaling: f64,
}

impl Default for AxisScaling {
    fn default() -> Self {
        Self {
            mode: ScalingMode::UserDefined,
            relative: false,
            offset: 0.0,
            scaling: 1.0,
        }
    }
}

/// The inputs of `MC_CamIn` and `ST_CamInOptions`, TF5050 chapters 4.3 and 8.16.
///
/// `BufferMode` is not implemented in the original either. `InterpolationType` belongs to the
/// position table here.
#[doc(alias = "MC_CamIn")]
#[doc(alias = "ST_CamInOptions")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct CamIn {
    /// The plate.
    #[doc(alias = "CamTableID")]
    pub table: TableId,
    /// Reference of its positions.
    pub start_mode: StartMode,
    /// Offset of the master, u.
    pub master_offset: f64,
    /// Offset of the slave, u.
    pub slave_offset: f64,
    /// Scaling of the master, not 0.
    pub master_scaling: f64,
    /// Scaling of the slave.
    pub slave_scaling: f64,
    /// Activation of the plate.
    pub activation: Activation,
    /// Source of offset and scaling of the master.
    pub master_scaling_mode: ScalingMode,
    /// Source of offset and scaling of the slave.
    pub slave_scaling_mode: ScalingMode,
    /// Handling of a slave that is not on the plate.
    pub jump: JumpHandling,
}

impl Default for CamIn {
    fn default() -> Self {
        Self {
            table: 0,
            start_mode: StartMode::default(),
            master_offset: 0.0,
            slave_offset: 0.0,
            master_scaling: 1.0,
            slave_scaling: 1.0,
            activation: Activation::default(),
            master_scaling_mode: ScalingMode::default(),
            slave_scaling_mode: ScalingMode::default(),
            jump: JumpHandling::default(),
        }
    }
}

impl CamIn {
    pub(super) const fn scaling(&self) -> ScalingData {
        ScalingData {
            master: AxisScaling {
                mode: self.master_scaling_mode,
                relative: self.start_mode.master_relative(),
                offset: self.master_offset,
                scaling: self.master_scaling,
            },
            slave: AxisScaling {
                mode: self.slave_scaling_mode,
                relative: self.start_mode.slave_relative(),
                offset: self.slave_offset,
                scaling: self.slave_scaling,
            },
        }
    }
}

/// The inputs of `MC_CamScaling`, TF5050 chapter 4.5. A relative scaling is only in `_V2`.
#[doc(alias = "MC_CamScaling")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct CamScaling {
    /// Activation of the change.
    pub activation: Activation,
    /// The new scaling.
    pub scaling: ScalingData,
    /// Handling of a jump of the slave.
    pub jump: JumpHandling,
}

/// The inputs of `MC_CamIn_V2` and `ST_CamInOptions_V2`, TF5050 chapter 5.1.
#[doc(alias = "MC_CamIn_V2")]
#[doc(alias = "ST_CamInOptions_V2")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct CamInV2 {
    /// Activation of the change.
    pub activation: Activation,
    /// The plate.
    #[doc(alias = "CamTableID")]
    pub table: TableId,
    /// Placement of the plate in the axes.
    pub scaling: ScalingData,
    /// Operation with the plate.
    #[doc(alias = "CamOperationMode")]
    pub operation: OperationMode,
    /// The plate to exchange; 0 if there is only one.
    #[doc(alias = "ReferenceCamTableID")]
    pub reference: TableId,
    /// Handling of a jump of the slave.
    pub jump: JumpHandling,
}

/// The inputs of `MC_CamAdd`, TF5050 chapter 5.2.
#[doc(alias = "MC_CamAdd")]
#[doc(alias = "ST_CamAddOptions")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct CamAdd {
    /// Activation of the change.
    pub activation: Activation,
    /// The plate.
    pub table: TableId,
    /// Placement of the plate in the axes. Relative to the slave: the values of the plate are added to
    /// the slave's position.
    pub scaling: ScalingData,
    /// Handling of a jump of the slave.
    pub jump: JumpHandling,
}

/// The inputs of `MC_CamExchange`, TF5050 chapter 5.3.
#[doc(alias = "MC_CamExchange")]
#[doc(alias = "ST_CamExchangeOptions")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct CamExchange {
    /// Activation of the change.
    pub activation: Activation,
    /// The plate.
    pub table: TableId,
    /// The plate to replace; 0 if there is only one.
    pub reference: TableId,
    /// Placement of the plate in the axes.
    pub scaling: ScalingData,
    /// Handling of a jump of the slave.
    pub jump: JumpHandling,
}

/// The inputs of `MC_CamRemove`, TF5050 chapter 5.4.
#[doc(alias = "MC_CamRemove")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct CamRemove {
    /// Activation of the change.
    pub activation: Activation,
    /// The plate.
    pub table: TableId,
    /// Handling of a jump of the slave.
    pub jump: JumpHandling,
}

/// The inputs of `MC_CamScaling_V2`, TF5050 chapter 5.5.
#[doc(alias = "MC_CamScaling_V2")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct CamScalingV2 {
    /// Activation of the change.
    pub activation: Activation,
    /// The plate; 0 if there is only one.
    pub table: TableId,
    /// The new scaling.
    pub scaling: ScalingData,
    /// Handling of a jump of the slave.
    pub jump: JumpHandling,
}

impl ScalingData {
    /// Checks of every operation; `has_reference`: there is a plate whose position is kept.
    pub(super) fn check(&self, has_reference: bool) -> Result<(), CouplingError> {
        let Self { master, slave } = self;
        // An automatic offset keeps the master's part of the cycle, which a relative origin would set to 0.
        if master.mode == ScalingMode::AutoOffset {
            if master.relative {
                return Err(CouplingError::AutoOffsetWithRelativeMaster);
            }
            if !has_reference {
                return Err(CouplingError::NoReferencePlate);
            }
        }
        let fields = [
            // The master is divided by its scaling. A slave's scaling of 0 is a slave at standstill, and allowed.
            ("master scaling", master.scaling, master.scaling != 0.0),
            ("slave scaling", slave.scaling, true),
            ("master offset", master.offset, true),
            ("slave offset", slave.offset, true),
        ];
        for (field, received, allowed) in fields {
            if !received.is_finite() || !allowed {
                return Err(CouplingError::Scaling { field, received });
            }
        }
        Ok(())
    }
}

impl JumpHandling {
    pub(super) fn check(&self) -> Result<(), CouplingError> {
        match *self {
            Self::RampIn { master_length }
                if !(master_length.is_finite() && master_length > 0.0) =>
            {
                Err(CouplingError::Parameter {
                    name: "master length of the ramp",
                    received: master_length,
                    expected: "a finite number above 0",
                })
            }
            _ => Ok(()),
        }
    }
}
