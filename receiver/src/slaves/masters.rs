//! The masters of one slave, in one cycle.

use coaxle_axis::Masters;

use super::Master;
use crate::promised::PromisedMotion;

/// The masters of a slave in a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlaveMasters<'a> {
    /// True if masters that are lost or in error are included.
    follows: bool,
    count: usize,
    first: Option<Master>,
    promised: Option<PromisedMotion<'a>>,
    are_ready: bool,
    /// Errors of the masters; 0 of one without an error, or without data.
    error_codes: [u32; Masters::MOST],
    as_couplings_see: Masters,
}

impl<'a> SlaveMasters<'a> {
    /// Starts without masters. A slave that `follows` a master that is lost or in error sees every
    /// master with data, others only sound ones.
    pub(super) fn none(follows: bool) -> Self {
        Self {
            follows,
            count: 0,
            first: None,
            promised: None,
            // The neutral element of the conjunction: each master that is added may make it false.
            are_ready: true,
            error_codes: [0; Masters::MOST],
            as_couplings_see: Masters::default(),
        }
    }

    /// Adds the next master; none if it has no data yet.
    pub(super) fn add(&mut self, master: Option<Master>) {
        if self.count == 0 {
            self.first = master;
        }
        self.are_ready &= master.is_some_and(|master| master.is_ready);
        if let (Some(code), Some(master)) = (self.error_codes.get_mut(self.count), master) {
            *code = master.error_code;
        }
        if let Some(seen) = master.filter(|master| self.follows || master.is_sound) {
            let couplings = &mut self.as_couplings_see;
            couplings.put(self.count, &seen.set, seen.travel);
        }
        // A master without data keeps its place, which the ratios of a sum refer to.
        self.count += 1;
    }

    /// Takes the promised motion of the first master, for its slave's program.
    pub(super) const fn promise(&mut self, motion: Option<PromisedMotion<'a>>) {
        self.promised = motion;
    }

    /// The promised motion of the first master; none without a promise.
    pub(super) const fn promised(&self) -> Option<PromisedMotion<'a>> {
        self.promised
    }

    /// The first master, for features with only one; none if it has no data yet.
    pub(super) const fn first(&self) -> Option<&Master> {
        self.first.as_ref()
    }

    /// True if all masters are there, without an error, and their clocks are known.
    pub(super) const fn are_ready(&self) -> bool {
        self.are_ready
    }

    /// Error of the first master that has one and is followed, by its number from 0; 0 if none has.
    pub(super) fn error_code(&self, is_followed: impl Fn(usize) -> bool) -> u32 {
        let followed = (0..)
            .zip(&self.error_codes)
            .filter(|(number, _)| is_followed(*number));
        let mut codes = followed.map(|(_, code)| *code);
        codes.find(|code| *code != 0).unwrap_or(0)
    }

    /// The masters as couplings see them.
    pub(super) const fn as_couplings_see(&self) -> &Masters {
        &self.as_couplings_see
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_curve::profile::Kinematics;

    fn master(error_code: u32) -> Option<Master> {
        Some(Master {
            set: Kinematics::at_rest(0.0),
            travel: None,
            is_sound: error_code == 0,
            is_ready: error_code == 0,
            error_code,
        })
    }

    #[test]
    fn the_error_of_any_followed_master_is_shown_and_of_several_the_first() {
        for (masters, least, expected) in [
            (&[master(0), master(0x4b09)][..], 0, 0x4b09),
            (&[None, master(0x4b09), master(7)][..], 0, 0x4b09),
            (&[master(7), master(0x4b09)][..], 0, 7),
            (&[master(7), master(0x4b09)][..], 1, 0x4b09),
            (&[master(7), master(0)][..], 1, 0),
            (&[master(0), None][..], 0, 0),
        ] {
            let mut all = SlaveMasters::none(true);
            masters.iter().for_each(|master| all.add(*master));
            assert_eq!(all.error_code(|number| number >= least), expected);
        }
    }
}
