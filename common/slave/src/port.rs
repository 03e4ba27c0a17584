//! The drive of an axis, and its last plausible values.

use alloc::boxed::Box;

use coaxle_axis::drive::{Actual, Drive, DriveFault, DriveState};
use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::Kinematics;

use super::held_back::HeldBack;

/// Reads the drive once after each call: all other code uses the copy.
#[derive(Debug)]
pub(crate) struct DrivePort {
    drive: Box<dyn Drive>,
    actual: Actual,
    /// Set values that wait, if they may be held back.
    held_back: Option<Box<HeldBack>>,
}

impl DrivePort {
    pub(crate) fn new(drive: Box<dyn Drive>) -> Self {
        // The first values may be implausible, too: the axis then begins at 0.
        let actual = believed(drive.actual(), &Actual::default());
        Self {
            drive,
            actual,
            held_back: None,
        }
    }

    /// Prepares it for set values that are held back.
    pub(crate) fn prepare_hold_back(&mut self) {
        self.held_back = Some(Box::new(HeldBack::new()));
    }

    /// Hold-back in force; zero where set values reach the drive at once.
    pub(crate) fn held_back_by(&self) -> Span {
        (self.held_back.as_ref()).map_or(Span::ZERO, |held_back| held_back.by())
    }

    /// Set values that the drive follows, if they are held back.
    pub(crate) fn shown(&self) -> Option<Kinematics> {
        self.held_back.as_ref()?.shown().copied()
    }

    /// True if no motion waits.
    pub(crate) fn is_quiet(&self) -> bool {
        (self.held_back.as_ref()).is_none_or(|held_back| held_back.is_quiet())
    }

    /// Forgets what waits: the next set values reach the drive at once, until the axis stands.
    pub(crate) fn release(&mut self) {
        if let Some(held_back) = &mut self.held_back {
            held_back.release();
        }
    }

    pub(crate) const fn actual(&self) -> &Actual {
        &self.actual
    }

    pub(crate) fn drive(&self) -> &dyn Drive {
        &*self.drive
    }

    pub(crate) fn power_on(&mut self, position: f64, velocity: f64) {
        self.drive.power_on(position, velocity);
        self.look();
    }

    /// Switches power on with an axis in motion; returns where its drive has to be, which is where the axis was
    /// `hold_back` ago.
    pub(crate) fn power_on_moving(&mut self, set: &Kinematics, hold_back: Span) -> f64 {
        let shown = match &mut self.held_back {
            Some(held_back) if hold_back > Span::ZERO => held_back.begin_moving(set, hold_back),
            _ => {
                // Without power it may still have had one, whose shown position a stop would set the axis back to.
                self.release();
                *set
            }
        };
        self.power_on(shown.position, shown.velocity);
        shown.position
    }

    pub(crate) fn reset(&mut self) {
        self.drive.reset();
        self.look();
    }

    /// Runs a cycle of the drive, with set values that it is to be given `hold_back` later. A hold-back begins where the
    /// axis `stands`.
    pub(crate) fn step(
        &mut self,
        set: &Kinematics,
        elapsed: Seconds,
        hold_back: Span,
        stands: bool,
    ) {
        match &mut self.held_back {
            None => self.drive.step(set, elapsed),
            Some(held_back) => {
                let shown = held_back.step(set, elapsed.to_span(), hold_back, stands);
                self.drive.step(&shown, elapsed);
            }
        }
        self.look();
    }

    /// Fault of its trip.
    pub(crate) fn fault(&self) -> DriveFault {
        // Without a stated fault the following error is the one that the axis can see itself.
        self.actual.fault.unwrap_or(DriveFault::FollowingError {
            following_error: self.actual.following_error,
        })
    }

    fn look(&mut self) {
        self.actual = believed(self.drive.actual(), &self.actual);
    }
}

/// Replaces implausible values by the last ones, and marks a powered drive as tripped.
fn believed(now: Actual, before: &Actual) -> Actual {
    let Some((field, received)) = now.implausible() else {
        return now;
    };
    Actual {
        state: match now.state {
            // Without power a drive follows nothing, and cannot trip.
            DriveState::Off => DriveState::Off,
            _ => DriveState::Tripped,
        },
        fault: Some(DriveFault::Implausible { field, received }),
        // States whether a process is there at all, which does not depend on its values.
        attachment: now.attachment,
        ..*before
    }
}
