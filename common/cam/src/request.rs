//! Common form of all commands for a coupling.

use super::command::{
    Activation, CamAdd, CamExchange, CamIn, CamInV2, CamOut, CamRemove, CamScaling, CamScalingV2,
    ScalingData,
};
use super::error::TableId;
use super::modes::{JumpHandling, OperationMode};

/// Any command to a coupling by cam plates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CamRequest {
    /// The command, by its PLC name.
    pub(super) name: &'static str,
    pub(super) operation: CamOperation,
    pub(super) inputs: CamInputs,
}

/// Operation of a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CamOperation {
    Out,
    /// Couples by the only plate, or exchanges it.
    In(TableId),
    /// Scales the only plate.
    Scale,
    /// Couples by the first of several plates, adds one, or whatever the mode is.
    InOfSeveral(OperationMode, TableId, TableId),
    /// Superposes another plate.
    Add(TableId),
    /// Puts the first plate in place of the second.
    Exchange(TableId, TableId),
    Remove(TableId),
    /// Scales one of several.
    ScaleOfSeveral(TableId),
}

/// Inputs that all commands have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CamInputs {
    pub(super) activation: Activation,
    pub(super) scaling: ScalingData,
    pub(super) jump: JumpHandling,
}

impl CamRequest {
    /// Returns the PLC name of the command.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }
}

const fn inputs(activation: Activation, scaling: ScalingData, jump: JumpHandling) -> CamInputs {
    CamInputs {
        activation,
        scaling,
        jump,
    }
}

impl From<CamOut> for CamRequest {
    fn from(CamOut {}: CamOut) -> Self {
        Self {
            // Ends at once: TF5050 has no activation for it, so its inputs are never read.
            name: CamOut::NAME,
            operation: CamOperation::Out,
            inputs: CamInputs::default(),
        }
    }
}

impl From<CamIn> for CamRequest {
    fn from(command: CamIn) -> Self {
        Self {
            name: CamIn::NAME,
            operation: CamOperation::In(command.table),
            inputs: inputs(command.activation, command.scaling(), command.jump),
        }
    }
}

impl From<CamScaling> for CamRequest {
    fn from(command: CamScaling) -> Self {
        Self {
            name: CamScaling::NAME,
            operation: CamOperation::Scale,
            inputs: inputs(command.activation, command.scaling, command.jump),
        }
    }
}

impl From<CamInV2> for CamRequest {
    fn from(command: CamInV2) -> Self {
        let (operation, reference) = (command.operation, command.reference);
        Self {
            name: CamInV2::NAME,
            operation: CamOperation::InOfSeveral(operation, command.table, reference),
            inputs: inputs(command.activation, command.scaling, command.jump),
        }
    }
}

impl From<CamAdd> for CamRequest {
    fn from(command: CamAdd) -> Self {
        Self {
            name: CamAdd::NAME,
            operation: CamOperation::Add(command.table),
            inputs: inputs(command.activation, command.scaling, command.jump),
        }
    }
}

impl From<CamExchange> for CamRequest {
    fn from(command: CamExchange) -> Self {
        Self {
            name: CamExchange::NAME,
            operation: CamOperation::Exchange(command.table, command.reference),
            inputs: inputs(command.activation, command.scaling, command.jump),
        }
    }
}

impl From<CamRemove> for CamRequest {
    fn from(command: CamRemove) -> Self {
        Self {
            name: CamRemove::NAME,
            // A removed plate has no placement: the default passes every check of a scaling.
            operation: CamOperation::Remove(command.table),
            inputs: inputs(command.activation, ScalingData::default(), command.jump),
        }
    }
}

impl From<CamScalingV2> for CamRequest {
    fn from(command: CamScalingV2) -> Self {
        Self {
            name: CamScalingV2::NAME,
            operation: CamOperation::ScaleOfSeveral(command.table),
            inputs: inputs(command.activation, command.scaling, command.jump),
        }
    }
}
