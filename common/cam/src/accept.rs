//! Accepting a command: everything that can be refused before it is due.

use super::checks::{check_activation, check_mode};
use super::command::{Activation, CamIn, CamInV2, Command, ScalingData};
use super::error::{CouplingError, TableId};
use super::layer::{Layer, Pending, Queue, Ticket};
use super::machine::{CamCoupling, Kind, MOST_PLATES, is_finite};
use super::modes::{ActivationMode, JumpHandling, OperationMode};
use super::rules::Operation;
use super::tables::{TableRef, Tables};
use coaxle_axis::CommandState;
use coaxle_curve::profile::Kinematics;
use coaxle_plate::Course;

/// The inputs that all commands have.
#[derive(Clone, Copy)]
struct Terms {
    activation: Activation,
    scaling: ScalingData,
    jump: JumpHandling,
}

/// The axes' set values at the command.
#[derive(Clone, Copy)]
struct Axes<'a> {
    master: &'a Kinematics,
    slave: &'a Kinematics,
}

impl CamCoupling {
    pub(super) fn accept(
        &mut self,
        tables: &mut Tables,
        command: &Command,
        master: &Kinematics,
        slave: &Kinematics,
    ) -> Result<Ticket, CouplingError> {
        if let Command::CamOut = command {
            return self.cam_out(tables);
        }
        if let Some(error) = self.error {
            return Err(error);
        }
        let axes = Axes { master, slave };
        match command {
            Command::CamOut => self.cam_out(tables),
            Command::CamIn(c) => self.cam_in(tables, c, axes),
            Command::CamScaling(c) => {
                let index = self.coupled_place(Kind::Single, 0)?;
                let terms = terms(c.activation, c.scaling, c.jump);
                self.queue_scaling(tables, index, terms, master)
            }
            Command::CamInV2(c) => self.cam_in_v2(tables, c, axes),
            Command::CamAdd(c) => {
                self.coupled_as(Kind::Multi)?;
                let terms = terms(c.activation, c.scaling, c.jump);
                self.add(tables, c.table, terms, axes)
            }
            Command::CamExchange(c) => {
                let terms = terms(c.activation, c.scaling, c.jump);
                self.exchange(tables, c.table, c.reference, terms, axes)
            }
            Command::CamRemove(c) => {
                let terms = terms(c.activation, ScalingData::default(), c.jump);
                self.take_out(tables, c.table, terms, master)
            }
            Command::CamScalingV2(c) => {
                let index = self.coupled_place(Kind::Multi, c.table)?;
                let terms = terms(c.activation, c.scaling, c.jump);
                self.queue_scaling(tables, index, terms, master)
            }
        }
    }

    fn cam_in(
        &mut self,
        tables: &mut Tables,
        command: &CamIn,
        axes: Axes<'_>,
    ) -> Result<Ticket, CouplingError> {
        self.is_kind(Kind::Single)?;
        let terms = terms(command.activation, command.scaling(), command.jump);
        self.queue_plate(tables, Kind::Single, 0, command.table, terms, axes)
    }

    fn cam_in_v2(
        &mut self,
        tables: &mut Tables,
        command: &CamInV2,
        axes: Axes<'_>,
    ) -> Result<Ticket, CouplingError> {
        self.is_kind(Kind::Multi)?;
        let terms = terms(command.activation, command.scaling, command.jump);
        match command.operation {
            OperationMode::Default | OperationMode::Additive => {
                self.add(tables, command.table, terms, axes)
            }
            OperationMode::Exchange => {
                self.exchange(tables, command.table, command.reference, terms, axes)
            }
            OperationMode::Remove => self.take_out(tables, command.table, terms, axes.master),
        }
    }

    fn add(
        &mut self,
        tables: &mut Tables,
        table: TableId,
        terms: Terms,
        axes: Axes<'_>,
    ) -> Result<Ticket, CouplingError> {
        self.is_new_here(table, None)?;
        let free = (0..MOST_PLATES)
            .find(|&index| self.layers[index].is_none() && self.queues[index].is_empty());
        let index = free.ok_or(CouplingError::TooManyTables { most: MOST_PLATES })?;
        self.queue_plate(tables, Kind::Multi, index, table, terms, axes)
    }

    fn exchange(
        &mut self,
        tables: &mut Tables,
        table: TableId,
        reference: TableId,
        terms: Terms,
        axes: Axes<'_>,
    ) -> Result<Ticket, CouplingError> {
        let index = self.coupled_place(Kind::Multi, reference)?;
        self.is_new_here(table, Some(index))?;
        self.queue_plate(tables, Kind::Multi, index, table, terms, axes)
    }

    fn take_out(
        &mut self,
        tables: &mut Tables,
        table: TableId,
        terms: Terms,
        master: &Kinematics,
    ) -> Result<Ticket, CouplingError> {
        if let Some(index) = self.place_to_come(table)
            && terms.activation.mode == ActivationMode::DeleteQueuedData
        {
            return Ok(self.delete_queued(tables, index));
        }
        let index = self.coupled_place(Kind::Multi, table)?;
        check_mode(Operation::Switch, terms.activation.mode)?;
        if terms.activation.mode == ActivationMode::DeleteQueuedData {
            return Ok(self.delete_queued(tables, index));
        }
        self.check_terms(tables, index, Operation::Switch, None, terms, master)?;
        let ticket = self.new_ticket();
        self.queues[index].table = Some(pending(ticket, None, terms));
        self.has_queue = true;
        Ok(ticket)
    }

    /// A plate for a place: the first coupling, one more, or in the place of another.
    fn queue_plate(
        &mut self,
        tables: &mut Tables,
        kind: Kind,
        index: usize,
        table: TableId,
        terms: Terms,
        axes: Axes<'_>,
    ) -> Result<Ticket, CouplingError> {
        let operation = match self.layers[index] {
            Some(_) => Operation::Switch,
            None => Operation::Couple,
        };
        let mode = terms.activation.mode;
        check_mode(operation, mode)?;
        if mode == ActivationMode::DeleteQueuedData {
            return Ok(self.delete_queued(tables, index));
        }
        let table = tables.find(table)?;
        self.check_terms(tables, index, operation, Some(table), terms, axes.master)?;
        if self.kind.is_none() {
            if !is_finite(axes.master) || !is_finite(axes.slave) {
                return Err(CouplingError::AxisError { code: 0 });
            }
            let velocity = axes.slave.velocity;
            if mode != ActivationMode::Instantaneous && velocity != 0.0 {
                return Err(CouplingError::SlaveMoving { velocity });
            }
            self.kind = Some(kind);
            self.master = *axes.master;
            self.slave = *axes.slave;
        }
        tables.hold(&table);
        let ticket = self.new_ticket();
        self.queues[index].table = Some(pending(ticket, Some(table), terms));
        self.has_queue = true;
        Ok(ticket)
    }

    fn queue_scaling(
        &mut self,
        tables: &Tables,
        index: usize,
        terms: Terms,
        master: &Kinematics,
    ) -> Result<Ticket, CouplingError> {
        check_mode(Operation::Scale, terms.activation.mode)?;
        let off = terms.activation.mode == ActivationMode::Off;
        if !off {
            self.check_terms(tables, index, Operation::Scale, None, terms, master)?;
        }
        let ticket = self.new_ticket();
        if off {
            self.finish(ticket, CommandState::Done);
        } else {
            self.queues[index].scaling = Some(pending(ticket, None, terms));
            self.has_queue = true;
        }
        Ok(ticket)
    }

    /// What every change of a place has to fulfil. `table`: the plate to come, if one does.
    fn check_terms(
        &self,
        tables: &Tables,
        index: usize,
        operation: Operation,
        table: Option<TableRef>,
        terms: Terms,
        master: &Kinematics,
    ) -> Result<(), CouplingError> {
        let Terms {
            activation,
            scaling,
            jump,
        } = terms;
        let layer = &self.layers[index];
        scaling.check(layer.is_some())?;
        jump.check()?;
        let (id, plate) = match (layer, table) {
            (Some(layer), _) => (layer.table.id, layer.plate(tables)?),
            (None, Some(table)) => (table.id, tables.versions(&table)?.plate()),
            (None, None) => return Err(CouplingError::NotCoupled),
        };
        let mode = activation.mode;
        if operation == Operation::Couple && mode.refers_to_plate() && scaling.master.relative {
            return Err(CouplingError::ModeNeedsAbsoluteMaster { mode });
        }
        let has_next_cycle = operation == Operation::Switch || plate.course() == Course::Cyclic;
        check_activation(&activation, id, plate, has_next_cycle)?;
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
        if queued || undo.is_some() && mode == ActivationMode::NextCycleOnce {
            return Err(CouplingError::Pending { table: id });
        }
        Ok(())
    }

    fn is_kind(&self, kind: Kind) -> Result<(), CouplingError> {
        match self.kind {
            Some(other) if other != kind => Err(CouplingError::OtherKindOfCoupling),
            _ => Ok(()),
        }
    }

    fn coupled_as(&self, kind: Kind) -> Result<(), CouplingError> {
        self.is_kind(kind)?;
        self.kind.map(|_| ()).ok_or(CouplingError::NotCoupled)
    }

    /// The place of a plate that is active; of the only one for 0.
    pub(super) fn coupled_place(&self, kind: Kind, table: TableId) -> Result<usize, CouplingError> {
        self.coupled_as(kind)?;
        self.place_of(table)
    }

    /// As [`Self::coupled_place`], in either world.
    pub(super) fn place_of(&self, table: TableId) -> Result<usize, CouplingError> {
        let coupled = self.layers.iter().flatten().count();
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

    /// The place a plate is queued for.
    fn place_to_come(&self, table: TableId) -> Option<usize> {
        let is_it = |pending: &Pending| pending.table.is_some_and(|t| t.id == table);
        self.queues
            .iter()
            .position(|queue| queue.table.as_ref().is_some_and(is_it))
    }

    /// A plate superposed twice could not be named any more. `except`: the place that it takes.
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

fn terms(activation: Activation, scaling: ScalingData, jump: JumpHandling) -> Terms {
    Terms {
        activation,
        scaling,
        jump,
    }
}

fn pending(ticket: Ticket, table: Option<TableRef>, terms: Terms) -> Pending {
    Pending {
        ticket,
        table,
        activation: terms.activation,
        scaling: terms.scaling,
        jump: terms.jump,
        first: true,
    }
}
