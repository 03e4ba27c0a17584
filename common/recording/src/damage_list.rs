//! A list of damage of bounded length.

use crate::records::Damage;

/// Greatest length of the list.
const MOST_DAMAGE: usize = 20;

/// Damage of a file in its order: the first pieces, and the last one.
// A long file can be damaged at each of its records.
#[derive(Debug, Default)]
pub struct DamageList {
    listed: Vec<Damage>,
    more: u64,
}

impl DamageList {
    /// Returns the first pieces, and the last one.
    #[must_use]
    pub const fn listed(&self) -> &[Damage] {
        self.listed.as_slice()
    }

    /// Returns the number of further ones, which are not listed.
    #[must_use]
    pub const fn more(&self) -> u64 {
        self.more
    }

    /// Adds the next one.
    pub fn note(&mut self, damage: Damage) {
        if self.listed.len() == MOST_DAMAGE {
            // The newest replaces the last of the list: the end of the file, mostly the cause of interest, stays
            // visible.
            self.listed.pop();
            self.more += 1;
        }
        self.listed.push(damage);
    }
}
