//! Sources of the set values of a cycle, in any mode.

use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

use super::super::planned::KnownMotion;
use super::super::prediction::moved_on;
use super::{ExtrapolateMode, SetValues};

/// The correction times that the extrapolating modes use, if known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CorrectionTimes {
    pub(crate) sync: Option<Seconds>,
    pub(crate) time: Option<Seconds>,
    pub(crate) observer: Option<Seconds>,
}

impl CorrectionTimes {
    /// The correction of a mode; none if it needs none or has none.
    pub(crate) const fn of(&self, mode: ExtrapolateMode) -> Option<Seconds> {
        match mode {
            ExtrapolateMode::Sync => self.sync,
            ExtrapolateMode::Time => self.time,
            ExtrapolateMode::Observer => self.observer,
            ExtrapolateMode::Bypass | ExtrapolateMode::Pt1 => None,
        }
    }
}

/// Sources of the set values of one cycle, in any mode.
#[derive(Clone, Copy)]
pub(super) struct Candidates<'a> {
    pub(super) received: &'a Kinematics,
    pub(super) filtered: SetValues,
    /// True if the acceleration is taken into account.
    pub(super) by_acceleration: bool,
    pub(super) corrections: CorrectionTimes,
    /// The motion that is known besides.
    pub(super) known: KnownMotion<'a>,
}

/// Set values of a mode.
#[derive(Clone, Copy)]
pub(super) struct Aim {
    pub(super) set: SetValues,
    pub(super) acceleration: f64,
    /// True if they lie between two frames.
    pub(super) is_interpolated: bool,
    /// True if they are those of a plan.
    pub(super) is_planned: bool,
}

impl Candidates<'_> {
    /// Set values of a mode; none if it has no correction time.
    pub(super) fn of(&self, mode: ExtrapolateMode) -> Option<Aim> {
        match mode {
            // Bypass and PT1 need no correction: only these two can always be fallen back to.
            ExtrapolateMode::Bypass => Some(self.as_received()),
            ExtrapolateMode::Pt1 => Some(Aim {
                set: self.filtered,
                ..self.as_received()
            }),
            ExtrapolateMode::Sync | ExtrapolateMode::Time | ExtrapolateMode::Observer => {
                Some(self.moved(mode, self.corrections.of(mode)?))
            }
        }
    }

    /// The set values as received.
    pub(super) fn as_received(&self) -> Aim {
        Aim {
            set: (*self.received).into(),
            acceleration: self.received.acceleration,
            is_interpolated: false,
            is_planned: false,
        }
    }

    /// Acceleration that is taken into account, u/s².
    pub(super) fn acceleration(&self) -> f64 {
        // That of an encoder or interpolated axis may be noise, of which Δt²/2 would be added to the position.
        if self.by_acceleration {
            self.received.acceleration
        } else {
            0.0
        }
    }

    fn moved(&self, mode: ExtrapolateMode, Seconds(correction): Seconds) -> Aim {
        let KnownMotion { later, planned } = self.known;
        let age = later.map_or(correction, |later| correction - later.by.0);
        // The far time of the blocks of TS5066 has a constant offset, at which the plan would be another motion.
        let planned = planned.filter(|_| mode == ExtrapolateMode::Observer);
        // Frames come first, and a plan is for those that are missing.
        let is_missing = |_: &_| later.is_none_or(|later| later.frames.is_missing(-age));
        let planned = planned.filter(is_missing).and_then(|plan| plan.at(age));
        let interpolated = || later?.frames.at(-age, self.by_acceleration);
        let (set, is_planned) = match planned {
            Some(set) => (Some(set), true),
            None => (interpolated(), false),
        };
        match set {
            Some(set) => Aim {
                set: set.into(),
                acceleration: set.acceleration,
                is_interpolated: !is_planned,
                is_planned,
            },
            // The frame that is needed has not arrived.
            None => self.extrapolated(age),
        }
    }

    fn extrapolated(&self, age: f64) -> Aim {
        let moved = moved_on(
            &Kinematics {
                acceleration: self.acceleration(),
                ..*self.received
            },
            age,
        );
        let acceleration = match self.by_acceleration {
            true => moved.acceleration,
            false => moved_on(self.received, age).acceleration,
        };
        Aim {
            set: moved.into(),
            acceleration,
            is_interpolated: false,
            is_planned: false,
        }
    }
}
