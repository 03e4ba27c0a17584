//! Changes for one cycle, and the return from them.

use super::change_moment::{ChangeMoment, MasterStep};
use super::command::{AxisScaling, ScalingData};
use super::coupling::CamCoupling;
use super::error::CouplingError;
use super::layer::{Layer, Pending, Undo};
use super::modes::ScalingMode;
use super::placement::{Path, PlacedPlate, Placement, PlacementContext};
use super::tables::Tables;
use super::trigger::next_cycle;
use coaxle_axis::CommandState;

impl CamCoupling {
    /// Removes the plate in a place: for one cycle, or for good.
    pub(super) fn suspend_or_remove(
        &mut self,
        tables: &mut Tables,
        index: usize,
        pending: &Pending,
        moment: &ChangeMoment,
    ) {
        let before = self.layers[index];
        let mut strokes = 0.0;
        if let Some(layer) = &before {
            if let Ok(plate) = layer.plate(tables) {
                strokes = layer.placement.strokes_at(plate, moment.master);
            }
            // A plate that returns stays held, so that nobody deletes it, but points written to it need not
            // wait for it.
            tables.leave(&layer.table, &layer.lease);
            if !pending.is_once() {
                tables.release(&layer.table);
                self.finish(layer.owner, CommandState::Aborted);
            }
        }
        if pending.is_once() {
            self.queues[index].undo = Some(Undo {
                job: pending.job,
                before,
                strokes,
                scaled_only: false,
                scaling: pending.scaling,
                jump: pending.jump,
                first: true,
            });
        }
    }

    /// Ends a change for one cycle, if due.
    pub(super) fn undo_if_due(
        &mut self,
        tables: &mut Tables,
        index: usize,
        step: MasterStep,
    ) -> Result<(), CouplingError> {
        let Some(undo) = &mut self.queues[index].undo else {
            return Ok(());
        };
        // The seam at which the change came into force lies in the same step, and would end it at once.
        if core::mem::take(&mut undo.first) {
            return Ok(());
        }
        let undo = *undo;
        // The cycle of a plate that is taken out for one cycle sets the duration.
        let Some(layer) = self.layers[index].or(undo.before) else {
            return Ok(());
        };
        let Some(moment) = next_cycle(&layer.placed(tables)?, step) else {
            return Ok(());
        };
        // Taken before it is tried, as any change: a return that is refused is not repeated.
        self.queues[index].undo = None;
        let undone = if undo.scaled_only {
            self.undo_scaling(tables, index, &undo, &moment)
        } else {
            self.undo_place(tables, index, &undo, &moment)
        };
        let state = match undone {
            Ok(()) => CommandState::Done,
            Err(error) => {
                // The plate that was to return is let go, otherwise it could never be deleted.
                self.forget(tables, &undo);
                CommandState::Failed(error)
            }
        };
        self.finish(undo.job, state);
        Ok(())
    }

    fn undo_scaling(
        &mut self,
        tables: &mut Tables,
        index: usize,
        undo: &Undo,
        moment: &ChangeMoment,
    ) -> Result<(), CouplingError> {
        let before = undo.before.ok_or(CouplingError::NotCoupled)?.placement;
        let scaling = scaling_back(&undo.scaling, &before);
        let (placement, ramp) =
            self.placement_after_scaling(tables, index, &scaling, &undo.jump, moment)?;
        self.ramp = ramp;
        if let Some(layer) = &mut self.layers[index] {
            layer.placement = placement;
        }
        Ok(())
    }

    fn undo_place(
        &mut self,
        tables: &mut Tables,
        index: usize,
        undo: &Undo,
        moment: &ChangeMoment,
    ) -> Result<(), CouplingError> {
        let reference = self.reference(tables, index, moment)?;
        let placement = match &undo.before {
            Some(layer) => Some(self.returned(tables, index, undo, layer, reference, moment)?),
            None => None,
        };
        if let (Some(layer), Some(placement)) = (&undo.before, &placement) {
            let plate = tables.versions(&layer.table)?.plate();
            let next = PlacedPlate { placement, plate };
            self.ramp = self.ramp_after_move(tables, index, next, &undo.jump, moment)?;
        } else if self.is_last_plate() {
            self.hand_over_slave(tables, moment)?;
        } else {
            self.ramp = self.ramp_after_removal(tables, index, &undo.jump, moment)?;
        }
        // As for a new plate: acquired before the previous one is left.
        let lease = match &undo.before {
            Some(layer) => Some(tables.acquire(&layer.table)?),
            None => None,
        };
        // A scaling that waits was meant for the plate that leaves now.
        self.abort_scaling(index);
        if let Some(layer) = self.layers[index].take() {
            tables.leave(&layer.table, &layer.lease);
            tables.release(&layer.table);
        }
        if let (Some(layer), Some(placement), Some(lease)) = (undo.before, placement, lease) {
            self.layers[index] = Some(Layer {
                lease,
                placement,
                ..layer
            });
        }
        Ok(())
    }

    /// Returns the placement of a plate that returns: as before, except for automatic values.
    fn returned(
        &self,
        tables: &Tables,
        index: usize,
        undo: &Undo,
        layer: &Layer,
        reference: Path,
        moment: &ChangeMoment,
    ) -> Result<Placement, CouplingError> {
        let plate = tables.versions(&layer.table)?.plate();
        let mut placement = layer.placement;
        if undo.scaling.master.mode == ScalingMode::AutoOffset
            && let Some(present) = &self.layers[index]
        {
            let context = PlacementContext {
                moment: *moment,
                before: Some(present.placed(tables)?),
                strokes: undo.strokes,
                reference: reference.position,
            };
            placement =
                Placement::settle(&scaling_back(&undo.scaling, &placement), plate, &context);
        }
        // Absolute placements return to where they were. Automatic ones go through the slave's present position.
        if undo.scaling.slave.mode == ScalingMode::AutoOffset {
            placement = placement.through(plate, moment.master, reference.position);
        }
        Ok(placement)
    }
}

/// Offsets and scalings before a change, with the modes of the change that is undone.
fn scaling_back(scaling: &ScalingData, before: &Placement) -> ScalingData {
    let axis = |mode, offset, scaling| AxisScaling {
        mode,
        // The offsets of a placement are totals, with the origin of a relative one in them.
        relative: false,
        offset,
        scaling,
    };
    ScalingData {
        master: axis(
            scaling.master.mode,
            before.master_offset,
            before.master_scaling,
        ),
        slave: axis(
            scaling.slave.mode,
            before.slave_offset,
            before.slave_scaling,
        ),
    }
}
