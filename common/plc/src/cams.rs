//! The PLC face of couplings and tables: blocks with an `Execute` input.

use coaxle_axis::{CommandState, Job};
use coaxle_cam::{CamCoupling, CamRequest, CouplingError, Tables};
use coaxle_curve::profile::Kinematics;

use crate::{Execute, Outputs};

/// A function block that commands a coupling: `MC_CamIn`, `MC_CamOut`, `MC_CamScaling`,
/// `MC_CamIn_V2`, `MC_CamAdd`, `MC_CamExchange`, `MC_CamRemove` or `MC_CamScaling_V2`, by its
/// command as a [`CamRequest`].
///
/// While a block is in sync, `Busy` and `Active` are set too, as in PLCopen.
#[derive(Clone, Copy, Debug, Default)]
pub struct CouplingBlock {
    execute: Execute<Job, CouplingError>,
}

impl CouplingBlock {
    /// Runs one scan. The inputs are read on the rising edge of `execute`; call [`CamCoupling::update`]
    /// once per cycle, too.
    pub fn scan(
        &mut self,
        execute: bool,
        command: &CamRequest,
        tables: &mut Tables,
        coupling: &mut CamCoupling,
        [master, slave]: [&Kinematics; 2],
    ) -> Outputs {
        let state = self.execute.scan(
            execute,
            coupling,
            |coupling| coupling.start(tables, command, master, slave),
            |coupling, job| coupling.state_of(*job),
        );
        Outputs::of(state, CouplingError::code)
    }

    /// Returns the state of the command.
    #[must_use]
    pub const fn state(&self) -> &CommandState<CouplingError> {
        self.execute.state()
    }
}

/// A function block that is done in the scan in which it starts, and has a value then: all others of
/// TF5050, by their action on the rising edge.
///
/// ```
/// use coaxle_cam::{OnlineChangeMode, Tables};
/// use coaxle_plc::TableBlock;
///
/// let mut tables = Tables::new(8);
/// let mut set_mode = TableBlock::default();
/// let outputs = set_mode.scan(true, &mut tables, |tables| {
///     tables.set_online_change_mode(7, OnlineChangeMode::default())
/// });
/// assert!(outputs.error && outputs.error_id == 0x4216, "there is no table 7");
/// ```
#[doc(alias = "MC_CamTableSelect")]
#[doc(alias = "MC_SetCamOnlineChangeMode")]
#[doc(alias = "MC_WriteMotionFunction")]
#[doc(alias = "MC_WriteMotionFunctionPoint")]
#[doc(alias = "MC_ReadMotionFunction")]
#[doc(alias = "MC_ReadMotionFunctionPoint")]
#[doc(alias = "MC_ReadMotionFunctionValues")]
#[doc(alias = "MC_ReadCamTableSlaveDynamics")]
#[doc(alias = "MC_ReadCamTableCharacteristics")]
#[doc(alias = "MC_ReadCamTableMasterPosition")]
#[doc(alias = "MC_CamInfo")]
#[doc(alias = "MC_CamInfo_V2")]
#[derive(Clone, Copy, Debug)]
pub struct TableBlock<T> {
    execute: Execute<(), CouplingError>,
    value: Option<T>,
}

impl<T> Default for TableBlock<T> {
    fn default() -> Self {
        Self {
            execute: Execute::default(),
            value: None,
        }
    }
}

impl<T> TableBlock<T> {
    /// Runs one scan; `run` is called on the rising edge of `execute`.
    pub fn scan<A>(
        &mut self,
        execute: bool,
        axis: &mut A,
        run: impl FnOnce(&mut A) -> Result<T, CouplingError>,
    ) -> Outputs {
        let value = &mut self.value;
        let state = self.execute.scan(
            execute,
            axis,
            |axis| {
                // An error leaves the last value: the outputs say that it is not of this run.
                *value = Some(run(axis)?);
                Ok(())
            },
            // Done in the scan in which it starts, so that there is no progress to follow.
            |_, ()| CommandState::Done,
        );
        Outputs::of(state, CouplingError::code)
    }

    /// Returns the result of the last successful run.
    #[must_use]
    pub const fn value(&self) -> Option<&T> {
        self.value.as_ref()
    }
}
