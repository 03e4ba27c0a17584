//! A table on its way into a store, or out of it.

use alloc::sync::Arc;

use super::versions::Versions;
use coaxle_plate::{CamError, Plate, PlateSource};

/// A table that was [reserved](super::Tables::reserve), by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReservedPlate(pub(super) usize);

/// A plate with all the memory that it needs in a store, calculated beforehand. When a cycle inserts it,
/// nothing is allocated, and the plate that it replaces is returned to be freed elsewhere.
#[derive(Debug)]
pub struct PreparedTable {
    pub(super) versions: Versions,
    /// Source of the plate, for readers. The points written since are listed by the versions.
    pub(super) source: Arc<PlateSource>,
    /// Place to return to when it is not in use; none if it returns to the order that brought it.
    pub(super) home: Option<ReservedPlate>,
}

impl PreparedTable {
    /// Calculates the plate. Allocates.
    ///
    /// # Errors
    /// As [`PlateSource::plate`].
    pub fn new(source: Arc<PlateSource>) -> Result<Self, CamError> {
        let plate = source.plate()?;
        Ok(Self {
            versions: Versions::new(plate),
            source,
            home: None,
        })
    }

    /// Takes a plate that is calculated already.
    pub(super) fn of(plate: Plate) -> Self {
        // Shared with readers, so that a reading in the cycle copies a pointer and no points.
        let source = Arc::new(plate.source());
        Self {
            versions: Versions::new(plate),
            source,
            home: None,
        }
    }

    /// Returns the number of its points or rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.source.len()
    }
}
