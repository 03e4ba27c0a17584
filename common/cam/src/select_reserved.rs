//! `MC_CamTableSelect` by a program, which has its tables from the start and cannot free memory.

use alloc::boxed::Box;
use alloc::sync::Arc;

use super::error::{CouplingError, TableId};
use super::prepared::{PreparedTable, ReservedPlate};
use super::reserve::ReservedTable;
use super::rules::MOST_POINTS_REPLACED_IN_USE;
use super::select::TableSelection;
use super::tables::{TableRef, Tables, check_id};
use coaxle_plate::PlateSource;

impl Tables {
    /// Reserves a table to be [selected](Self::select_reserved) under this number later. Allocates.
    ///
    /// # Errors
    /// 0x4B32 for an id outside 1 to 255, 0x4A11 for a motion function of more than 4096 points, and those of
    /// [`PlateSource::plate`].
    pub fn reserve(
        &mut self,
        id: TableId,
        source: Arc<PlateSource>,
    ) -> Result<ReservedPlate, CouplingError> {
        check_id(id)?;
        let original = PreparedTable::new(Arc::clone(&source))?;
        let points = original.versions.plate().function();
        let received = points.map_or(0, |function| function.points().len());
        // Its points are copied in the cycle whenever a slave is on the table, so their number is bounded from
        // the start.
        if received > MOST_POINTS_REPLACED_IN_USE {
            let room = MOST_POINTS_REPLACED_IN_USE;
            return Err(CouplingError::TooManyRows { received, room });
        }
        let reserved = ReservedPlate(self.reserve.kept.len());
        // Two copies: one is never in the store, so the points as reserved can be restored at any time.
        let mut available = Box::new(PreparedTable::new(source)?);
        available.home = Some(reserved);
        self.reserve.kept.push(ReservedTable {
            id,
            original,
            available: Some(available),
        });
        // Here, where allocating is allowed: returns in the cycle only push.
        self.reserve.make_room(self.slots.len());
        Ok(reserved)
    }

    /// `MC_CamTableSelect` of a reserved table, as [`Self::select`] of one that is passed in. Nothing is
    /// allocated or freed.
    ///
    /// # Errors
    /// As there; 0x4A11 for a table that was never reserved. Then everything is unchanged.
    pub fn select_reserved(
        &mut self,
        reserved: ReservedPlate,
        replace: bool,
    ) -> Result<(), CouplingError> {
        let selection = self.selection_of_reserved(reserved, replace)?;
        self.note_change();
        let Some(kept) = self.reserve.kept.get_mut(reserved.0) else {
            return Err(CouplingError::NoTable);
        };
        match selection {
            TableSelection::New => {
                let id = kept.id;
                let table = kept.available.take().ok_or(CouplingError::NoTable)?;
                self.put(id, table);
            }
            TableSelection::InPlaceOf(slot) => {
                // Before the reserved table is taken, so that a refusal leaves it where it is.
                let Some(place) = &mut self.slots[slot] else {
                    return Err(CouplingError::NoTable);
                };
                match kept.available.take() {
                    Some(new) => {
                        let old = core::mem::replace(&mut place.prepared, new);
                        self.reserve.return_or_queue(old);
                    }
                    // It is in the store itself, perhaps with other points.
                    None => place
                        .prepared
                        .versions
                        .restore(kept.original.versions.plate()),
                }
            }
            TableSelection::Online(slot) => {
                if let Some(place) = &mut self.slots[slot] {
                    let versions = &mut place.prepared.versions;
                    // Copied and not swapped, since the original must outlast any number of selections.
                    versions.replace_by_copy(kept.original.versions.plate());
                }
                self.note_write();
            }
        }
        Ok(())
    }

    /// Checks [`Self::select_reserved`] without applying it.
    ///
    /// # Errors
    /// As there.
    pub fn plan_select_reserved(
        &self,
        reserved: ReservedPlate,
        replace: bool,
    ) -> Result<(), CouplingError> {
        self.selection_of_reserved(reserved, replace).map(drop)
    }

    /// Removes a table from the store, as [`Self::delete`], for a caller that cannot free it.
    ///
    /// # Errors
    /// As there.
    pub fn put_away(&mut self, id: TableId) -> Result<(), CouplingError> {
        let TableRef { slot, .. } = self.find_unused(id)?;
        if let Some(table) = self.slots[slot].take() {
            self.reserve.return_or_queue(table.prepared);
        }
        self.note_change();
        Ok(())
    }

    fn selection_of_reserved(
        &self,
        ReservedPlate(n): ReservedPlate,
        replace: bool,
    ) -> Result<TableSelection, CouplingError> {
        let kept = self.reserve.kept.get(n).ok_or(CouplingError::NoTable)?;
        // Its memory was counted when it was reserved.
        self.selection_of(kept.id, replace, Some(&kept.original), usize::MAX)
    }
}
