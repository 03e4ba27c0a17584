//! Execution of changes that are due.

use super::change_moment::{ChangeMoment, MasterStep};
use super::command::ScalingData;
use super::coupling::{CamCoupling, MOST_PLATES};
use super::course_change::CourseChange;
use super::error::CouplingError;
use super::layer::{CouplingStart, Layer, Pending, Undo};
use super::modes::JumpHandling;
use super::placement::{PlacedPlate, Placement, PlacementContext};
use super::ramp::GapRamp;
use super::rules::Operation;
use super::tables::{TableRef, Tables};
use super::trigger::due;
use coaxle_axis::CommandState;
use coaxle_plate::{Cursor, Plate};

impl CamCoupling {
    /// Executes what is due in this step.
    ///
    /// A refused change, for example because of a jump, leaves everything unchanged and its command
    /// failed.
    pub(super) fn carry_out(
        &mut self,
        tables: &mut Tables,
        step: MasterStep,
    ) -> Result<(), CouplingError> {
        // Remembered, since a change below may take the last plate.
        let was_coupled = self.is_coupled();
        for index in 0..MOST_PLATES {
            // Points first: a scaling in the same cycle is then placed on the plate that will be in force.
            self.take_data_if_due(tables, index, step)?;
            self.scale_if_due(tables, index, step)?;
            self.place_if_due(tables, index, step)?;
            self.undo_if_due(tables, index, step)?;
        }
        self.has_queue = self.queues.iter().any(|queue| !queue.is_empty());
        // A coupling that still waits for its first plate stays. One whose only plate was refused has nothing left.
        if !self.is_coupled() && (was_coupled || !self.has_queue) {
            self.end(tables);
        }
        Ok(())
    }

    fn scale_if_due(
        &mut self,
        tables: &Tables,
        index: usize,
        step: MasterStep,
    ) -> Result<(), CouplingError> {
        let Some(pending) = self.queues[index].scaling else {
            return Ok(());
        };
        let moment = self.moment_of(tables, index, &pending, step)?;
        // Out of the queue before it is tried: a refused change must not be tried in every cycle.
        self.queues[index].scaling = moment.is_none().then_some(pending.checked());
        if let Some(moment) = moment
            && let Err(error) = self.scale(tables, index, &pending, &moment)
        {
            self.finish(pending.job, CommandState::Failed(error));
        }
        Ok(())
    }

    fn place_if_due(
        &mut self,
        tables: &mut Tables,
        index: usize,
        step: MasterStep,
    ) -> Result<(), CouplingError> {
        let Some(pending) = self.queues[index].table else {
            return Ok(());
        };
        let moment = self.moment_of(tables, index, &pending, step)?;
        self.queues[index].table = moment.is_none().then_some(pending.checked());
        let Some(moment) = moment else {
            return Ok(());
        };
        let placed = match pending.table {
            Some(table) => self.place(tables, index, &pending, table, &moment),
            None => self.remove(tables, index, &pending, &moment),
        };
        if let Err(error) = placed {
            if let Some(table) = pending.table {
                // Held since it was queued, and no place will hold it now.
                tables.release(&table);
            }
            self.finish(pending.job, CommandState::Failed(error));
        }
        Ok(())
    }

    /// Returns the moment at which a queued change takes effect. Positions on a plate are those of the
    /// plate in the place; without one, of the plate to come.
    fn moment_of(
        &self,
        tables: &Tables,
        index: usize,
        pending: &Pending,
        step: MasterStep,
    ) -> Result<Option<ChangeMoment>, CouplingError> {
        let due = |placed: Option<&PlacedPlate<'_>>| {
            due(&pending.activation, placed, step, pending.first)
        };
        Ok(match (&self.layers[index], pending.table) {
            (Some(layer), _) => due(Some(&layer.placed(tables)?)),
            (None, Some(table)) if pending.activation.mode.refers_to_plate() => {
                let plate = tables.versions(&table)?.plate();
                let context = PlacementContext {
                    // A first plate has no placement yet. Only absolute masters wait by its positions, so the
                    // moment has no influence.
                    moment: ChangeMoment::at(step.from),
                    before: None,
                    strokes: 0.0,
                    reference: 0.0,
                };
                let placement = Placement::settle(&pending.scaling, plate, &context);
                due(Some(&PlacedPlate {
                    placement: &placement,
                    plate,
                }))
            }
            (None, _) => due(None),
        })
    }

    /// Puts a plate into a place, a new one or that of another plate.
    fn place(
        &mut self,
        tables: &mut Tables,
        index: usize,
        pending: &Pending,
        table: TableRef,
        moment: &ChangeMoment,
    ) -> Result<(), CouplingError> {
        let (placement, ramp) = self.placement_after_placing(
            tables,
            index,
            (&pending.scaling, &pending.jump),
            table,
            moment,
        )?;
        // Before the layer changes: the position at which the slave came onto the plate.
        let slave = self.position_at(tables, moment)?;
        // Acquired before the previous plate is left: points that wait for its last slave would be in
        // force at once, and the placement was found for the points in force now.
        let lease = tables.acquire(&table)?;
        self.ramp = ramp;
        self.clear_for_another(tables, index);
        self.suspend_or_remove(tables, index, pending, moment);
        self.layers[index] = Some(Layer {
            table,
            lease,
            placement,
            cursor: Cursor::default(),
            owner: pending.job,
            start: CouplingStart {
                master: moment.master,
                slave,
                master_absolute: !pending.scaling.master.relative,
                slave_absolute: !pending.scaling.slave.relative,
            },
        });
        Ok(())
    }

    /// Returns the placement of another plate in a place, and the ramp onto it.
    pub(super) fn placement_after_placing(
        &self,
        tables: &Tables,
        index: usize,
        (scaling, jump): (&ScalingData, &JumpHandling),
        table: TableRef,
        moment: &ChangeMoment,
    ) -> Result<(Placement, Option<GapRamp>), CouplingError> {
        let before = self.layers[index];
        let reference = self.reference(tables, index, moment)?;
        let plate = tables.versions(&table)?.plate();
        let context = PlacementContext {
            moment: *moment,
            before: before
                .as_ref()
                .map(|layer| layer.placed(tables))
                .transpose()?,
            // Another plate begins in its base cycle: strokes belong to the plate that made them.
            strokes: 0.0,
            reference: reference.position,
        };
        let placement = Placement::settle(scaling, plate, &context);
        let next = PlacedPlate {
            placement: &placement,
            plate,
        };
        let ramp = self.bridge(
            tables,
            &CourseChange {
                moment,
                index,
                next: Some(next),
                gap: reference - placement.at(plate, moment.master),
                jump,
            },
        )?;
        Ok((placement, ramp))
    }

    /// Returns the ramp of a slave that continues without the plate in a place, which is not the last.
    pub(super) fn ramp_after_removal(
        &self,
        tables: &Tables,
        index: usize,
        jump: &JumpHandling,
        moment: &ChangeMoment,
    ) -> Result<Option<GapRamp>, CouplingError> {
        let course_change = CourseChange {
            moment,
            index,
            next: None,
            // The new course is the old one less this plate, so the gap is all of the plate.
            gap: self.reference(tables, index, moment)?,
            jump,
        };
        self.bridge(tables, &course_change)
    }

    fn remove(
        &mut self,
        tables: &mut Tables,
        index: usize,
        pending: &Pending,
        moment: &ChangeMoment,
    ) -> Result<(), CouplingError> {
        // The slave keeps its velocity then: there is no course left to lead it along a ramp.
        if self.is_last_plate() {
            // Without a plate nothing measures the cycle after which it would return.
            if pending.is_once() {
                return Err(CouplingError::ModeNotAllowed {
                    operation: Operation::Switch,
                    mode: pending.activation.mode,
                });
            }
            self.hand_over_slave(tables, moment)?;
        } else {
            self.ramp = self.ramp_after_removal(tables, index, &pending.jump, moment)?;
        }
        self.clear_for_another(tables, index);
        self.suspend_or_remove(tables, index, pending, moment);
        self.layers[index] = None;
        if !pending.is_once() {
            self.finish(pending.job, CommandState::Done);
        }
        Ok(())
    }

    fn scale(
        &mut self,
        tables: &Tables,
        index: usize,
        pending: &Pending,
        moment: &ChangeMoment,
    ) -> Result<(), CouplingError> {
        let before = self.layers[index].ok_or(CouplingError::NotCoupled)?;
        // A second return would bring back the state of the first change, not the one before it.
        if pending.is_once() && self.queues[index].undo.is_some() {
            return Err(CouplingError::Pending {
                table: before.table.id,
            });
        }
        let (placement, ramp) =
            self.placement_after_scaling(tables, index, &pending.scaling, &pending.jump, moment)?;
        self.ramp = ramp;
        if pending.is_once() {
            self.queues[index].undo = Some(Undo {
                job: pending.job,
                before: Some(before),
                strokes: 0.0,
                // The plate itself stays in use, so its return must not acquire it again.
                scaled_only: true,
                scaling: pending.scaling,
                jump: pending.jump,
                first: true,
            });
        } else {
            self.finish(pending.job, CommandState::Done);
        }
        self.layers[index] = Some(Layer {
            placement,
            ..before
        });
        Ok(())
    }

    /// Returns the placement of the present plate by `scaling`, and the ramp to it.
    pub(super) fn placement_after_scaling(
        &self,
        tables: &Tables,
        index: usize,
        scaling: &ScalingData,
        jump: &JumpHandling,
        moment: &ChangeMoment,
    ) -> Result<(Placement, Option<GapRamp>), CouplingError> {
        let layer = self.layers[index].ok_or(CouplingError::NotCoupled)?;
        let placed = layer.placed(tables)?;
        let placement =
            self.placement_after_move(tables, index, scaling, placed, placed.plate, moment)?;
        let next = PlacedPlate {
            placement: &placement,
            plate: placed.plate,
        };
        let ramp = self.ramp_after_move(tables, index, next, jump, moment)?;
        Ok((placement, ramp))
    }

    /// Returns the ramp of a slave whose plate in a place continues as `next`.
    pub(super) fn ramp_after_move(
        &self,
        tables: &Tables,
        index: usize,
        next: PlacedPlate<'_>,
        jump: &JumpHandling,
        moment: &ChangeMoment,
    ) -> Result<Option<GapRamp>, CouplingError> {
        let reference = self.reference(tables, index, moment)?;
        let course_change = CourseChange {
            moment,
            index,
            next: Some(next),
            gap: reference - next.placement.at(next.plate, moment.master),
            jump,
        };
        self.bridge(tables, &course_change)
    }

    /// Returns the placement of a plate that continues with another scaling, or as another version of
    /// itself, and keeps its strokes.
    pub(super) fn placement_after_move(
        &self,
        tables: &Tables,
        index: usize,
        scaling: &ScalingData,
        before: PlacedPlate<'_>,
        plate: &Plate,
        moment: &ChangeMoment,
    ) -> Result<Placement, CouplingError> {
        let context = PlacementContext {
            moment: *moment,
            before: Some(before),
            // Kept in units of the slave: the new scaling must not move cycles that are done.
            strokes: before.placement.strokes_at(before.plate, moment.master),
            reference: self.reference(tables, index, moment)?.position,
        };
        Ok(Placement::settle(scaling, plate, &context))
    }
}
