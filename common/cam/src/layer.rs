//! One plate of a coupling, and what waits to happen to it.

use super::command::{Activation, ScalingData};
use super::error::CouplingError;
use super::modes::{ActivationMode, JumpHandling};
use super::placement::{Path, Placed, Placement};
use super::tables::{TableRef, Tables};
use super::versions::Lease;
use coaxle_axis::Job;
use coaxle_plate::{Cursor, Plate};

/// A plate that moves the slave.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer {
    pub(super) table: TableRef,
    pub(super) lease: Lease,
    pub(super) placement: Placement,
    pub(super) cursor: Cursor,
    /// Whose plate it is.
    pub(super) owner: Job,
    pub(super) start: CouplingStart,
}

/// How a plate became active.
#[derive(Clone, Copy, Debug)]
pub(super) struct CouplingStart {
    /// Where the axes were, u.
    pub(super) master: f64,
    pub(super) slave: f64,
    pub(super) master_absolute: bool,
    pub(super) slave_absolute: bool,
}

impl Layer {
    #[inline]
    pub(super) fn plate<'a>(&self, tables: &'a Tables) -> Result<&'a Plate, CouplingError> {
        Ok(tables.versions(&self.table)?.plate_of(&self.lease))
    }

    pub(super) fn placed<'a>(&'a self, tables: &'a Tables) -> Result<Placed<'a>, CouplingError> {
        Ok(Placed {
            placement: &self.placement,
            plate: self.plate(tables)?,
        })
    }

    pub(super) fn path_at(&self, tables: &Tables, master: f64) -> Result<Path, CouplingError> {
        Ok(self.placement.at(self.plate(tables)?, master))
    }

    /// The same for the next cycle, quicker.
    #[inline]
    pub(super) fn path_along(
        &mut self,
        tables: &Tables,
        master: f64,
    ) -> Result<Path, CouplingError> {
        let plate = self.plate(tables)?;
        let motion = plate.along(&mut self.cursor, self.placement.on_plate(master));
        Ok(self.placement.path(&motion))
    }
}

/// What waits for its moment in one of a coupling's places.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Queue {
    /// A plate to come or go.
    pub(super) table: Option<Pending>,
    /// A scaling of the plate that is there.
    pub(super) scaling: Option<Pending>,
    /// The end of a change for one cycle.
    pub(super) undo: Option<Undo>,
}

impl Pending {
    pub(super) const fn is_once(&self) -> bool {
        matches!(self.activation.mode, ActivationMode::NextCycleOnce)
    }

    /// The same, no longer new.
    pub(super) const fn looked_at(self) -> Self {
        Self {
            first: false,
            ..self
        }
    }
}

impl Queue {
    pub(super) const fn is_empty(&self) -> bool {
        self.table.is_none() && self.scaling.is_none() && self.undo.is_none()
    }
}

/// A change that is queued.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    pub(super) job: Job,
    /// The plate to come. None: the plate that is there goes, or is scaled.
    pub(super) table: Option<TableRef>,
    pub(super) activation: Activation,
    pub(super) scaling: ScalingData,
    pub(super) jump: JumpHandling,
    /// Not looked at yet.
    pub(super) first: bool,
}

/// How to return to what was before a change for one cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Undo {
    /// Who changed it.
    pub(super) job: Job,
    /// The plate as it was, if there was one. Its table is held meanwhile.
    pub(super) before: Option<Layer>,
    /// The strokes it had done when it left, u.
    pub(super) strokes: f64,
    pub(super) scaled_only: bool,
    /// The modes of the change; they hold for the return too.
    pub(super) scaling: ScalingData,
    pub(super) jump: JumpHandling,
    /// In force since this cycle only.
    pub(super) first: bool,
}
