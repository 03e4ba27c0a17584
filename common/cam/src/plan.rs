//! Planning a command: all refusals that are possible before it is due, and its change.

use super::checks::{check_activation, check_mode};
use super::coupling::{CamCoupling, CouplingKind, MOST_PLATES, is_finite};
use super::error::{CouplingError, TableId};
use super::layer::{Layer, Pending, Queue};
use super::modes::{ActivationMode, JumpHandling, OperationMode};
use super::request::{CamInputs, CamOperation, CamRequest};
use super::rules::Operation;
use super::tables::{TableRef, Tables};
use coaxle_axis::Awaits;
use coaxle_curve::profile::Kinematics;
use coaxle_plate::Course;

/// Change by a command to a coupling by cam plates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CamChange(pub(super) PlannedCamChange);

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PlannedCamChange {
    /// End of the coupling.
    End,
    /// Discards the queue of a place.
    DeleteQueued { index: usize },
    /// No change.
    Nothing,
    /// Queues a plate for a place, or its removal.
    Plate {
        index: usize,
        table: Option<TableRef>,
        inputs: CamInputs,
        /// Set for the first plate of a coupling.
        first: Option<CouplingBegin>,
    },
    /// Queues a scaling of the plate in a place.
    Scaling { index: usize, inputs: CamInputs },
}

/// Begin of a coupling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CouplingBegin {
    pub(super) kind: CouplingKind,
    pub(super) master: Kinematics,
    pub(super) slave: Kinematics,
}

/// The axes' set values at the command.
#[derive(Clone, Copy)]
struct CouplingAxes<'a> {
    master: &'a Kinematics,
    slave: &'a Kinematics,
}

impl CamChange {
    /// Conditions with which it can still be refused when it is due.
    pub(super) fn awaits(&self) -> Awaits {
        let (inputs, more) = match &self.0 {
            PlannedCamChange::End
            | PlannedCamChange::DeleteQueued { .. }
            | PlannedCamChange::Nothing => return Awaits::empty(),
            PlannedCamChange::Plate {
                table: None,
                inputs,
                ..
            } if inputs.is_once() => (inputs, Awaits::NOT_THE_LAST),
            PlannedCamChange::Plate { inputs, .. } => (inputs, Awaits::empty()),
            PlannedCamChange::Scaling { inputs, .. } if inputs.is_once() => {
                (inputs, Awaits::STILL_COUPLED | Awaits::NOTHING_PENDING)
            }
            PlannedCamChange::Scaling { inputs, .. } => (inputs, Awaits::STILL_COUPLED),
        };
        let jump = match inputs.jump {
            JumpHandling::Allow => Awaits::empty(),
            JumpHandling::Refuse | JumpHandling::RampIn { .. } => Awaits::JUMP,
        };
        more | jump | Awaits::FINITE
    }
}

impl CamInputs {
    const fn is_once(&self) -> bool {
        matches!(self.activation.mode, ActivationMode::NextCycleOnce)
    }
}

impl CamCoupling {
    /// Plans a command. `master` and `slave` are the present set values; the slave's are only used while
    /// it is not coupled.
    ///
    /// # Errors
    /// [`CouplingError`]. For a change that waits, a jump is found when it is due: its job is `Failed`
    /// then, and nothing has changed. Whether the slave could follow its new course is checked here, for
    /// a master as fast as now, and again when it is due.
    pub fn plan(
        &self,
        tables: &Tables,
        request: &CamRequest,
        master: &Kinematics,
        slave: &Kinematics,
    ) -> Result<CamChange, CouplingError> {
        // Before the error: uncoupling is the way out of it.
        if request.operation == CamOperation::Out {
            return match self.kind {
                None => Err(CouplingError::NotCoupled),
                Some(_) => Ok(CamChange(PlannedCamChange::End)),
            };
        }
        if let Some(error) = self.error {
            return Err(error);
        }
        let (inputs, axes) = (request.inputs, CouplingAxes { master, slave });
        let change = match request.operation {
            CamOperation::Out => PlannedCamChange::End,
            CamOperation::In(table) => {
                self.is_kind(CouplingKind::Single)?;
                self.plan_plate(tables, CouplingKind::Single, 0, table, inputs, axes)?
            }
            CamOperation::Scale => {
                let index = self.coupled_place(CouplingKind::Single, 0)?;
                self.plan_scaling(tables, index, inputs, master)?
            }
            CamOperation::InOfSeveral(operation, table, reference) => {
                self.is_kind(CouplingKind::Multi)?;
                match operation {
                    OperationMode::Default | OperationMode::Additive => {
                        self.plan_one_more(tables, table, inputs, axes)?
                    }
                    OperationMode::Exchange => {
                        self.plan_exchange(tables, table, reference, inputs, axes)?
                    }
                    OperationMode::Remove => self.plan_removal(tables, table, inputs, master)?,
                }
            }
            CamOperation::Add(table) => {
                self.coupled_as(CouplingKind::Multi)?;
                self.plan_one_more(tables, table, inputs, axes)?
            }
            CamOperation::Exchange(table, reference) => {
                self.plan_exchange(tables, table, reference, inputs, axes)?
            }
            CamOperation::Remove(table) => self.plan_removal(tables, table, inputs, master)?,
            CamOperation::ScaleOfSeveral(table) => {
                let index = self.coupled_place(CouplingKind::Multi, table)?;
                self.plan_scaling(tables, index, inputs, master)?
            }
        };
        Ok(CamChange(change))
    }

    fn plan_one_more(
        &self,
        tables: &Tables,
        table: TableId,
        inputs: CamInputs,
        axes: CouplingAxes<'_>,
    ) -> Result<PlannedCamChange, CouplingError> {
        self.is_new_here(table, None)?;
        // Empty of changes, too: a plate that waits for a place has taken it.
        let free = (0..MOST_PLATES)
            .find(|&index| self.layers[index].is_none() && self.queues[index].is_empty());
        let index = free.ok_or(CouplingError::TooManyTables { most: MOST_PLATES })?;
        self.plan_plate(tables, CouplingKind::Multi, index, table, inputs, axes)
    }

    fn plan_exchange(
        &self,
        tables: &Tables,
        table: TableId,
        reference: TableId,
        inputs: CamInputs,
        axes: CouplingAxes<'_>,
    ) -> Result<PlannedCamChange, CouplingError> {
        let index = self.coupled_place(CouplingKind::Multi, reference)?;
        self.is_new_here(table, Some(index))?;
        self.plan_plate(tables, CouplingKind::Multi, index, table, inputs, axes)
    }

    fn plan_removal(
        &self,
        tables: &Tables,
        table: TableId,
        inputs: CamInputs,
        master: &Kinematics,
    ) -> Result<PlannedCamChange, CouplingError> {
        // A plate that only waits can be named as well, though it is not coupled yet.
        if let Some(index) = self.place_to_come(table)
            && inputs.activation.mode == ActivationMode::DeleteQueuedData
        {
            return Ok(PlannedCamChange::DeleteQueued { index });
        }
        let index = self.coupled_place(CouplingKind::Multi, table)?;
        check_mode(Operation::Switch, inputs.activation.mode)?;
        if inputs.activation.mode == ActivationMode::DeleteQueuedData {
            return Ok(PlannedCamChange::DeleteQueued { index });
        }
        self.check_terms(tables, index, Operation::Switch, None, inputs, master)?;
        self.check_removal_early(tables, index, &inputs)?;
        Ok(PlannedCamChange::Plate {
            index,
            table: None,
            inputs,
            first: None,
        })
    }

    /// Plans a plate for a place: the first coupling, one more, or an exchange.
    fn plan_plate(
        &self,
        tables: &Tables,
        kind: CouplingKind,
        index: usize,
        table: TableId,
        inputs: CamInputs,
        axes: CouplingAxes<'_>,
    ) -> Result<PlannedCamChange, CouplingError> {
        // By the place and not by the command: `MC_CamIn` couples first, and exchanges after.
        let operation = match self.layers[index] {
            Some(_) => Operation::Switch,
            None => Operation::Couple,
        };
        let mode = inputs.activation.mode;
        check_mode(operation, mode)?;
        if mode == ActivationMode::DeleteQueuedData {
            return Ok(PlannedCamChange::DeleteQueued { index });
        }
        let table = tables.find(table)?;
        self.check_terms(tables, index, operation, Some(table), inputs, axes.master)?;
        let mut first = None;
        if self.kind.is_none() {
            if !is_finite(axes.master) || !is_finite(axes.slave) {
                return Err(CouplingError::AxisError { code: 0 });
            }
            let Kinematics {
                velocity,
                acceleration,
                ..
            } = *axes.slave;
            // While it waits the slave is held where it is, and a moving one would have to stop within a cycle.
            let moves = velocity != 0.0 || acceleration != 0.0;
            if mode != ActivationMode::Instantaneous && moves {
                return Err(CouplingError::SlaveMoving { velocity });
            }
            first = Some(CouplingBegin {
                kind,
                master: *axes.master,
                slave: *axes.slave,
            });
        }
        self.check_plate_early(tables, index, table, &inputs, first.as_ref())?;
        Ok(PlannedCamChange::Plate {
            index,
            table: Some(table),
            inputs,
            first,
        })
    }

    fn plan_scaling(
        &self,
        tables: &Tables,
        index: usize,
        inputs: CamInputs,
        master: &Kinematics,
    ) -> Result<PlannedCamChange, CouplingError> {
        check_mode(Operation::Scale, inputs.activation.mode)?;
        if inputs.activation.mode == ActivationMode::Off {
            return Ok(PlannedCamChange::Nothing);
        }
        self.check_terms(tables, index, Operation::Scale, None, inputs, master)?;
        self.check_scaling_early(tables, index, &inputs)?;
        Ok(PlannedCamChange::Scaling { index, inputs })
    }

    /// Checks of every change of a place. `table`: the plate to come, if there is one.
    fn check_terms(
        &self,
        tables: &Tables,
        index: usize,
        operation: Operation,
        table: Option<TableRef>,
        inputs: CamInputs,
        master: &Kinematics,
    ) -> Result<(), CouplingError> {
        let CamInputs {
            activation,
            scaling,
            jump,
        } = inputs;
        let layer = &self.layers[index];
        scaling.check(layer.is_some())?;
        jump.check()?;
        let (id, plate) = match (layer, table) {
            // Positions and cycles are those of the plate in place, since its seam is where the change happens.
            (Some(layer), _) => (layer.table.id, layer.plate(tables)?),
            (None, Some(table)) => (table.id, tables.versions(&table)?.plate()),
            (None, None) => return Err(CouplingError::NotCoupled),
        };
        let mode = activation.mode;
        // The origin would be the activation's position, which in turn would depend on the origin.
        if operation == Operation::Couple && mode.refers_to_plate() && scaling.master.relative {
            return Err(CouplingError::ModeNeedsAbsoluteMaster { mode });
        }
        // An exchange may also wait until the master leaves a linear plate.
        let has_next_cycle = operation == Operation::Switch || plate.course() == Course::Cyclic;
        check_activation(&activation, id, plate, has_next_cycle)?;
        // A master at standstill may still go either way: the product is 0 and passes.
        let ahead = (activation.position - master.position) * master.velocity;
        if mode == ActivationMode::AtMasterAxisPos && ahead < 0.0 {
            return Err(CouplingError::ActivationPassed {
                received: activation.position,
                master: master.position,
            });
        }
        let Queue {
            table,
            scaling,
            undo,
        } = &self.queues[index];
        let queued = match operation {
            Operation::Scale => scaling.is_some(),
            _ => table.is_some(),
        };
        // A place remembers one state to return to.
        if queued || undo.is_some() && mode == ActivationMode::NextCycleOnce {
            return Err(CouplingError::Pending { table: id });
        }
        Ok(())
    }

    fn is_kind(&self, kind: CouplingKind) -> Result<(), CouplingError> {
        match self.kind {
            Some(other) if other != kind => Err(CouplingError::OtherKindOfCoupling),
            _ => Ok(()),
        }
    }

    fn coupled_as(&self, kind: CouplingKind) -> Result<(), CouplingError> {
        self.is_kind(kind)?;
        self.kind.map(|_| ()).ok_or(CouplingError::NotCoupled)
    }

    /// Returns the place of an active plate; of the only one for 0.
    pub(super) fn coupled_place(
        &self,
        kind: CouplingKind,
        table: TableId,
    ) -> Result<usize, CouplingError> {
        self.coupled_as(kind)?;
        self.place_of(table)
    }

    /// Returns the place as [`Self::coupled_place`], for either kind of coupling.
    pub(super) fn place_of(&self, table: TableId) -> Result<usize, CouplingError> {
        let coupled = self.layers.iter().flatten().count();
        // 0 is no table's id: it names the only plate, and is refused below if there are several.
        let is_it = |id: TableId| table == 0 || id == table;
        let place = self
            .layers
            .iter()
            .position(|layer| layer.as_ref().is_some_and(|layer| is_it(layer.table.id)));
        match place {
            _ if coupled == 0 => Err(CouplingError::NotCoupled),
            _ if table == 0 && coupled > 1 => Err(CouplingError::Ambiguous { coupled }),
            Some(index) => Ok(index),
            None => Err(CouplingError::TableNotCoupled { table }),
        }
    }

    /// Returns the place a plate is queued for.
    fn place_to_come(&self, table: TableId) -> Option<usize> {
        let is_it = |pending: &Pending| pending.table.is_some_and(|t| t.id == table);
        self.queues
            .iter()
            .position(|queue| queue.table.as_ref().is_some_and(is_it))
    }

    /// Checks that a plate is not superposed twice, since it could not be identified any more. `except`:
    /// the place to replace.
    fn is_new_here(&self, table: TableId, except: Option<usize>) -> Result<(), CouplingError> {
        let is_it =
            |place: &Option<Layer>| place.as_ref().is_some_and(|layer| layer.table.id == table);
        let coupled = self
            .layers
            .iter()
            .position(is_it)
            .filter(|place| Some(*place) != except);
        let to_come = self
            .place_to_come(table)
            .filter(|place| Some(*place) != except);
        match coupled.or(to_come) {
            Some(_) => Err(CouplingError::TableCoupledAlready { table }),
            None => Ok(()),
        }
    }
}
