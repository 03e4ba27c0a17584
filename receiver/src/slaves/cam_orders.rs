//! Orders on the cam plates, given to a slave that they can couple.

use coaxle_axis::Awaits;
use coaxle_cam::{CouplingError, Tables};
use coaxle_node::CommandOutcome;
use coaxle_node::command::{CamOrder, OrderCargo, PlateCommand, PlateWork};
use coaxle_slave::{CouplingRefusal, Refusal};

use super::slave::Slave;

impl Slave {
    /// Executes an order from the network on the plates, with `room` for further points and rows.
    /// Its memory comes and goes in its cargo: no memory is allocated or freed.
    pub(super) fn execute_cam(
        &mut self,
        plates: &mut Tables,
        order: &CamOrder,
        cargo: &mut OrderCargo,
        room: usize,
    ) -> CommandOutcome {
        let work = order.command.row().traits;
        let done = match &order.command {
            PlateCommand::CamInfo {
                table,
                master_position,
            } => match self.axis.cam_info(plates, *table, *master_position) {
                Ok(info) => {
                    let slave = self.view();
                    return CommandOutcome::CamInfo { info, slave };
                }
                Err(error) => Err(error),
            },
            PlateCommand::CamTableSelect { replace, .. } => {
                select(plates, order, *replace, cargo, room)
            }
            PlateCommand::CamTableDelete { table } => match cargo {
                // The plate leaves in the cargo, and is freed outside of the cycle.
                OrderCargo::Table(deleted) if !order.dry_run => plates.delete(*table, deleted),
                _ => plates.plan_delete(*table),
            },
            // Its values are calculated from the plate that it takes back.
            reading => read(plates, reading.table(), cargo),
        };
        let changes = work == PlateWork::Changes;
        // A reading or a dry run that fails is no refused command of the slave.
        if let (Err(error), true) = (done, changes && !order.dry_run) {
            self.note_refusal(refusal_of(error));
        }
        self.answer(done)
    }

    fn answer(&self, done: Result<(), CouplingError>) -> CommandOutcome {
        let slave = self.view();
        match done {
            Ok(()) => CommandOutcome::Accepted {
                job: None,
                awaits: Awaits::empty(),
                slave,
                sync_positions: None,
                saw: None,
            },
            Err(error) => CommandOutcome::Refused {
                refusal: refusal_of(error),
                slave,
                saw: None,
            },
        }
    }
}

const fn refusal_of(error: CouplingError) -> Refusal {
    Refusal::Coupling(CouplingRefusal::Cam(error))
}

fn select(
    plates: &mut Tables,
    order: &CamOrder,
    replace: bool,
    cargo: &mut OrderCargo,
    room: usize,
) -> Result<(), CouplingError> {
    let id = order.command.table();
    match cargo {
        OrderCargo::Table(table) if order.dry_run => {
            plates.plan_select(id, replace, table.as_deref(), room)
        }
        OrderCargo::Table(table) => plates.select(id, replace, table, room),
        // The plate was calculated outside of the cycle. Its error is answered here, like all refusals.
        OrderCargo::Wrong(error) => Err(CouplingError::Cam(*error)),
        OrderCargo::Nothing | OrderCargo::Reading(_) => Err(CouplingError::NoTable),
    }
}

fn read(plates: &Tables, table: u32, cargo: &mut OrderCargo) -> Result<(), CouplingError> {
    match cargo {
        OrderCargo::Reading(reading) => plates.read_plate(table, reading),
        _ => Err(CouplingError::NoTable),
    }
}
