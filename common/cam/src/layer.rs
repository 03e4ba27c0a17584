//! A plate of a coupling, and its queued changes.

use super::command::{Activation, ScalingData};
use super::error::CouplingError;
use super::modes::{ActivationMode, JumpHandling};
use super::placement::{Path, PlacedPlate, Placement};
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
    /// Job that owns the plate.
    pub(super) owner: Job,
    pub(super) start: CouplingStart,
}

/// Activation of a plate.
#[derive(Clone, Copy, Debug)]
pub(super) struct CouplingStart {
    /// Positions of the axes, u.
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

    pub(super) fn placed<'a>(
        &'a self,
        tables: &'a Tables,
    ) -> Result<PlacedPlate<'a>, CouplingError> {
        Ok(PlacedPlate {
            placement: &self.placement,
            plate: self.plate(tables)?,
        })
    }

    pub(super) fn path_at(&self, tables: &Tables, master: f64) -> Result<Path, CouplingError> {
        Ok(self.placement.at(self.plate(tables)?, master))
    }

    /// Returns the path at the next cycle's master, faster than `path_at`.
    #[inline]
    pub(super) fn path_along(
        &mut self,
        tables: &Tables,
        master: f64,
    ) -> Result<Path, CouplingError> {
        let plate = self.plate(tables)?;
        // Equal to `path_at` bit by bit: the cursor only saves the search for the segment.
        let motion = plate.along(&mut self.cursor, self.placement.on_plate(master));
        Ok(self.placement.path(&motion))
    }
}

/// Queued changes in one of a coupling's places.
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

    /// Returns the change, no longer new.
    pub(super) const fn checked(self) -> Self {
        Self {
            // After its first check a master that stands on the position no longer counts as passing it.
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
    /// Plate to come. None: the present plate is removed or scaled.
    pub(super) table: Option<TableRef>,
    pub(super) activation: Activation,
    pub(super) scaling: ScalingData,
    pub(super) jump: JumpHandling,
    /// True before its first check.
    pub(super) first: bool,
}

/// State to return to after a change for one cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Undo {
    /// Job of the change.
    pub(super) job: Job,
    /// The plate before it, if there was one. Its table is held meanwhile.
    pub(super) before: Option<Layer>,
    /// Strokes of that plate when it was left, u.
    pub(super) strokes: f64,
    pub(super) scaled_only: bool,
    /// The modes of the change; they hold for the return too.
    pub(super) scaling: ScalingData,
    pub(super) jump: JumpHandling,
    /// True in the cycle in which the change came into force.
    pub(super) first: bool,
}
