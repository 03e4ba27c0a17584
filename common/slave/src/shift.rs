//! An added motion over time, from one offset to another.

use coaxle_axis::{CommandState, Job};
use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Profile};

use crate::job::{JobState, Jobs};

/// An offset that moves from one value to another, and stays there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shift {
    course: Option<ActiveShift>,
    now: Kinematics,
}

#[derive(Clone, Copy, Debug)]
struct ActiveShift {
    profile: Profile,
    since: Seconds,
    job: Job,
}

impl Shift {
    /// No offset.
    pub(super) const NONE: Self = Self {
        course: None,
        now: Kinematics::at_rest(0.0),
    };

    /// The current offset.
    pub(super) const fn now(&self) -> &Kinematics {
        &self.now
    }

    /// The offset at its end.
    pub(super) fn end(&self) -> Kinematics {
        self.course
            .as_ref()
            .map_or(self.now, |course| course.profile.end())
    }

    /// True if there is an offset, or will be.
    pub(super) fn is_active(&self) -> bool {
        // A shift that leads back to 0 is one until it has arrived.
        self.course.is_some() || self.now.position != 0.0
    }

    pub(super) const fn is_under_way(&self) -> bool {
        self.course.is_some()
    }

    /// Starts along a profile that begins with the current offset.
    pub(super) fn start(&mut self, profile: Profile, job: Job, jobs: &mut Jobs) {
        self.abort(jobs);
        self.course = Some(ActiveShift {
            profile,
            since: Seconds::ZERO,
            job,
        });
    }

    /// Runs one cycle.
    pub(super) fn advance(&mut self, elapsed: Seconds, jobs: &mut Jobs) {
        let Some(course) = &mut self.course else {
            return;
        };
        course.since = course.since + elapsed;
        // Beyond its duration a profile stays at its end, so that the last cycle needs no case of its own.
        self.now = course.profile.at(course.since);
        if course.since >= course.profile.duration() {
            jobs.end(course.job, CommandState::Done);
            self.course = None;
        }
    }

    /// Drops the offset, which has become part of another motion.
    pub(super) fn drop(&mut self, state: JobState, jobs: &mut Jobs) {
        if let Some(course) = self.course.take() {
            jobs.end(course.job, state);
        }
        // The next motion begins in set values that contain the offset. Kept, it would count twice.
        self.now = Kinematics::at_rest(0.0);
    }

    fn abort(&mut self, jobs: &mut Jobs) {
        if let Some(course) = self.course.take() {
            jobs.end(course.job, CommandState::Aborted);
        }
    }

    /// State of its job, while it lasts.
    pub(super) fn progress(&self, job: Job) -> Option<JobState> {
        let course = self.course.as_ref()?;
        (course.job == job).then_some(CommandState::Active)
    }
}

/// The sum of two motions; the first one bit for bit if there is no other.
pub(super) fn plus(motion: Kinematics, added: Option<Kinematics>) -> Kinematics {
    match added {
        // A sum with zeros would change the sign of a zero: what passes is to pass to the bit.
        None => motion,
        Some(added) => sum(&motion, &added),
    }
}

/// A motion without the one added to it.
pub(super) fn minus(motion: &Kinematics, added: &Kinematics) -> Kinematics {
    Kinematics {
        position: motion.position - added.position,
        velocity: motion.velocity - added.velocity,
        acceleration: motion.acceleration - added.acceleration,
    }
}

/// The sum of two motions.
pub(super) fn sum(one: &Kinematics, other: &Kinematics) -> Kinematics {
    Kinematics {
        position: one.position + other.position,
        velocity: one.velocity + other.velocity,
        acceleration: one.acceleration + other.acceleration,
    }
}
