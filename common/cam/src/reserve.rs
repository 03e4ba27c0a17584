//! Tables that a program loads again and again: nothing is allocated or freed, and none of them is lost.
//!
//! Each is kept twice: as it was made, and in the room that it has in a store. Whoever takes it out of the store, program or order, it
//! comes back here and is made as it was. What a program takes out that somebody else brought waits on a shelf, until an
//! order comes that has room to take it along. An order brings at most one table, and takes one along if any waits: so those of others are
//! never more than a store has places.

use alloc::boxed::Box;
use alloc::vec::Vec;

use super::error::TableId;
use super::prepared::{PreparedTable, ReservedPlate};

#[derive(Debug, Default)]
pub(super) struct Reserve {
    pub(super) kept: Vec<Kept>,
    /// Tables of others that were taken out, until somebody frees them.
    #[expect(
        clippy::vec_box,
        reason = "they come and go as boxes: taking one out of its box would free that in the cycle"
    )]
    shelf: Vec<Box<PreparedTable>>,
}

#[derive(Debug)]
pub(super) struct Kept {
    pub(super) id: TableId,
    /// As it was made; never in a store.
    pub(super) made: PreparedTable,
    /// What goes into the store; none while it is there.
    pub(super) at_hand: Option<Box<PreparedTable>>,
}

impl Reserve {
    /// How many points and rows there are.
    pub(super) fn rows(&self) -> usize {
        self.kept.iter().map(|kept| kept.made.rows()).sum()
    }

    /// A table that is not needed any more: it goes home, or waits to be freed.
    pub(super) fn put_away(&mut self, table: Box<PreparedTable>) {
        let home = table.home.and_then(|ReservedPlate(n)| self.kept.get_mut(n));
        match home {
            Some(kept) => kept.take_back(table),
            None => self.shelf.push(table),
        }
    }

    /// The same for somebody who can free one: this one, or another that waits for it.
    pub(super) fn exchange(&mut self, table: Box<PreparedTable>) -> Option<Box<PreparedTable>> {
        if table.home.is_none() {
            return Some(table);
        }
        self.put_away(table);
        self.take_out()
    }

    /// From now on so many can wait to be freed. This allocates.
    pub(super) fn make_room(&mut self, places: usize) {
        self.shelf.reserve(places.saturating_sub(self.shelf.len()));
    }

    /// One that waits to be freed, if any does.
    pub(super) fn take_out(&mut self) -> Option<Box<PreparedTable>> {
        self.shelf.pop()
    }
}

impl Kept {
    fn take_back(&mut self, mut table: Box<PreparedTable>) {
        table.versions.restore(self.made.versions.plate());
        self.at_hand = Some(table);
    }
}
