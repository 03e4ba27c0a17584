//! The store of cam plates, by table id.

use alloc::boxed::Box;
use alloc::vec::Vec;

use super::error::{CouplingError, TableId};
use super::prepared::PreparedTable;
use super::reserve::Reserve;
use super::versions::{Lease, OnlineChangeMode, Versions};
use coaxle_plate::{CamError, MotionFunction, MotionPoint, Plate};

/// The ids a table can have.
const IDS: core::ops::RangeInclusive<TableId> = 1..=255;

/// Number of ids for tables.
// TF5050 8.12: cam table ids are 1 to 255 (0x4B32), and 0 stands for the only plate of a coupling.
pub const MOST_TABLES: usize = 255;

/// The plates that couplings can use: those loaded by `MC_CamTableSelect`, TF5050 chapter 4.1.
///
/// Any number of slaves can be on a plate, each at its own place. A change of points takes effect for
/// each slave at its own moment; until all have taken it, no other change can begin.
///
/// [`insert`](Self::insert) and [`remove`](Self::remove) allocate; using, writing and reading never do,
/// and neither do [`select`](Self::select) and [`delete`](Self::delete), which are passed tables as a
/// whole.
#[derive(Debug)]
pub struct Tables {
    /// A table keeps its slot as long as it is there.
    pub(super) slots: Vec<Option<StoredTable>>,
    /// Counter of writes, so that couplings need not look for them in every cycle.
    writes: u32,
    /// Counter of all changes, so that no outdated plan is applied.
    revision: u32,
    /// Tables that programs load repeatedly, and tables that they took out.
    pub(super) reserve: Reserve,
}

#[derive(Debug)]
pub(super) struct StoredTable {
    id: TableId,
    pub(super) prepared: Box<PreparedTable>,
    pub(super) uses: u32,
}

/// Slot and id of a table in the store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TableRef {
    pub(super) slot: usize,
    pub(super) id: TableId,
}

impl Tables {
    /// Makes a store for this number of plates.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        let mut slots = Vec::new();
        slots.resize_with(capacity, || None);
        Self {
            slots,
            writes: 0,
            revision: 0,
            reserve: Reserve::default(),
        }
    }

    /// `MC_CamTableSelect`: inserts a plate into the store.
    ///
    /// # Errors
    /// 0x4B32 for an id outside 1 to 255, 0x4063 if there is a table of that id, 0x4A11 if the store
    /// is full.
    #[doc(alias = "MC_CamTableSelect")]
    pub fn insert(&mut self, id: TableId, plate: Plate) -> Result<(), CouplingError> {
        check_id(id)?;
        if self.find(id).is_ok() {
            return Err(CouplingError::TableExists { table: id });
        }
        self.check_free_slot()?;
        self.put(id, Box::new(PreparedTable::of(plate)));
        Ok(())
    }

    /// Removes a plate from the store.
    ///
    /// # Errors
    /// 0x4216 if there is none of that id, 0x4259 if it is coupled or queued for coupling.
    pub fn remove(&mut self, id: TableId) -> Result<Plate, CouplingError> {
        let TableRef { slot, .. } = self.find(id)?;
        match self.slots[slot].take() {
            Some(table) if table.uses == 0 => {
                self.note_change();
                let plate = table.prepared.versions.plate().clone();
                self.reserve.return_or_queue(table.prepared);
                Ok(plate)
            }
            table => {
                let uses = table.as_ref().map_or(0, |table| table.uses);
                self.slots[slot] = table;
                Err(CouplingError::TableInUse { table: id, uses })
            }
        }
    }

    /// Returns the plate in force of an id.
    ///
    /// # Errors
    /// 0x4216 if there is none.
    pub fn plate(&self, id: TableId) -> Result<&Plate, CouplingError> {
        let table = self.find(id)?;
        Ok(self.get(&table)?.prepared.versions.plate())
    }

    /// Returns the ids in the store.
    pub fn ids(&self) -> impl Iterator<Item = TableId> + '_ {
        self.slots.iter().flatten().map(|table| table.id)
    }

    /// `MC_SetCamOnlineChangeMode`: activation of points that are written from now on; `DeleteQueuedData`
    /// discards those that wait and keeps the mode.
    ///
    /// # Errors
    /// 0x4216 for an unknown table, 0x4262 for a position table, 0x4283 for a mode that is not allowed
    /// for online changes or for this plate, 0x422B for a position outside the plate, 0x4287 if the
    /// queued data are already in force for some slaves.
    #[doc(alias = "MC_SetCamOnlineChangeMode")]
    pub fn set_online_change_mode(
        &mut self,
        id: TableId,
        mode: OnlineChangeMode,
    ) -> Result<(), CouplingError> {
        self.plan_online_change_mode(id, &mode)?;
        self.get_mut(id)?.prepared.versions.set_mode(mode);
        Ok(())
    }

    /// Checks [`Self::set_online_change_mode`] without applying it.
    ///
    /// # Errors
    /// As there.
    pub fn plan_online_change_mode(
        &self,
        id: TableId,
        mode: &OnlineChangeMode,
    ) -> Result<(), CouplingError> {
        self.function(id)?;
        let table = self.find(id)?;
        self.get(&table)?.prepared.versions.check_mode(id, mode)
    }

    /// `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint`: replaces the points with the same
    /// indices. They take effect by the mode of the table; at once if no slave is on it.
    ///
    /// Points that are already queued stay queued, except those that are replaced.
    ///
    /// # Errors
    /// 0x4216 for an unknown table, 0x4287 if the previous change is in force for some slaves but not for
    /// all, and those of [`MotionFunction::change`]. Then everything is unchanged.
    #[doc(alias = "MC_WriteMotionFunction")]
    #[doc(alias = "MC_WriteMotionFunctionPoint")]
    // Counted even if it is refused: couplings then look once in vain.
    pub fn write(&mut self, id: TableId, points: &[MotionPoint]) -> Result<(), CouplingError> {
        self.note_write();
        self.get_mut(id)?.prepared.versions.write(id, points)
    }

    /// Checks [`Self::write`] without applying it.
    ///
    /// # Errors
    /// As there.
    pub fn plan_write(&self, id: TableId, points: &[MotionPoint]) -> Result<(), CouplingError> {
        let table = self.find(id)?;
        self.get(&table)?.prepared.versions.check_write(id, points)
    }

    /// `MC_ReadMotionFunction`, `MC_ReadMotionFunctionPoint`: up to `count` points in force from an index
    /// on, all following ones for 0.
    ///
    /// # Errors
    /// 0x4216 for an unknown table, 0x4262 for a position table, 0x4B33 for an unknown point.
    #[doc(alias = "MC_ReadMotionFunction")]
    #[doc(alias = "MC_ReadMotionFunctionPoint")]
    pub fn read(
        &self,
        id: TableId,
        first: u32,
        count: usize,
    ) -> Result<&[MotionPoint], CouplingError> {
        Ok(self.function(id)?.read(first, count)?)
    }

    /// Returns the number of changes so far, wrapping around: while it is unchanged, plans can be applied.
    #[must_use]
    pub const fn revision(&self) -> u32 {
        self.revision
    }

    /// True if points wait for their activation.
    ///
    /// # Errors
    /// 0x4216 for an unknown table.
    #[doc(alias = "CamDataQueued")]
    pub fn data_queued(&self, id: TableId) -> Result<bool, CouplingError> {
        let table = self.find(id)?;
        Ok(self.get(&table)?.prepared.versions.queued().is_some())
    }

    #[inline]
    pub(super) const fn writes(&self) -> u32 {
        self.writes
    }

    pub(super) fn find(&self, id: TableId) -> Result<TableRef, CouplingError> {
        let is_it = |slot: &Option<StoredTable>| slot.as_ref().is_some_and(|table| table.id == id);
        // At most 255 slots, and only commands search them: couplings keep the slot.
        match self.slots.iter().position(is_it) {
            Some(slot) => Ok(TableRef { slot, id }),
            None => Err(CouplingError::TableUnknown { table: id }),
        }
    }

    /// Returns the plate's versions. A coupling's own tables are always there; another store may be
    /// passed in by mistake.
    #[inline]
    pub(super) fn versions(&self, table: &TableRef) -> Result<&Versions, CouplingError> {
        Ok(&self.get(table)?.prepared.versions)
    }

    pub(super) fn versions_mut(&mut self, table: &TableRef) -> Option<&mut Versions> {
        self.note_change();
        Some(&mut self.slots.get_mut(table.slot)?.as_mut()?.prepared.versions)
    }

    /// Keeps a table from being removed.
    pub(super) fn hold(&mut self, table: &TableRef) {
        self.note_change();
        if let Some(Some(table)) = self.slots.get_mut(table.slot) {
            table.uses += 1;
        }
    }

    pub(super) fn release(&mut self, table: &TableRef) {
        self.note_change();
        if let Some(Some(table)) = self.slots.get_mut(table.slot) {
            // A store passed in by mistake may count fewer uses, and must not underflow in the cycle.
            table.uses = table.uses.saturating_sub(1);
        }
    }

    pub(super) fn acquire(&mut self, table: &TableRef) -> Result<Lease, CouplingError> {
        let unknown = CouplingError::TableUnknown { table: table.id };
        Ok(self.versions_mut(table).ok_or(unknown)?.acquire())
    }

    pub(super) fn leave(&mut self, table: &TableRef, lease: &Lease) {
        if let Some(versions) = self.versions_mut(table) {
            versions.leave(lease);
        }
    }

    /// Returns the number of points and rows of all its plates, reserved ones included.
    #[must_use]
    pub fn rows(&self) -> usize {
        let tables = self.slots.iter().flatten();
        // Reserved tables are counted once, wherever their memory is at present.
        let others = tables.filter(|table| table.prepared.home.is_none());
        others.map(|table| table.prepared.rows()).sum::<usize>() + self.reserve.rows()
    }

    /// Checks for a free slot.
    pub(super) fn check_free_slot(&self) -> Result<(), CouplingError> {
        let capacity = self.slots.len();
        let is_free = self.slots.iter().any(Option::is_none);
        is_free
            .then_some(())
            .ok_or(CouplingError::StoreFull { capacity })
    }

    /// Puts a table into a free slot, which exists.
    pub(super) fn put(&mut self, id: TableId, prepared: Box<PreparedTable>) {
        if let Some(free) = self.slots.iter_mut().find(|slot| slot.is_none()) {
            let uses = 0;
            *free = Some(StoredTable { id, prepared, uses });
            self.note_change();
        }
    }

    /// Counts a change.
    pub(super) const fn note_change(&mut self) {
        // Readers compare for equality only, so wrapping around is harmless.
        self.revision = self.revision.wrapping_add(1);
    }

    /// Makes couplings look for changes again.
    pub(super) const fn note_write(&mut self) {
        self.writes = self.writes.wrapping_add(1);
    }

    #[inline]
    pub(super) fn get(&self, table: &TableRef) -> Result<&StoredTable, CouplingError> {
        match self.slots.get(table.slot) {
            // The id, too: the slot may belong to another table of another store.
            Some(Some(found)) if found.id == table.id => Ok(found),
            _ => Err(CouplingError::TableUnknown { table: table.id }),
        }
    }

    pub(super) fn get_mut(&mut self, id: TableId) -> Result<&mut StoredTable, CouplingError> {
        self.note_change();
        let TableRef { slot, .. } = self.find(id)?;
        let unknown = CouplingError::TableUnknown { table: id };
        self.slots[slot].as_mut().ok_or(unknown)
    }

    fn function(&self, id: TableId) -> Result<&MotionFunction, CouplingError> {
        let plate = self.plate(id)?;
        let received = plate.table_type();
        Ok(plate
            .function()
            .ok_or(CamError::NotAMotionFunction { received })?)
    }
}

pub(super) fn check_id(id: TableId) -> Result<(), CouplingError> {
    if IDS.contains(&id) {
        Ok(())
    } else {
        Err(CouplingError::TableId { received: id })
    }
}
