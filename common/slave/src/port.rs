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
    /// Time after which the drive shows a set value that it is given.
    dead_time: Span,
    /// Course of the set values that were due.
    course: SetCourse,
    /// Set values that it was given in the newest cycle, if they were predicted.
    predicted: Option<Kinematics>,
}

/// Course of set values, by the differences of their positions: these keep the limits of the axis, while the velocities beside them may be those of
/// a master that beats. In plain schedule 60, with TS5066's blocks, they went to and fro by 10 u/s from cycle to cycle.
#[derive(Clone, Copy, Debug)]
struct SetCourse {
    newest: Kinematics,
    /// Mean velocity in the last cycle, and its duration, s.
    mean_velocity: f64,
    lasted: f64,
}

impl SetCourse {
    const fn from(start: &Kinematics) -> Self {
        Self {
            newest: *start,
            mean_velocity: start.velocity,
            lasted: 0.0,
        }
    }

    /// Takes the position of the next cycle, `passed` seconds later.
    fn take(&mut self, position: f64, passed: f64) {
        let mean_velocity = (position - self.newest.position) / passed;
        // Between the middles of both cycles.
        let acceleration = 2.0 * (mean_velocity - self.mean_velocity) / (passed + self.lasted);
        self.newest = Kinematics {
            position,
            velocity: mean_velocity + 0.5 * acceleration * passed,
            acceleration,
        };
        (self.mean_velocity, self.lasted) = (mean_velocity, passed);
    }
}

impl DrivePort {
    pub(crate) fn new(drive: Box<dyn Drive>) -> Self {
        // The first values may be implausible, too: the axis then begins at 0.
        let actual = believed(drive.actual(), &Actual::default());
        Self {
            drive,
            actual,
            held_back: None,
            dead_time: Span::ZERO,
            course: SetCourse::from(&Kinematics::at_rest(actual.position)),
            predicted: None,
        }
    }

    /// Sets the time after which the drive shows a set value that it is given: it is given each of them that much earlier.
    pub(crate) const fn set_dead_time(&mut self, dead_time: Span) {
        self.dead_time = dead_time;
    }

    /// Prepares it for set values that are held back.
    pub(crate) fn prepare_hold_back(&mut self) {
        self.held_back = Some(Box::new(HeldBack::new()));
    }

    /// Hold-back in force; zero where set values reach the drive at once.
    pub(crate) fn held_back_by(&self) -> Span {
        (self.held_back.as_ref()).map_or(Span::ZERO, |held_back| held_back.by())
    }

    /// Set values that the drive was given in the newest cycle, if they were predicted.
    pub(crate) const fn predicted(&self) -> Option<Kinematics> {
        self.predicted
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
        self.course = SetCourse::from(&Kinematics {
            position,
            velocity,
            acceleration: 0.0,
        });
        self.drive.power_on(position, velocity);
        self.look();
    }

    /// Switches power on with an axis in motion; returns where its drive has to be, which is where the axis was
    /// `hold_back` ago.
    pub(crate) fn power_on_moving(&mut self, set: &Kinematics, hold_back: Span) -> f64 {
        let waits = self.waits(hold_back);
        let given = match &mut self.held_back {
            Some(held_back) if waits > Span::ZERO => held_back.begin_moving(set, waits),
            _ => {
                // Without power it may still have had one, whose shown position a stop would set the axis back to.
                self.release();
                *set
            }
        };
        // What it would have been given a dead time ago.
        let on_the_way = self.dead_time.min(hold_back);
        let position = given.position - given.velocity * on_the_way.as_secs_f64();
        self.power_on(position, given.velocity);
        self.course = SetCourse::from(&given);
        self.predicted = self.prediction(hold_back);
        position
    }

    pub(crate) fn reset(&mut self) {
        self.drive.reset();
        self.look();
    }

    /// Runs a cycle of the drive, which is to show the set values `hold_back` later. A hold-back begins where the axis
    /// `stands`.
    pub(crate) fn step(
        &mut self,
        set: &Kinematics,
        elapsed: Seconds,
        hold_back: Span,
        stands: bool,
    ) {
        let waits = self.waits(hold_back);
        let due = match &mut self.held_back {
            None => *set,
            Some(held_back) => held_back.step(set, elapsed.to_span(), waits, stands),
        };
        if self.dead_time > Span::ZERO {
            self.course.take(due.position, elapsed.0);
            self.predicted = self.prediction(hold_back);
        }
        self.drive.step(&self.predicted.unwrap_or(due), elapsed);
        self.look();
    }

    /// Predicts the set value that is due by what the hold-back lacks for the dead time; none if nothing is missing.
    fn prediction(&self, hold_back: Span) -> Option<Kinematics> {
        let missing = self.dead_time - hold_back;
        // An axis that changes its acceleration is off by its jerk times the cube of the time, by 6.
        (missing > Span::ZERO).then(|| self.course.newest.after(missing.as_secs_f64(), 0.0))
    }

    /// Time for which set values wait here, of the time after which they are to be shown.
    fn waits(&self, hold_back: Span) -> Span {
        (hold_back - self.dead_time).max(Span::ZERO)
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
