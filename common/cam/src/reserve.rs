//! Tables that a program loads repeatedly: nothing is allocated or freed, and none of them is lost.
//!
//! Each is kept twice: as it was made, and with its memory in a store. Taken out of the store, by a
//! program or an order, it returns here and is restored. A table of an order that a program takes out
//! waits until an order can take it along. An order brings at most one table, and takes one
//! along if any waits, so the tables of others are never more than a store has places.

use alloc::boxed::Box;
use alloc::vec::Vec;

use super::error::TableId;
use super::prepared::{PreparedTable, ReservedPlate};

#[derive(Debug, Default)]
pub(super) struct Reserve {
    pub(super) kept: Vec<ReservedTable>,
    /// Tables of others that were taken out and wait to be freed.
    #[expect(
        clippy::vec_box,
        reason = "they come and go as boxes: taking one out of its box would free that in the cycle"
    )]
    to_be_freed: Vec<Box<PreparedTable>>,
}

#[derive(Debug)]
pub(super) struct ReservedTable {
    pub(super) id: TableId,
    /// Table as it was made; never in a store.
    pub(super) original: PreparedTable,
    /// Table for the store; none while it is there.
    pub(super) available: Option<Box<PreparedTable>>,
}

impl Reserve {
    /// Returns the number of points and rows.
    pub(super) fn rows(&self) -> usize {
        self.kept.iter().map(|kept| kept.original.rows()).sum()
    }

    /// Puts away a table that is no longer needed: it returns to its place, or waits to be freed.
    pub(super) fn return_or_queue(&mut self, table: Box<PreparedTable>) {
        let home = table.home.and_then(|ReservedPlate(n)| self.kept.get_mut(n));
        match home {
            // A home number without a place cannot occur, as places are never removed. Such a table would just
            // be freed.
            Some(kept) => kept.take_back(table),
            None => self.to_be_freed.push(table),
        }
    }

    /// Puts a table away for a caller that can free one: returns this one, or another that waits to be
    /// freed.
    pub(super) fn exchange(&mut self, table: Box<PreparedTable>) -> Option<Box<PreparedTable>> {
        // Tables of an order are the caller's to free, reserved ones never.
        if table.home.is_none() {
            return Some(table);
        }
        self.return_or_queue(table);
        self.take_out()
    }

    /// Reserves space for this number of tables that wait to be freed. Allocates.
    pub(super) fn make_room(&mut self, places: usize) {
        self.to_be_freed
            // At most all tables of the store can wait at once, so a push in the cycle never grows the list.
            .reserve(places.saturating_sub(self.to_be_freed.len()));
    }

    /// Takes out a table that waits to be freed, if there is one.
    pub(super) fn take_out(&mut self) -> Option<Box<PreparedTable>> {
        self.to_be_freed.pop()
    }
}

impl ReservedTable {
    fn take_back(&mut self, mut table: Box<PreparedTable>) {
        // Points written meanwhile must not be there when the program selects it again.
        table.versions.restore(self.original.versions.plate());
        self.available = Some(table);
    }
}
