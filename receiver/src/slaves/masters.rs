//! The masters of one slave, in one cycle.

use coaxle_axis::Masters;

use super::Master;

/// The masters of a slave in a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlaveMasters {
    /// True if masters that are lost or in error are included.
    follows: bool,
    count: usize,
    first: Option<Master>,
    are_ready: bool,
    as_couplings_see: Masters,
}

impl SlaveMasters {
    /// Starts without masters. A slave that `follows` a master that is lost or in error sees every
    /// master with data, others only sound ones.
    pub(super) fn none(follows: bool) -> Self {
        Self {
            follows,
            count: 0,
            first: None,
            // The neutral element of the conjunction: each master that is added may make it false.
            are_ready: true,
            as_couplings_see: Masters::default(),
        }
    }

    /// Adds the next master; none if it has no data yet.
    pub(super) fn add(&mut self, master: Option<Master>) {
        if self.count == 0 {
            self.first = master;
        }
        self.are_ready &= master.is_some_and(|master| master.is_ready);
        if let Some(seen) = master.filter(|master| self.follows || master.is_sound) {
            let couplings = &mut self.as_couplings_see;
            couplings.put(self.count, &seen.set, seen.travel);
        }
        // A master without data keeps its place, which the ratios of a sum refer to.
        self.count += 1;
    }

    /// The first master, for features with only one; none if it has no data yet.
    pub(super) const fn first(&self) -> Option<&Master> {
        self.first.as_ref()
    }

    /// True if all masters are there, without an error, and their clocks are known.
    pub(super) const fn are_ready(&self) -> bool {
        self.are_ready
    }

    /// The masters as couplings see them.
    pub(super) const fn as_couplings_see(&self) -> &Masters {
        &self.as_couplings_see
    }
}
