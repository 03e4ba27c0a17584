//! Checks of a change that are possible before it is due.

use super::course::Course;
use super::error::CouplingError;
use super::machine::CamCoupling;
use super::modes::{ActivationMode, JumpHandling};
use super::moment::Moment;
use super::placement::{Placed, Placement, Situation};
use super::plan::First;
use super::request::Terms;
use super::tables::{TableRef, Tables};
use coaxle_plate::Plate;

impl CamCoupling {
    /// Checks another plate for a place: completely if it is activated at once. Otherwise it checks
    /// whether the slave could follow it, with the master then as fast as it is now.
    pub(super) fn foresee_plate(
        &self,
        tables: &Tables,
        index: usize,
        table: TableRef,
        terms: &Terms,
        first: Option<&First>,
    ) -> Result<(), CouplingError> {
        let mut there = self.clone();
        if let Some(first) = first {
            (there.master, there.slave) = (first.master, first.slave);
        }
        let Some(now) = there.moment_of_terms(terms) else {
            let plate = tables.versions(&table)?.plate();
            return there.foresee_alone(tables, index, Some(plate), terms);
        };
        there
            .placing(tables, index, (&terms.scaling, &terms.jump), table, &now)
            .map(|_| ())
    }

    /// Checks a plate that is scaled, as `foresee_plate`.
    pub(super) fn foresee_scaling(
        &self,
        tables: &Tables,
        index: usize,
        terms: &Terms,
    ) -> Result<(), CouplingError> {
        match self.moment_of_terms(terms) {
            None => self.foresee_alone(tables, index, None, terms),
            Some(now) => self
                .scaled(tables, index, &terms.scaling, &terms.jump, &now)
                .map(|_| ()),
        }
    }

    /// Checks a plate that is removed, as `foresee_plate`.
    pub(super) fn foresee_removal(
        &self,
        tables: &Tables,
        index: usize,
        terms: &Terms,
    ) -> Result<(), CouplingError> {
        match self.moment_of_terms(terms) {
            Some(now) if !self.is_last_plate() => {
                self.removing(tables, index, &terms.jump, &now).map(|_| ())
            }
            _ => Ok(()),
        }
    }

    /// Returns the present moment, for a change that comes with the next cycle, before any other.
    fn moment_of_terms(&self, terms: &Terms) -> Option<Moment> {
        let at_once = terms.activation.mode == ActivationMode::Instantaneous;
        (at_once && !self.has_queue).then(|| Moment::at(self.master.position))
    }

    /// Checks the only plate of a slave by itself: its placement when it is due only shifts it.
    fn foresee_alone(
        &self,
        tables: &Tables,
        index: usize,
        other: Option<&Plate>,
        terms: &Terms,
    ) -> Result<(), CouplingError> {
        let is_only = self.layers.iter().flatten().count() <= 1;
        if terms.jump == JumpHandling::Allow || !is_only || self.has_queue {
            return Ok(());
        }
        let moment = Moment::at(self.master.position);
        let layer = self.layers[index].as_ref();
        let before = layer.map(|layer| layer.placed(tables)).transpose()?;
        let Some(plate) = other.or(before.map(|before| before.plate)) else {
            return Ok(());
        };
        let situation = Situation {
            moment,
            before,
            strokes: 0.0,
            reference: self.slave.position,
        };
        let placement = Placement::settle(&terms.scaling, plate, &situation);
        let next = Some(Placed {
            placement: &placement,
            plate,
        });
        let course = Course {
            coupling: self,
            tables,
            index,
            next,
            ramp: None,
        };
        course.check(&self.master, &self.parameters.limits)
    }
}
