//! A plate on its way to a reader outside of the cycle.

use alloc::sync::Arc;
use alloc::vec::Vec;

use super::error::{CouplingError, TableId};
use super::tables::Tables;
use coaxle_plate::{MotionPoint, PlateSource};

/// Greatest number of points that may have been written since a table was selected, for it still to be
/// read.
// Copied in the cycle, so their number is bounded. Equal to the most points of a plate replaced in use.
pub const MOST_POINTS_CHANGED: usize = 4096;

/// A plate in force, taken out of a cycle without calculating anything: its source, shared, and the
/// points written since. [`PlateSource::plate`] of it returns the complete plate.
#[derive(Debug)]
pub struct PlateReading {
    source: Option<Arc<PlateSource>>,
    changed: Vec<MotionPoint>,
}

impl Default for PlateReading {
    /// Allocates the memory for the points.
    fn default() -> Self {
        Self {
            source: None,
            changed: Vec::with_capacity(MOST_POINTS_CHANGED),
        }
    }
}

impl PlateReading {
    /// Returns the source of the plate; none before it was read.
    #[must_use]
    pub fn source(&self) -> Option<PlateSource> {
        let source = self.source.as_ref()?;
        Some(source.with_points(&self.changed))
    }
}

impl Tables {
    /// Reads a plate in force for a reader outside of the cycle. Nothing is allocated.
    ///
    /// # Errors
    /// 0x4216 for an unknown table, 0x4B31 if more points were written than can be read.
    pub fn read_plate(&self, id: TableId, into: &mut PlateReading) -> Result<(), CouplingError> {
        let table = &self.get(&self.find(id)?)?.prepared;
        let touched = table.versions.touched();
        let most = MOST_POINTS_CHANGED.min(into.changed.capacity());
        // Refused before the copy: the list has no room for more, and growing it would allocate in the cycle.
        if touched.len() > most {
            return Err(CouplingError::TooManyChanged {
                table: id,
                changed: touched.len(),
                most,
            });
        }
        into.changed.clear();
        if let Some(function) = table.versions.plate().function() {
            for index in touched {
                into.changed.push(*function.point(*index)?);
            }
        }
        // Only a counter rises. The previous source is freed by its last holder.
        into.source = Some(Arc::clone(&table.source));
        Ok(())
    }
}
