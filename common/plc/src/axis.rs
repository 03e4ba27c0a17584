//! Function blocks of a slave axis, called by a PLC program once per scan, with levels.

use coaxle_axis::{CommandState, CouplingPhase, Job};
use coaxle_cam::Tables;
use coaxle_gear::FlyingGearParameters;
use coaxle_slave::{Command, JobError, Refusal, SlaveAxis};

use crate::{Execute, Outputs};

/// A function block with an `Execute` input, for any [`Command`].
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
    execute: Execute<Job, JobError>,
    job: Option<Job>,
}

impl CommandBlock {
    /// Runs one scan. The command is read on the rising edge of `execute`.
    pub fn scan(
        &mut self,
        execute: bool,
        command: &Command,
        axis: &mut SlaveAxis,
        plates: &mut Tables,
    ) -> CommandState<JobError> {
        let job = &mut self.job;
        let state = *self.execute.scan(
            execute,
            axis,
            |axis| {
                // Cleared first: after a refusal the block must not hold the stop of an earlier command.
                *job = None;
                let accepted = axis.command(plates, command)?;
                *job = Some(accepted);
                Ok(accepted)
            },
            |axis, job| axis.progress(*job),
        );
        // Only while its own job still moves the axis: another block may have taken over.
        if matches!(command, Command::Stop { .. }) && self.job.is_some() && self.job == axis.job().0
        {
            axis.hold_stop(execute);
        }
        state
    }
}

/// `MC_Power`: a function block with an `Enable` input.
#[doc(alias = "MC_Power")]
#[derive(Clone, Copy, Debug, Default)]
pub struct Power {
    enabled: bool,
}

/// Outputs of [`Power`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct PowerOutputs {
    /// `Status`: the axis has power and takes commands.
    pub status: bool,
    /// `Busy`: `Enable` is set.
    pub busy: bool,
    /// `Error`: the axis is in error stop.
    pub error: bool,
    /// `ErrorID`, 0 without an error.
    pub error_id: u32,
}

impl Power {
    /// Runs one scan.
    pub fn scan(
        &mut self,
        enable: bool,
        axis: &mut SlaveAxis,
        plates: &mut Tables,
    ) -> PowerOutputs {
        // Tried again in each scan until accepted: a level wants a state, not an event.
        if enable != self.enabled && axis.command(plates, &Command::Power(enable)).is_ok() {
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
    accepted: Option<Job>,
    refused: Option<Refusal>,
}

/// Outputs of [`EnableFlyingGear`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct FlyingGearOutputs {
    /// `StartSync`: the master is in the range where the gear is engaged.
    pub start_sync: bool,
    /// `InSync`: fully coupled.
    pub in_sync: bool,
    /// `Busy`: enabled, without an error.
    pub busy: bool,
    /// `Active`: from the begin of engaging to the slave's stop position.
    pub active: bool,
    /// `Error`: refused, or the axis failed.
    pub error: bool,
    /// `ErrorId`, 0 without an error.
    pub error_id: u32,
}

impl EnableFlyingGear {
    /// Runs one scan. The parameters are read on the rising edge of `enable`.
    pub fn scan(
        &mut self,
        enable: bool,
        parameters: &FlyingGearParameters,
        axis: &mut SlaveAxis,
        plates: &mut Tables,
    ) -> FlyingGearOutputs {
        match (self.enabled, enable) {
            (false, true) => self.enable(parameters, axis, plates),
            (true, false) => self.disable(axis, plates),
            _ => {}
        }
        self.enabled = enable;
        self.outputs(axis)
    }

    fn enable(
        &mut self,
        parameters: &FlyingGearParameters,
        axis: &mut SlaveAxis,
        plates: &mut Tables,
    ) {
        // The refusal of an earlier edge says nothing of this one.
        *self = Self::default();
        match axis.command(plates, &(*parameters).into()) {
            Ok(job) => self.accepted = Some(job),
            Err(refusal) => self.refused = Some(refusal),
        }
    }

    fn disable(&mut self, axis: &mut SlaveAxis, plates: &mut Tables) {
        // A falling edge must not uncouple what another block has coupled meanwhile.
        let coupled = self.accepted.is_some()
            && self.accepted == axis.job().0
            && axis.coupling_phase().is_some();
        *self = Self::default();
        if coupled {
            self.refused = axis.command(plates, &Command::GearOut {}).err();
        }
    }

    fn outputs(&self, axis: &SlaveAxis) -> FlyingGearOutputs {
        let state = match (self.accepted, self.refused) {
            // A refusal first: the job of an earlier command says nothing of the refused one.
            (_, Some(refusal)) => CommandState::Failed(JobError::Refused(refusal)),
            (Some(job), None) => axis.progress(job),
            (None, None) => CommandState::Idle,
        };
        let shown = Outputs::of(&state, JobError::code);
        // Busy belongs to this block's job; the axis may be coupled by another.
        let phase = axis.coupling_phase().filter(|_| shown.busy);
        FlyingGearOutputs {
            start_sync: phase.is_some_and(CouplingPhase::is_synchronizing),
            in_sync: shown.in_sync,
            busy: shown.busy,
            active: shown.active,
            error: shown.error,
            error_id: shown.error_id,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{Master, PARAMETERS, powered};

    #[test]
    fn an_accepted_flying_gear_shows_no_earlier_refusal() {
        let gear = FlyingGearParameters {
            ratio: 1.0,
            master_sync_position: 100.0,
            slave_sync_position: 40.0,
            slave_desync_position: 100.0,
            slave_stop_position: 120.0,
            default_slave_negative: false,
        };
        let mut axis = powered(&PARAMETERS);
        Master::at(0.0, 100.0).lead(&mut axis, 1);
        // As a refused `GearOut` leaves it.
        let mut block = EnableFlyingGear {
            refused: axis
                .command(&mut Tables::new(0), &Command::GearOut {})
                .err(),
            ..EnableFlyingGear::default()
        };
        let off = block.scan(false, &gear, &mut axis, &mut Tables::new(0));
        assert!(off.error && !off.busy);
        let on = block.scan(true, &gear, &mut axis, &mut Tables::new(0));
        assert!(on.busy && !on.error, "{on:?}");
    }
}
