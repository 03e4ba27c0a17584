//! Checks that every change has to pass.

use super::command::Activation;
use super::error::{CouplingError, TableId};
use super::modes::ActivationMode;
use super::rules::Operation;
use coaxle_plate::Plate;

/// Checks whether the mode is allowed for the operation.
pub(super) const fn check_mode(
    operation: Operation,
    mode: ActivationMode,
) -> Result<(), CouplingError> {
    if operation.allows(mode) {
        Ok(())
    } else {
        Err(CouplingError::ModeNotAllowed { operation, mode })
    }
}

/// Checks of every activation. `has_next_cycle`: the plate has a next cycle to wait for.
pub(super) fn check_activation(
    activation: &Activation,
    id: TableId,
    plate: &Plate,
    has_next_cycle: bool,
) -> Result<(), CouplingError> {
    let Activation {
        mode,
        position,
        in_turn,
    } = *activation;
    // The coupled axis converts it before: one that is left over does not apply to this mode.
    if let Some(received) = in_turn {
        return Err(CouplingError::Parameter {
            name: "activation.in-turn",
            received,
            expected: "none but of a coupling at a position of the master axis, and without a position",
        });
    }
    let (from, to) = match mode {
        ActivationMode::AtMasterCamPos => plate.master_range(),
        ActivationMode::AtMasterAxisPos
        | ActivationMode::AtMasterAxisPosPositiveDirection
        // All finite positions: the range excludes infinities and NaN.
        | ActivationMode::AtMasterAxisPosNegativeDirection => (f64::MIN, f64::MAX),
        _ if mode.is_next_cycle() && !has_next_cycle => {
            return Err(CouplingError::NoNextCycle { table: id });
        }
        _ => return Ok(()),
    };
    // NaN is in no range.
    if (from..=to).contains(&position) {
        Ok(())
    } else {
        Err(CouplingError::ActivationPosition {
            received: position,
            from,
            to,
        })
    }
}
