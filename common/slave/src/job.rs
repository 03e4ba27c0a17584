//! The jobs of a slave axis: the current motion, and the ended ones.

mod ended;

use coaxle_axis::{CommandState, Job, Origin};

use super::error::SlaveError;
use super::refusal::Refusal;
use ended::EndedJobs;

/// Reason why a job ended without success.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum JobError {
    /// Refused, at once or when it was due. The axis continues without it.
    #[error(transparent)]
    Refused(Refusal),
    /// Failed while it was busy.
    #[error(transparent)]
    Failed(SlaveError),
}

impl JobError {
    /// NC error code.
    #[must_use]
    pub fn code(&self) -> u32 {
        match self {
            Self::Refused(refusal) => refusal.code(),
            Self::Failed(error) => error.code(),
        }
    }
}

impl From<Refusal> for JobError {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

/// State of a job.
pub type JobState = CommandState<JobError>;

/// A job that has come to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndedJob {
    /// The job.
    pub job: Job,
    /// End state: done, aborted or failed.
    pub state: JobState,
}

/// The job that moves the axis, and those that have ended.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Jobs {
    last_number: u32,
    /// Current or last job of motion.
    motion: Option<Job>,
    state: JobState,
    ended: EndedJobs,
    /// Number of the last job aborted because its master ran back; 0: none.
    rolled_back: u32,
}

impl Jobs {
    /// Creates a job with a number of its own.
    pub(super) fn number(&mut self, command: &'static str, origin: Origin) -> Job {
        // 0 means: completed at once.
        self.last_number = self.last_number.checked_add(1).unwrap_or(1);
        Job {
            number: self.last_number,
            command,
            origin,
        }
    }

    /// Creates a job that is completed on acceptance: it neither takes over nor has to be kept.
    pub(super) const fn at_once(command: &'static str, origin: Origin) -> Job {
        Job {
            number: 0,
            command,
            origin,
        }
    }

    /// Makes this the job that moves the axis.
    pub(super) fn replace(&mut self, job: Job, state: JobState) {
        if let Some(before) = self.motion
            && self.is_busy()
        {
            // The end of the old job comes first, as a reader expects them.
            self.end(before, CommandState::Aborted);
        }
        self.motion = Some(job);
        self.state = state;
        if is_end(&state) {
            self.end(job, state);
        }
    }

    /// Sets the state of the job that moves the axis, unless it has already ended.
    pub(super) fn set(&mut self, state: JobState) {
        // A job ends once: later states of the motion are none of the job's.
        if !self.is_busy() {
            return;
        }
        self.state = state;
        if let Some(job) = self.motion
            && is_end(&state)
        {
            self.end(job, state);
        }
    }

    /// Aborts the job that moves the axis because its master has run back, unless it has already ended.
    pub(super) fn roll_back(&mut self) {
        if self.is_busy() {
            self.rolled_back = self.motion.map_or(0, |job| job.number);
            self.set(CommandState::Aborted);
        }
    }

    /// True if a job was aborted by a roll-back.
    pub(super) const fn was_rolled_back(&self, job: Job) -> bool {
        // Jobs that are done at once share the number 0.
        job.number != 0 && self.rolled_back == job.number
    }

    /// Notes the end of a job.
    pub(super) fn end(&mut self, job: Job, state: JobState) {
        self.ended.push(job, state);
    }

    /// Takes the next ended job.
    pub(super) fn take_ended(&mut self) -> Option<EndedJob> {
        self.ended.take()
    }

    pub(super) const fn is_busy(&self) -> bool {
        matches!(
            self.state,
            CommandState::Waiting | CommandState::Active | CommandState::InSync
        )
    }

    pub(super) const fn motion(&self) -> (Option<Job>, JobState) {
        (self.motion, self.state)
    }

    /// State of a job that moves the axis or has ended recently.
    pub(super) fn progress(&self, job: Job) -> Option<JobState> {
        if job.number == 0 {
            return Some(CommandState::Done);
        }
        if self.motion == Some(job) {
            return Some(self.state);
        }
        self.ended.state_of(job)
    }
}

const fn is_end(state: &JobState) -> bool {
    matches!(
        state,
        CommandState::Done | CommandState::Aborted | CommandState::Failed(_)
    )
}
