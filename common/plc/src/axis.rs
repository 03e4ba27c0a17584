//! Function blocks of a slave axis, as a PLC program calls them: once per scan, with levels.

use core::fmt;

use coaxle_axis::{CommandState, CouplingPhase};
use coaxle_cam::Ticket;
use coaxle_gear::FlyingGearParameters;
use coaxle_slave::{Accepted, Command, JobNumber, Refusal, SlaveAxis, SlaveError};

use crate::{Execute, Outputs};

/// A function block with an `Execute` input; which one, the [`Command`] says.
///
/// `InVelocity` of `MC_MoveVelocity` and `InGear` of `MC_GearIn` are
/// [`InSync`](CommandState::InSync). `MC_Stop` keeps the axis in `Stopping` as long as it is executed.
#[doc(alias = "MC_Reset")]
#[doc(alias = "MC_Home")]
#[doc(alias = "MC_MoveAbsolute")]
#[doc(alias = "MC_MoveRelative")]
#[doc(alias = "MC_MoveVelocity")]
#[doc(alias = "MC_Halt")]
#[doc(alias = "MC_Stop")]
#[doc(alias = "MC_GearIn")]
#[doc(alias = "MC_GearOut")]
#[derive(Clone, Copy, Debug, Default)]
pub struct CommandBlock {
    execute: Execute<Accepted, BlockError>,
    job: Option<JobNumber>,
}

impl CommandBlock {
    /// One scan. The command is read on the rising edge of `execute`.
    pub fn scan(
        &mut self,
        execute: bool,
        command: &Command,
        axis: &mut SlaveAxis,
    ) -> CommandState<BlockError> {
        let job = &mut self.job;
        let state = *self.execute.scan(
            execute,
            axis,
            |axis| {
                *job = None;
                let accepted = axis.command(command)?;
                if let Accepted::Job(number) = accepted {
                    *job = Some(number);
                }
                Ok(accepted)
            },
            |axis, accepted| match *accepted {
                Accepted::AtOnce => CommandState::Done,
                Accepted::Job(number) => state_of(axis, number),
                Accepted::Change(change) => state_of_change(axis, change),
            },
        );
        if matches!(command, Command::Stop { .. }) && self.job == Some(axis.job().0) {
            axis.hold_stop(execute);
        }
        state
    }
}

fn state_of(axis: &SlaveAxis, job: JobNumber) -> CommandState<BlockError> {
    axis.progress(job).map_error(BlockError::Axis)
}

fn state_of_change(axis: &SlaveAxis, change: Ticket) -> CommandState<BlockError> {
    axis.change_progress(change)
        .map_error(|error| Refusal::Cam(error).into())
}

/// `MC_Power`: a function block with an `Enable` input.
#[doc(alias = "MC_Power")]
#[derive(Clone, Copy, Debug, Default)]
pub struct Power {
    enabled: bool,
}

/// What [`Power`] shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct PowerOutputs {
    /// `Status`: the axis has power and takes commands.
    pub status: bool,
    /// `Busy`: `Enable` is there.
    pub busy: bool,
    /// `Error`: the axis is in error stop.
    pub error: bool,
    /// `ErrorID`, 0 without an error.
    pub error_id: u32,
}

impl Power {
    /// One scan.
    pub fn scan(&mut self, enable: bool, axis: &mut SlaveAxis) -> PowerOutputs {
        if enable != self.enabled && axis.command(&Command::Power(enable)).is_ok() {
            self.enabled = enable;
        }
        PowerOutputs {
            status: axis.is_operational(),
            busy: enable,
            error: axis.error().is_some(),
            error_id: axis.error().map_or(0, |error| error.code()),
        }
    }
}

/// `MC_FlyingGear`: a function block with an `Enable` input. Its falling edge uncouples the axis.
#[doc(alias = "MC_FlyingGear")]
#[derive(Clone, Copy, Debug, Default)]
pub struct EnableFlyingGear {
    enabled: bool,
    accepted: Option<JobNumber>,
    refused: Option<Refusal>,
}

/// What [`EnableFlyingGear`] shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct FlyingGearOutputs {
    /// `StartSync`: the master is where the gear is engaged.
    pub start_sync: bool,
    /// `InSync`: fully coupled.
    pub in_sync: bool,
    /// `Busy`: enabled, and nothing stands against it.
    pub busy: bool,
    /// `Active`: from the begin of engaging to the slave's stop position.
    pub active: bool,
    /// `Error`: refused, or the axis failed.
    pub error: bool,
    /// `ErrorId`, 0 without an error.
    pub error_id: u32,
}

impl EnableFlyingGear {
    /// One scan. The parameters are read on the rising edge of `enable`.
    pub fn scan(
        &mut self,
        enable: bool,
        parameters: &FlyingGearParameters,
        axis: &mut SlaveAxis,
    ) -> FlyingGearOutputs {
        match (self.enabled, enable) {
            (false, true) => self.enable(parameters, axis),
            (true, false) => self.disable(axis),
            _ => {}
        }
        self.enabled = enable;
        self.outputs(axis)
    }

    fn enable(&mut self, parameters: &FlyingGearParameters, axis: &mut SlaveAxis) {
        match axis.command(&Command::FlyingGear(*parameters)) {
            Ok(Accepted::Job(number)) => self.accepted = Some(number),
            Ok(Accepted::AtOnce | Accepted::Change(_)) => {}
            Err(refusal) => self.refused = Some(refusal),
        }
    }

    fn disable(&mut self, axis: &mut SlaveAxis) {
        let coupled = self.accepted == Some(axis.job().0) && axis.coupling_phase().is_some();
        *self = Self::default();
        if coupled {
            self.refused = axis.command(&Command::GearOut {}).err();
        }
    }

    fn outputs(&self, axis: &SlaveAxis) -> FlyingGearOutputs {
        let state = match (self.accepted, self.refused) {
            (_, Some(refusal)) => CommandState::Failed(BlockError::Refused(refusal)),
            (Some(number), None) => state_of(axis, number),
            (None, None) => CommandState::Idle,
        };
        let shown = Outputs::of(&state, BlockError::code);
        let phase = axis.coupling_phase().filter(|_| shown.busy);
        FlyingGearOutputs {
            start_sync: phase == Some(CouplingPhase::Synchronizing),
            in_sync: shown.in_sync,
            busy: shown.busy,
            active: shown.active,
            error: shown.error,
            error_id: shown.error_id,
        }
    }
}

/// Why a function block of a slave axis shows an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BlockError {
    /// Its command was refused.
    Refused(Refusal),
    /// The axis failed while it was busy.
    Axis(SlaveError),
}

impl From<Refusal> for BlockError {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl BlockError {
    /// NC error code.
    #[must_use]
    pub fn code(&self) -> u32 {
        match self {
            Self::Refused(refusal) => refusal.code(),
            Self::Axis(error) => error.code(),
        }
    }
}

impl fmt::Display for BlockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(refusal) => refusal.fmt(f),
            Self::Axis(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for BlockError {}
