//! Function blocks of the flying saw on a slave axis. `MC_GearOut` is a
//! [`CommandBlock`].

use coaxle_axis::CommandState;
use coaxle_cam::Tables;
use coaxle_saw::{FlyingSawCharacteristics, SawCommand, saw_table_id};
use coaxle_slave::{CouplingRefusal, JobError, Refusal, SlaveAxis};

use crate::axis::CommandBlock;
use crate::{Execute, Outputs};

/// `MC_GearInPos` and `MC_GearInVelo`, by the [`SawCommand`]. TS5055 12.1.
#[doc(alias = "MC_GearInPos")]
#[doc(alias = "MC_GearInVelo")]
#[derive(Clone, Copy, Debug, Default)]
pub struct FlyingSawBlock {
    block: CommandBlock,
}

/// Outputs of [`FlyingSawBlock`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FlyingSawOutputs {
    /// The synchronisation has begun.
    #[doc(alias = "StartSync")]
    pub start_sync: bool,
    /// Outputs common to all blocks.
    pub common: Outputs,
}

impl FlyingSawBlock {
    /// Runs one scan. The command is read on the rising edge of `execute`.
    pub fn scan(
        &mut self,
        execute: bool,
        command: SawCommand,
        axis: &mut SlaveAxis,
        plates: &mut Tables,
    ) -> FlyingSawOutputs {
        let state = self.block.scan(execute, &command.into(), axis, plates);
        FlyingSawOutputs {
            // From the begin of the synchronisation on, as long as the command controls the axis.
            start_sync: matches!(state, CommandState::Active | CommandState::InSync),
            common: Outputs::of(&state, JobError::code),
        }
    }
}

/// `MC_ReadFlyingSawCharacteristics`, TS5055 12.1.3.
#[doc(alias = "MC_ReadFlyingSawCharacteristics")]
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadFlyingSawCharacteristicsBlock {
    execute: Execute<FlyingSawCharacteristics, Refusal>,
}

impl ReadFlyingSawCharacteristicsBlock {
    /// Runs one scan: returns the outputs, and the values read on the last rising edge of `execute`, as
    /// long as `Done` is set. Values depend on the axis's id, since that of their table does.
    pub fn scan(
        &mut self,
        execute: bool,
        axis_id: u32,
        axis: &SlaveAxis,
    ) -> (Outputs, Option<FlyingSawCharacteristics>) {
        let mut read = None;
        let state = self.execute.scan(
            execute,
            &mut (),
            |()| {
                let plan = axis.saw_plan().ok_or(Refusal::NoCharacteristics)?;
                // No table of the axis is taken: the values are read, and no table is made.
                let table = saw_table_id(axis_id, |_| false).map_err(CouplingRefusal::Saw)?;
                Ok(plan.characteristics(table))
            },
            |(), values| {
                // Values of the rising edge, held by the block: the plan may have changed since.
                read = Some(*values);
                CommandState::Done
            },
        );
        (Outputs::of(state, Refusal::code), read)
    }
}
