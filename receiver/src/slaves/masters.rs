//! The masters of one slave, in one cycle.

use coaxle_axis::Masters;

use super::Master;

/// What leads a slave in a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlaveMasters {
    /// It sees those, too, that are lost or in error.
    follows: bool,
    count: usize,
    first: Option<Master>,
    are_ready: bool,
    as_couplings_see: Masters,
}

impl SlaveMasters {
    /// None so far. A slave that `follows` a master that is lost or in error sees all that there is anything of, others
    /// only those that are sound.
    pub(super) fn none(follows: bool) -> Self {
        Self {
            follows,
            count: 0,
            first: None,
            are_ready: true,
            as_couplings_see: Masters::default(),
        }
    }

    /// The next of them; none where there is nothing of it yet.
    pub(super) fn add(&mut self, master: Option<Master>) {
        if self.count == 0 {
            self.first = master;
        }
        self.are_ready &= master.is_some_and(|master| master.is_ready);
        if let Some(seen) = master.filter(|master| self.follows || master.is_sound) {
            let couplings = &mut self.as_couplings_see;
            couplings.put(self.count, &seen.set, seen.travel);
        }
        self.count += 1;
    }

    /// The master of everything that has but one; none where there is nothing of it yet.
    pub(super) const fn first(&self) -> Option<&Master> {
        self.first.as_ref()
    }

    /// All of them are there, without an error, and their clocks are known.
    pub(super) const fn are_ready(&self) -> bool {
        self.are_ready
    }

    /// As couplings see them.
    pub(super) const fn as_couplings_see(&self) -> &Masters {
        &self.as_couplings_see
    }
}
