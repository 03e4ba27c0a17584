//! The masters of a slave.

use coaxle_curve::profile::Kinematics;

use crate::travel_direction::TravelDirection;

/// The masters of a slave in one cycle, by number; none where a master is lost or in error.
///
/// Number 0 is the master of couplings with a single master.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Masters {
    all: [Option<Kinematics>; Masters::MOST],
    travel: [Option<TravelDirection>; Masters::MOST],
}

impl Masters {
    /// Greatest number of masters of a slave.
    // `MC_GearInMultiMaster` has four, and an array of them needs no allocation.
    pub const MOST: usize = 4;

    /// Creates masters numbered in this order; those beyond the greatest number are left out.
    #[must_use]
    pub fn of(masters: impl IntoIterator<Item = Option<Kinematics>>) -> Self {
        let mut all = [None; Self::MOST];
        for (place, master) in all.iter_mut().zip(masters) {
            *place = master;
        }
        Self {
            all,
            travel: [None; Self::MOST],
        }
    }

    /// Sets a master, by its number, with its direction of travel if it is measured; without effect
    /// for an invalid number.
    pub fn put(&mut self, number: usize, set: &Kinematics, travel: Option<TravelDirection>) {
        if let (Some(place), Some(direction)) =
            (self.all.get_mut(number), self.travel.get_mut(number))
        {
            *place = Some(*set);
            *direction = travel;
        }
    }

    /// Current or last direction of travel of a master, if it is measured in increments: then no
    /// other value indicates a reversal. None if its positions are exact.
    #[must_use]
    pub fn travel(&self, number: usize) -> Option<TravelDirection> {
        *self.travel.get(number)?
    }

    /// The set values of a master; none if it is lost, or for an invalid number.
    #[must_use]
    pub fn get(&self, number: usize) -> Option<&Kinematics> {
        self.all.get(number)?.as_ref()
    }

    /// The set values of the first.
    #[must_use]
    pub const fn first(&self) -> Option<&Kinematics> {
        self.all[0].as_ref()
    }

    /// Replaces the first master. The direction of one that is being shifted follows from its positions.
    #[must_use]
    pub fn with_first(mut self, first: Kinematics, is_shifting: bool) -> Self {
        self.all[0] = Some(first);
        if is_shifting {
            // Whole increments of the encoder no longer decide once a phase shift moves the position as well.
            self.travel[0] = None;
        }
        self
    }
}

/// A single master.
impl From<Option<&Kinematics>> for Masters {
    fn from(master: Option<&Kinematics>) -> Self {
        Self {
            all: [master.copied(), None, None, None],
            travel: [None; Self::MOST],
        }
    }
}
