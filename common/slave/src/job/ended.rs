//! The last ended jobs of a slave axis, in few bytes.

use coaxle_axis::{CommandState, Job};

use super::{EndedJob, JobError, JobState};

/// Number of ended jobs that are kept: all that can end in a cycle.
// A job ends once. Those that a cycle finds are the motion, a phasing and a superimposed motion; those that it begins are of 16 orders
// and a program.
const KEPT: usize = 3 + 16 + 1;

/// Number of jobs whose error is kept: all that can fail in a cycle.
// The motion, a phasing and a superimposed motion fail together, after a coupling was refused when it was due. With an error in each
// of the twenty the axis would take 2 KB more.
const KEPT_ERRORS: usize = 4;

/// The last ended jobs, in the order of their ends.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct EndedJobs {
    jobs: [Option<Job>; KEPT],
    ends: [JobEnd; KEPT],
    /// Index of the next ended job.
    next: u8,
    /// Number of ended jobs that were not taken.
    untaken: u8,
    /// The last errors, and the numbers of their jobs.
    errors: [Option<(u32, JobError)>; KEPT_ERRORS],
    next_error: u8,
}

/// End of a job.
#[derive(Clone, Copy, Debug, Default)]
enum JobEnd {
    Done,
    #[default]
    Aborted,
    /// Its error is kept with its number.
    Failed,
}

impl EndedJobs {
    /// Adds a job that has ended.
    pub(super) fn push(&mut self, job: Job, state: JobState) {
        let place = usize::from(self.next);
        self.jobs[place] = Some(job);
        self.ends[place] = match state {
            CommandState::Done => JobEnd::Done,
            CommandState::Failed(error) => {
                self.errors[usize::from(self.next_error)] = Some((job.number, error));
                self.next_error = (self.next_error + 1) % KEPT_ERRORS as u8;
                JobEnd::Failed
            }
            _ => JobEnd::Aborted,
        };
        self.next = (self.next + 1) % KEPT as u8;
        // More than are kept have overwritten the oldest.
        self.untaken = (self.untaken + 1).min(KEPT as u8);
    }

    /// Takes the next job that has ended, the oldest first.
    pub(super) fn take(&mut self) -> Option<EndedJob> {
        // The oldest that was not taken. The addend keeps the difference from falling below 0.
        let place = usize::from(self.next) + KEPT - usize::from(self.untaken);
        self.untaken = self.untaken.checked_sub(1)?;
        self.at(place % KEPT)
    }

    /// End state of a job; none if it ended too long ago.
    pub(super) fn state_of(&self, job: Job) -> Option<JobState> {
        let place = self.jobs.iter().position(|ended| *ended == Some(job))?;
        self.at(place).map(|ended| ended.state)
    }

    fn at(&self, place: usize) -> Option<EndedJob> {
        let job = self.jobs[place]?;
        let state = match self.ends[place] {
            JobEnd::Done => CommandState::Done,
            JobEnd::Aborted => CommandState::Aborted,
            JobEnd::Failed => {
                let mut errors = self.errors.iter().flatten();
                let (_, error) = errors.find(|(number, _)| *number == job.number)?;
                CommandState::Failed(*error)
            }
        };
        Some(EndedJob { job, state })
    }
}
