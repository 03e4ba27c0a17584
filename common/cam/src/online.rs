//! Activation of points that were written while the slave was on them.

use super::change_moment::{ChangeMoment, MasterStep};
use super::coupling::CamCoupling;
use super::error::CouplingError;
use super::modes::ActivationMode;
use super::placement::{PlacedPlate, Placement};
use super::tables::Tables;
use super::trigger::{due, next_cycle};
use super::versions::{LeaseAction, Versions};

impl CamCoupling {
    /// Applies a queued online change, or reverts it, when it is due. One that is not possible now stays
    /// queued.
    pub(super) fn take_data_if_due(
        &mut self,
        tables: &mut Tables,
        index: usize,
        step: MasterStep,
    ) -> Result<(), CouplingError> {
        let Some(layer) = self.layers[index] else {
            return Ok(());
        };
        let versions = tables.versions(&layer.table)?;
        let Some((next, mode)) = versions.next_of(&layer.lease) else {
            return Ok(());
        };
        let placed = layer.placed(tables)?;
        let moment = match next {
            // A change for one cycle ends with it, whatever began it.
            LeaseAction::GiveBack => next_cycle(&placed, step),
            LeaseAction::Take if mode.activation.mode == ActivationMode::AsSoonAsPossible => {
                safe_moment(versions, &placed, step)
            }
            // A master that only stands on the position does not count: no command begins here.
            LeaseAction::Take => due(&mode.activation, Some(&placed), step, false),
        };
        let Some(moment) = moment else {
            return Ok(());
        };
        let plate = match next {
            LeaseAction::Take => versions.changed_plate(),
            LeaseAction::GiveBack => versions.plate(),
        };
        let Placement {
            master_scaling,
            slave_scaling,
            ..
        } = layer.placement;
        let scaling = mode.scaling(master_scaling, slave_scaling);
        let placement =
            self.placement_after_move(tables, index, &scaling, placed, plate, &moment)?;
        let next_placed = PlacedPlate {
            placement: &placement,
            plate,
        };
        let ramp = self.ramp_after_move(tables, index, next_placed, &mode.jump, &moment);
        // As soon as possible: another place is tried in the next cycle.
        let has_a_place = mode.activation.mode != ActivationMode::AsSoonAsPossible;
        if let Err(error) = ramp
            && has_a_place
            // Tried again in each turn, and refused each time: one report for each write is enough.
            && self.rejected_points_writes != Some(tables.writes())
        {
            self.rejected_points_writes = Some(tables.writes());
            self.rejected_points = Some(error);
        }
        if let Ok(ramp) = ramp
            && let (Some(layer), Some(versions)) =
                (&mut self.layers[index], tables.versions_mut(&layer.table))
        {
            self.ramp = ramp;
            versions.advance(&mut layer.lease, next);
            layer.placement = placement;
        }
        Ok(())
    }
}

/// Returns the present moment, unless the slave is in a segment that changes. If every segment does, the
/// seam of the cycles.
fn safe_moment(
    versions: &Versions,
    placed: &PlacedPlate<'_>,
    step: MasterStep,
) -> Option<ChangeMoment> {
    let (start, end) = placed.plate.master_range();
    let changed = versions.changed();
    let master = placed.placement.on_plate(step.from);
    let (turn, _) = placed.placement.turns(placed.plate, step.from);
    let in_cycle = master - turn * placed.plate.period();
    // At either edge the segment beside it stays, so the slave is on both courses there.
    if changed.start < in_cycle && in_cycle < changed.end {
        // Otherwise a change of every segment would never find a safe place.
        let all = changed.start <= start && end <= changed.end;
        return if all { next_cycle(placed, step) } else { None };
    }
    Some(ChangeMoment::at(step.from))
}
