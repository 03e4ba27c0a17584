//! The masters of a slave.

use coaxle_curve::profile::Kinematics;

use crate::travel_direction::TravelDirection;

/// The masters of a slave in one cycle, by their number; none where a master is lost or in error.
///
/// Number 0 is the master of every coupling that has but one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Masters {
    all: [Option<Kinematics>; Masters::MOST],
    travel: [Option<TravelDirection>; Masters::MOST],
}

impl Masters {
    /// How many masters a slave can have.
    pub const MOST: usize = 4;

    /// These, numbered as they come; what exceeds the most there can be is left out.
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

    /// One more, by its number, with what is known of its direction if it is measured; without effect where that is none
    /// that there can be.
    pub fn put(&mut self, number: usize, set: &Kinematics, travel: Option<TravelDirection>) {
        if let (Some(place), Some(direction)) =
            (self.all.get_mut(number), self.travel.get_mut(number))
        {
            *place = Some(*set);
            *direction = travel;
        }
    }

    /// Where a master goes, or went last, if it is measured in increments and these tell: then nothing else
    /// is to be taken for a reversal. None where its positions are exact.
    #[must_use]
    pub fn travel(&self, number: usize) -> Option<TravelDirection> {
        *self.travel.get(number)?
    }

    /// The set values of a master; none if it is lost, or if there is none of that number.
    #[must_use]
    pub fn get(&self, number: usize) -> Option<&Kinematics> {
        self.all.get(number)?.as_ref()
    }

    /// The set values of the first.
    #[must_use]
    pub const fn first(&self) -> Option<&Kinematics> {
        self.all[0].as_ref()
    }

    /// The same with the first led to elsewhere. One that is being shifted goes as its positions say.
    #[must_use]
    pub fn with_first(mut self, first: Kinematics, is_shifting: bool) -> Self {
        self.all[0] = Some(first);
        if is_shifting {
            self.travel[0] = None;
        }
        self
    }
}

/// But one.
impl From<Option<&Kinematics>> for Masters {
    fn from(master: Option<&Kinematics>) -> Self {
        Self {
            all: [master.copied(), None, None, None],
            travel: [None; Self::MOST],
        }
    }
}
