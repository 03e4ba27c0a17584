//! A table on its way into a store, or out of it.

use alloc::sync::Arc;

use super::versions::Versions;
use coaxle_plate::{CamError, Plate, PlateSource};

/// A table that was [reserved](super::Tables::reserve), by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReservedPlate(pub(super) usize);

/// A plate with all the room that it needs in a store, calculated beforehand: where a cycle takes it in, nothing is
/// allocated, and what it replaces comes back to be freed elsewhere.
#[derive(Debug)]
pub struct PreparedTable {
    pub(super) versions: Versions,
    /// What it was made of, to be read by others: those of its points that were written since are listed by the versions.
    pub(super) source: Arc<PlateSource>,
    /// Where it belongs when nobody needs it, if that is not with who brought it.
    pub(super) home: Option<ReservedPlate>,
}

impl PreparedTable {
    /// Calculates the plate. This allocates.
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

    /// A plate that is calculated already.
    pub(super) fn of(plate: Plate) -> Self {
        let source = Arc::new(plate.source());
        Self {
            versions: Versions::new(plate),
            source,
            home: None,
        }
    }

    /// How many points or rows it has.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.source.len()
    }
}
