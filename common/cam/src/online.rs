//! Activation of points that were written while the slave was on them.

use super::error::CouplingError;
use super::machine::CamCoupling;
use super::modes::ActivationMode;
use super::moment::{Moment, Step};
use super::placement::{Placed, Placement};
use super::tables::Tables;
use super::trigger::{due, next_cycle};
use super::versions::{Next, Versions};

impl CamCoupling {
    /// Applies a queued online change, or reverts it, when it is due. One that is not possible now stays
    /// queued.
    pub(super) fn take_data_if_due(
        &mut self,
        tables: &mut Tables,
        index: usize,
        step: Step,
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
            Next::GiveBack => next_cycle(&placed, step),
            Next::Take if mode.activation.mode == ActivationMode::AsSoonAsPossible => {
                safe_moment(versions, &placed, step)
            }
            Next::Take => due(&mode.activation, Some(&placed), step, false),
        };
        let Some(moment) = moment else {
            return Ok(());
        };
        let plate = match next {
            Next::Take => versions.changed_plate(),
            Next::GiveBack => versions.plate(),
        };
        let Placement {
            master_scaling,
            slave_scaling,
            ..
        } = layer.placement;
        let scaling = mode.scaling(master_scaling, slave_scaling);
        let placement = self.moved(tables, index, &scaling, placed, plate, &moment)?;
        let next_placed = Placed {
            placement: &placement,
            plate,
        };
        let ramp = self.moving(tables, index, next_placed, &mode.jump, &moment);
        // As soon as possible: another place is tried in the next cycle.
        let has_a_place = mode.activation.mode != ActivationMode::AsSoonAsPossible;
        if let Err(error) = ramp
            && has_a_place
            && self.held_back_writes != Some(tables.writes())
        {
            self.held_back_writes = Some(tables.writes());
            self.held_back = Some(error);
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
fn safe_moment(versions: &Versions, placed: &Placed<'_>, step: Step) -> Option<Moment> {
    let (start, end) = placed.plate.master_range();
    let changed = versions.changed();
    let master = placed.placement.on_plate(step.from);
    let (turn, _) = placed.placement.turns(placed.plate, step.from);
    let in_cycle = master - turn * placed.plate.period();
    if changed.start < in_cycle && in_cycle < changed.end {
        let all = changed.start <= start && end <= changed.end;
        return if all { next_cycle(placed, step) } else { None };
    }
    Some(Moment::at(step.from))
}
