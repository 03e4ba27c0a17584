//! `MC_CamTableSelect` while the axis runs: tables are inserted and removed as a whole, and nothing is
//! allocated or freed.

use alloc::boxed::Box;

use super::error::{CouplingError, TableId};
use super::modes::ActivationMode;
use super::prepared::PreparedTable;
use super::rules::{MOST_POINTS_REPLACED_IN_USE, Operation};
use super::tables::{StoredTable, TableRef, Tables, check_id};

/// Kind of selection of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TableSelection {
    /// A new number.
    New,
    /// Replacement of a table without slaves.
    InPlaceOf(usize),
    /// Replacement of a table with slaves: its points change by the mode of the table.
    Online(usize),
}

impl Tables {
    /// `MC_CamTableSelect`: inserts a table. With `replace` it may replace the table of that id: at once
    /// if no slave is on it; else as an [online change](Self::write) of all its points, which needs
    /// motion functions with equal numbers of points and equal courses. On return, `table` holds what was
    /// replaced, or another table that is no longer needed, to be freed outside of the cycle.
    ///
    /// # Errors
    /// 0x4B32 for an id outside 1 to 255, 0x4A11 without a table, if the store is full, or for more than
    /// `room` rows, 0x4063 if there is a table of that id and it is not to be replaced, 0x4259 if it is
    /// in use and no online change is possible, 0x4283 if the table takes no changes, 0x4287 if a
    /// previous change is in force for some slaves but not for all. Then everything is unchanged.
    #[doc(alias = "MC_CamTableSelect")]
    pub fn select(
        &mut self,
        id: TableId,
        replace: bool,
        table: &mut Option<Box<PreparedTable>>,
        room: usize,
    ) -> Result<(), CouplingError> {
        let selection = self.selection_of(id, replace, table.as_deref(), room)?;
        self.note_change();
        let Some(mut new) = table.take() else {
            return Err(CouplingError::NoTable);
        };
        match selection {
            TableSelection::New => {
                self.put(id, new);
                // The caller can free one table, and this one went in: so it takes one along that waits to be freed.
                *table = self.reserve.take_out();
            }
            TableSelection::InPlaceOf(slot) => {
                if let Some(place) = &mut self.slots[slot] {
                    // Boxes are swapped, so the cost does not grow with the plate.
                    core::mem::swap(&mut place.prepared, &mut new);
                }
                *table = self.reserve.exchange(new);
            }
            TableSelection::Online(slot) => {
                self.note_write();
                if let Some(place) = &mut self.slots[slot] {
                    // The table in use stays where it is, since leases of slaves count on its versions.
                    place.prepared.versions.replace(&mut new.versions);
                }
                *table = Some(new);
            }
        }
        Ok(())
    }

    /// Checks [`Self::select`] without applying it.
    ///
    /// # Errors
    /// As there.
    pub fn plan_select(
        &self,
        id: TableId,
        replace: bool,
        table: Option<&PreparedTable>,
        room: usize,
    ) -> Result<(), CouplingError> {
        self.selection_of(id, replace, table, room).map(drop)
    }

    /// Removes a table from the store. On return, `table` holds what is to be freed.
    ///
    /// # Errors
    /// 0x4216 if there is none of that id, 0x4259 if it is coupled or queued for coupling.
    pub fn delete(
        &mut self,
        id: TableId,
        table: &mut Option<Box<PreparedTable>>,
    ) -> Result<(), CouplingError> {
        let TableRef { slot, .. } = self.find_unused(id)?;
        // A slot becomes free, but the others keep their numbers: references of couplings stay valid.
        let deleted = self.slots[slot].take();
        *table = deleted.and_then(|table| self.reserve.exchange(table.prepared));
        self.note_change();
        Ok(())
    }

    /// Checks [`Self::delete`] without applying it.
    ///
    /// # Errors
    /// As there.
    pub fn plan_delete(&self, id: TableId) -> Result<(), CouplingError> {
        self.find_unused(id).map(drop)
    }

    pub(super) fn find_unused(&self, id: TableId) -> Result<TableRef, CouplingError> {
        let found = self.find(id)?;
        match self.get(&found)?.uses {
            0 => Ok(found),
            uses => Err(CouplingError::TableInUse { table: id, uses }),
        }
    }

    pub(super) fn selection_of(
        &self,
        id: TableId,
        replace: bool,
        new: Option<&PreparedTable>,
        room: usize,
    ) -> Result<TableSelection, CouplingError> {
        // Before the search: an id outside the range is never found, and would be taken for a new table.
        check_id(id)?;
        let new = new.ok_or(CouplingError::NoTable)?;
        let rows = new.rows();
        let Ok(found) = self.find(id) else {
            self.check_free_slot()?;
            check_rows(rows, room)?;
            return Ok(TableSelection::New);
        };
        if !replace {
            return Err(CouplingError::TableExists { table: id });
        }
        let place = self.get(&found)?;
        let freed = match place.prepared.home {
            None => place.prepared.rows(),
            // It continues to wait where it belongs.
            Some(_) => 0,
        };
        // The room of reserved tables is `usize::MAX`, which a sum would overflow.
        check_rows(rows, room.saturating_add(freed))?;
        if place.uses == 0 {
            return Ok(TableSelection::InPlaceOf(found.slot));
        }
        check_online(id, place, new)?;
        Ok(TableSelection::Online(found.slot))
    }
}

const fn check_rows(received: usize, room: usize) -> Result<(), CouplingError> {
    if received > room {
        return Err(CouplingError::TooManyRows { received, room });
    }
    Ok(())
}

/// Checks whether all points of a plate in use can change to those of another.
fn check_online(
    id: TableId,
    place: &StoredTable,
    new: &PreparedTable,
) -> Result<(), CouplingError> {
    let (present, next) = (place.prepared.versions.plate(), new.versions.plate());
    let functions = present.function().zip(next.function());
    let points = functions
        .filter(|(present, next)| present.points().len() == next.points().len())
        .map_or(0, |(present, _)| present.points().len());
    // 0 stands for a table or another number of points: neither has room for the other's points.
    let fits = (1..=MOST_POINTS_REPLACED_IN_USE).contains(&points);
    // Changes that wait for the next cycle would lose their seam on a linear plate.
    if !fits || present.course() != next.course() {
        return Err(CouplingError::NotReplaceable {
            table: id,
            uses: place.uses,
            table_type: present.table_type(),
            rows: present.rows(),
        });
    }
    let mode = place.prepared.versions.mode().activation.mode;
    // Points of a change that is off would be queued and never taken.
    if mode == ActivationMode::Off {
        return Err(CouplingError::ModeNotAllowed {
            operation: Operation::OnlineChange,
            mode,
        });
    }
    place.prepared.versions.check_not_under_way(id)
}
