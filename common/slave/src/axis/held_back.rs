//! An axis whose drive shows its set values later than they are calculated.
//!
//! Commands, couplings and the program act on the set values, and are seen that much later. What must not wait acts on
//! what is shown: an error, a loss of power and `MC_Stop` set the axis back to what its drive follows, without a step of
//! the drive, and brake from there. From then on its set values reach the drive at once, until it stands.

use coaxle_clock::Span;
use coaxle_curve::profile::Kinematics;

use super::SlaveAxis;
use crate::motion::{Motion, Planned};

impl SlaveAxis {
    /// Prepares it for a hold-back: its memory is taken here, and none in the cycle.
    pub fn prepare_hold_back(&mut self) {
        self.drive.prepare_hold_back();
    }

    /// Sets the time by which the drive is given the set values later than they are calculated, from the next cycle on:
    /// at most [`MOST_HELD_BACK`](crate::MOST_HELD_BACK) cycles. It is adopted where the axis stands; in motion it may
    /// change by a thousandth of the time. Without [`prepare_hold_back`](Self::prepare_hold_back) it is zero.
    pub const fn set_hold_back(&mut self, by: Span) {
        self.hold_back = by;
    }

    /// Sets the dead time of its drive, the time after which a set value that it is given is its position,
    /// before it has power.
    ///
    /// The drive is given each set value that much earlier. A hold-back is shortened by it, so that the values are known. What it lacks is
    /// predicted by the course of the set positions: off by `jerk · time³ / 6`, with steps of the velocity by `jerk · time² / 2` where the
    /// jerk changes, by both twice where it turns; the time is that and a cycle.
    pub const fn set_dead_time(&mut self, dead_time: Span) {
        self.drive.set_dead_time(dead_time);
    }

    /// Time by which its drive was given the set values later in the newest cycle.
    #[must_use]
    pub fn held_back_by(&self) -> Span {
        self.drive.held_back_by()
    }

    /// The set values that its drive is given now.
    #[must_use]
    pub fn shown(&self) -> Kinematics {
        match self.drive.predicted() {
            Some(predicted) => self.of_drive(predicted),
            None => self.due(),
        }
    }

    /// The set values that are due now, from which a stop begins: those that are held back, or the newest.
    pub(super) fn due(&self) -> Kinematics {
        self.held_back_at().unwrap_or(self.set)
    }

    /// Number of times that it was set back to what its drive was shown, by an error or a stop, wrapping around.
    #[must_use]
    pub const fn set_back_count(&self) -> u32 {
        self.set_backs
    }

    /// True if it stands, and its drive is shown nothing else.
    #[must_use]
    pub fn rests(&self) -> bool {
        self.stands() && self.drive.is_quiet()
    }

    /// Sets a coupled axis back with its master, which is where the master is shown, too.
    pub fn set_back_with_master(&mut self) {
        if let Motion::Coupled(_) = self.motion {
            self.set_back();
        }
    }

    /// Sets it back to what its drive is shown, without a step of the drive.
    pub(super) fn set_back(&mut self) {
        let Some(shown) = self.held_back_at() else {
            return;
        };
        self.drive.release();
        if shown == self.set {
            return;
        }
        self.place(&shown);
        self.mean_velocity = shown.velocity;
        self.set_backs = self.set_backs.wrapping_add(1);
        self.revision = self.revision.wrapping_add(1);
        // A motion of its own would go on from where it was ahead.
        if let Motion::Own(_) = self.motion {
            self.motion = Motion::Own(Planned::keep_velocity(&shown, &self.guard));
        }
    }

    /// The start state of a stop: what the drive is shown.
    pub(super) fn stoppable(&self) -> Kinematics {
        match self.held_back_at() {
            Some(shown) if shown != self.set => self.guard.taken_over(&shown),
            _ => self.free(),
        }
    }

    /// The set values that the drive follows, if they are held back, with the axis's own positions.
    fn held_back_at(&self) -> Option<Kinematics> {
        self.drive.shown().map(|shown| self.of_drive(shown))
    }

    /// A state of the drive, with the axis's own positions.
    fn of_drive(&self, state: Kinematics) -> Kinematics {
        let position = state.position + self.drive_zero;
        Kinematics { position, ..state }
    }
}
