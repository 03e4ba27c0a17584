//! Checks of a change that are possible before it is due.

use super::change_moment::ChangeMoment;
use super::coupling::CamCoupling;
use super::course_ahead::CourseAhead;
use super::error::CouplingError;
use super::modes::{ActivationMode, JumpHandling};
use super::placement::{PlacedPlate, Placement, PlacementContext};
use super::plan::CouplingBegin;
use super::request::CamInputs;
use super::tables::{TableRef, Tables};
use coaxle_plate::Plate;

impl CamCoupling {
    /// Checks another plate for a place: completely if it is activated at once. Otherwise it checks
    /// whether the slave could follow it, with the master then as fast as it is now.
    pub(super) fn check_plate_early(
        &self,
        tables: &Tables,
        index: usize,
        table: TableRef,
        inputs: &CamInputs,
        first: Option<&CouplingBegin>,
    ) -> Result<(), CouplingError> {
        // A plan changes nothing, so the axes at the command go into a copy. All of it is on the stack.
        let mut there = self.clone();
        if let Some(first) = first {
            (there.master, there.slave) = (first.master, first.slave);
        }
        // A later change finds a slave that is elsewhere, so only what no place can change is checked now.
        let Some(now) = there.moment_of_inputs(inputs) else {
            let plate = tables.versions(&table)?.plate();
            return there.check_alone_early(tables, index, Some(plate), inputs);
        };
        there
            .placement_after_placing(tables, index, (&inputs.scaling, &inputs.jump), table, &now)
            .map(|_| ())
    }

    /// Checks a plate that is scaled, as `check_plate_early`.
    pub(super) fn check_scaling_early(
        &self,
        tables: &Tables,
        index: usize,
        inputs: &CamInputs,
    ) -> Result<(), CouplingError> {
        match self.moment_of_inputs(inputs) {
            None => self.check_alone_early(tables, index, None, inputs),
            Some(now) => self
                .placement_after_scaling(tables, index, &inputs.scaling, &inputs.jump, &now)
                .map(|_| ()),
        }
    }

    /// Checks a plate that is removed, as `check_plate_early`.
    pub(super) fn check_removal_early(
        &self,
        tables: &Tables,
        index: usize,
        inputs: &CamInputs,
    ) -> Result<(), CouplingError> {
        match self.moment_of_inputs(inputs) {
            // Without its last plate the slave keeps its velocity: there is no course to check.
            Some(now) if !self.is_last_plate() => self
                .ramp_after_removal(tables, index, &inputs.jump, &now)
                .map(|_| ()),
            _ => Ok(()),
        }
    }

    /// Returns the present moment, for a change that comes with the next cycle, before any other.
    fn moment_of_inputs(&self, inputs: &CamInputs) -> Option<ChangeMoment> {
        let at_once = inputs.activation.mode == ActivationMode::Instantaneous;
        // Another change that is queued may come first, and change what this one begins from.
        (at_once && !self.has_queue).then(|| ChangeMoment::at(self.master.position))
    }

    /// Checks the only plate of a slave by itself: its placement when it is due only shifts it.
    fn check_alone_early(
        &self,
        tables: &Tables,
        index: usize,
        other: Option<&Plate>,
        inputs: &CamInputs,
    ) -> Result<(), CouplingError> {
        // Beside other plates the sum depends on the place, which is not known yet.
        let is_only = self.layers.iter().flatten().count() <= 1;
        if inputs.jump == JumpHandling::Allow || !is_only || self.has_queue {
            return Ok(());
        }
        let moment = ChangeMoment::at(self.master.position);
        let layer = self.layers[index].as_ref();
        let before = layer.map(|layer| layer.placed(tables)).transpose()?;
        let Some(plate) = other.or(before.map(|before| before.plate)) else {
            return Ok(());
        };
        let context = PlacementContext {
            moment,
            before,
            // Strokes and offsets shift the course, and so leave slope and curvature as they are.
            strokes: 0.0,
            reference: self.slave.position,
        };
        let placement = Placement::settle(&inputs.scaling, plate, &context);
        let next = Some(PlacedPlate {
            placement: &placement,
            plate,
        });
        let course = CourseAhead {
            coupling: self,
            tables,
            index,
            next,
            ramp: None,
        };
        course.check(&self.master, &self.parameters.limits)
    }
}
