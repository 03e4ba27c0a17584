//! The function blocks of the flying saw, as a PLC program calls them: once per scan, with levels.

use coaxle_clock::Seconds;

use crate::plc::{CommandState, Execute, Outputs};
use crate::profile::Kinematics;

use super::characteristics::{FlyingSawCharacteristics, saw_table_id};
use super::moment::CouplingMoment;
use super::running::{SawCommand, SawCoupling, SawFault, SawTolerances};

/// A slave as its blocks see it: the coupling it has, if any, and which command that came from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SawSlave {
    coupling: Option<SawCoupling>,
    command: u32,
}

impl SawSlave {
    /// Couples the slave, in place of whatever coupling it had, which is aborted.
    ///
    /// # Errors
    /// [`SawFault::Refused`]; an earlier coupling stays in force then.
    pub fn start(
        &mut self,
        command: SawCommand,
        moment: &CouplingMoment,
        tolerances: SawTolerances,
    ) -> Result<u32, SawFault> {
        let coupling =
            SawCoupling::start(command, moment, tolerances).map_err(SawFault::Refused)?;
        self.coupling = Some(coupling);
        self.command = self.command.wrapping_add(1);
        Ok(self.command)
    }

    /// One cycle: the slave's set values, if it has a coupling.
    pub fn update(&mut self, master: &Kinematics, elapsed: Seconds) -> Option<Kinematics> {
        Some(self.coupling.as_mut()?.update(master, elapsed))
    }

    /// The coupling.
    #[must_use]
    pub const fn coupling(&self) -> Option<&SawCoupling> {
        self.coupling.as_ref()
    }

    fn state_of(&self, command: u32) -> CommandState<SawFault> {
        match &self.coupling {
            Some(coupling) if command == self.command => *coupling.state(),
            _ => CommandState::Aborted,
        }
    }
}

/// `MC_GearInPos` and `MC_GearInVelo`; which one, the [`SawCommand`] says.
#[doc(alias = "MC_GearInPos")]
#[doc(alias = "MC_GearInVelo")]
#[derive(Clone, Copy, Debug, Default)]
pub struct GearInBlock {
    execute: Execute<u32, SawFault>,
}

/// The outputs of [`GearInBlock`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GearInOutputs {
    /// The synchronisation has begun.
    #[doc(alias = "StartSync")]
    pub start_sync: bool,
    /// What every block has.
    pub common: Outputs,
}

impl GearInBlock {
    /// One scan. Command and moment are read on the rising edge of `execute`.
    pub fn scan(
        &mut self,
        execute: bool,
        command: &SawCommand,
        (moment, tolerances): (&CouplingMoment, SawTolerances),
        slave: &mut SawSlave,
    ) -> GearInOutputs {
        let state = self.execute.scan(
            execute,
            slave,
            |slave| slave.start(*command, moment, tolerances),
            |slave, number| slave.state_of(*number),
        );
        GearInOutputs {
            start_sync: matches!(state, CommandState::Active | CommandState::InSync),
            common: state.outputs(SawFault::code),
        }
    }
}

/// `MC_GearOut`, TS5055 12.2.1.
#[doc(alias = "MC_GearOut")]
#[derive(Clone, Copy, Debug, Default)]
pub struct GearOutBlock {
    execute: Execute<(), NotCoupled>,
}

/// There is no coupling to release: 0x424D.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotCoupled;

impl GearOutBlock {
    /// One scan.
    pub fn scan(&mut self, execute: bool, slave: &mut SawSlave) -> Outputs {
        let state = self.execute.scan(
            execute,
            slave,
            |slave| match &mut slave.coupling {
                Some(coupling) if coupling.is_coupled() => {
                    coupling.gear_out();
                    Ok(())
                }
                _ => Err(NotCoupled),
            },
            |_, ()| CommandState::Done,
        );
        state.outputs(|NotCoupled| 0x424d)
    }
}

/// `MC_ReadFlyingSawCharacteristics`, TS5055 12.1.3.
#[doc(alias = "MC_ReadFlyingSawCharacteristics")]
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadFlyingSawCharacteristicsBlock {
    execute: Execute<FlyingSawCharacteristics, NoCharacteristics>,
}

/// The slave has no profile yet: 0x4216.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoCharacteristics;

impl ReadFlyingSawCharacteristicsBlock {
    /// One scan: the outputs, and the values that were read last.
    pub fn scan(
        &mut self,
        execute: bool,
        axis_id: u32,
        slave: &mut SawSlave,
    ) -> (Outputs, Option<FlyingSawCharacteristics>) {
        let mut read = None;
        let state = self.execute.scan(
            execute,
            slave,
            |slave| {
                let table = saw_table_id(axis_id, |_| false);
                let plan = slave.coupling.as_ref().map(SawCoupling::plan);
                match (plan, table) {
                    (Some(plan), Ok(table)) => Ok(plan.characteristics(table)),
                    _ => Err(NoCharacteristics),
                }
            },
            |_, values| {
                read = Some(*values);
                CommandState::Done
            },
        );
        (state.outputs(|NoCharacteristics| 0x4216), read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::saw::tests::{moment, to_position};
    use crate::saw::{Ratio, SyncLimits, SyncMode};

    fn command() -> SawCommand {
        let limits = SyncLimits::default();
        SawCommand::GearInPos(to_position(1.0, (10.0, 10.0), SyncMode::default(), limits))
    }

    #[test]
    fn a_program_couples_reads_and_uncouples() {
        let mut slave = SawSlave::default();
        let (mut gear_in, mut gear_out) = (GearInBlock::default(), GearOutBlock::default());
        let mut read = ReadFlyingSawCharacteristicsBlock::default();
        let start = moment((0.0, 100.0), (0.0, 0.0));
        let conditions = (&start, SawTolerances::default());

        assert_eq!(read.scan(true, 2, &mut slave).0.error_id, 0x4216);
        assert_eq!(gear_out.scan(true, &mut slave).error_id, 0x424d);
        assert_eq!(gear_out.scan(false, &mut slave), Outputs::default());
        read.scan(false, 2, &mut slave);

        let outputs = gear_in.scan(true, &command(), conditions, &mut slave);
        assert!(outputs.start_sync && outputs.common.busy && !outputs.common.in_sync);
        let (outputs, values) = read.scan(true, 2, &mut slave);
        assert!(outputs.done);
        assert_eq!(values.map(|values| values.table.id), Some(254));

        let mut master = start.master;
        for _ in 0..200 {
            master.position += 0.1;
            slave.update(&master, Seconds(1e-3));
        }
        let outputs = gear_in.scan(true, &command(), conditions, &mut slave);
        assert!(outputs.common.in_sync && outputs.common.busy);
        assert!(gear_out.scan(true, &mut slave).done);
        let outputs = gear_in.scan(true, &command(), conditions, &mut slave);
        assert!(outputs.common.command_aborted && !outputs.start_sync);
        let outputs = gear_in.scan(false, &command(), conditions, &mut slave);
        assert_eq!(outputs, GearInOutputs::default());
    }

    #[test]
    fn a_refused_command_leaves_the_running_one() {
        let mut slave = SawSlave::default();
        let (mut first, mut second) = (GearInBlock::default(), GearInBlock::default());
        let start = moment((0.0, 100.0), (0.0, 0.0));
        let conditions = (&start, SawTolerances::default());
        first.scan(true, &command(), conditions, &mut slave);
        let SawCommand::GearInPos(mut refused) = command() else {
            return;
        };
        refused.ratio = Ratio::of(0.0);
        let refused = SawCommand::GearInPos(refused);
        let outputs = second.scan(true, &refused, conditions, &mut slave);
        assert_eq!(outputs.common.error_id, 0x421b);
        let outputs = first.scan(true, &command(), conditions, &mut slave);
        assert!(outputs.common.busy);
        second.scan(false, &command(), conditions, &mut slave);
        second.scan(true, &command(), conditions, &mut slave);
        let outputs = first.scan(true, &command(), conditions, &mut slave);
        assert!(outputs.common.command_aborted);
    }
}
