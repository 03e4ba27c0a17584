//! The commands of a program, until they have ended.

use coaxle_axis::{AxisStatus, Job};
use coaxle_slave::Command;

use super::outcome::{Outcome, Trouble};
use super::situation::Situation;

/// The commands of a program whose results are still needed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Commanded {
    /// The last command.
    last: Option<CommandedJob>,
    /// The command that moves the slave, or did so last; none once a foreign command has taken over.
    motion: Option<CommandedJob>,
    outcome: Option<Outcome>,
    /// Trouble that is not handled yet.
    trouble: Option<Trouble>,
    was_in_error: bool,
}

/// A job until its end.
#[derive(Clone, Copy, Debug)]
struct CommandedJob {
    job: Job,
    has_ended: bool,
}

impl CommandedJob {
    const fn new(job: Job) -> Self {
        Self {
            job,
            has_ended: false,
        }
    }

    /// Takes its end, once.
    fn end(&mut self, end_of: impl FnOnce(Job) -> Option<Outcome>) -> Option<Outcome> {
        if self.has_ended {
            return None;
        }
        let outcome = end_of(self.job)?;
        self.has_ended = true;
        Some(outcome)
    }
}

impl Commanded {
    /// Collects the results of the commands since the last scan. A foreign command that takes over
    /// from a completed one is trouble, unless the program waited for an order.
    pub(super) fn look(
        &mut self,
        now: &Situation<'_>,
        waited_for_order: bool,
        end_of: impl Fn(Job) -> Option<Outcome>,
    ) {
        if let Some(last) = self.last
            && now.motion == Some(last.job)
        {
            self.motion = Some(last);
        }
        // For another motion still under way, only trouble counts; done refers to the last command.
        let of_motion = self.motion.as_mut().and_then(|motion| motion.end(&end_of));
        if let Some(outcome) = of_motion.filter(|outcome| *outcome != Outcome::Done) {
            self.ended(outcome);
        }
        if let Some(outcome) = self.last.as_mut().and_then(|last| last.end(&end_of)) {
            self.ended(outcome);
        }
        self.look_who_moves(now, waited_for_order);
        let in_error = now.status == AxisStatus::ErrorStop;
        if in_error && !self.was_in_error {
            self.ended(Outcome::Failed);
        }
        self.was_in_error = in_error;
    }

    fn look_who_moves(&mut self, now: &Situation<'_>, waited_for_order: bool) {
        let Some(motion) = self.motion else {
            return;
        };
        if now.motion == Some(motion.job) {
            return;
        }
        self.motion = None;
        if self.trouble.is_none() && !waited_for_order {
            self.trouble = Some(Trouble::TakenOver);
        }
    }

    fn ended(&mut self, outcome: Outcome) {
        self.outcome = Some(outcome);
        if outcome != Outcome::Done {
            self.trouble = Some(Trouble::Outcome(outcome));
        }
    }

    /// Notes the job that coupled the slave from the start.
    pub(super) const fn started(&mut self, job: Job) {
        self.motion = Some(CommandedJob::new(job));
    }

    /// Notes an accepted command of the program.
    pub(super) const fn accepted(&mut self, command: &Command, job: Job) {
        match command {
            // The program itself ends the motion.
            Command::Power(false) => {
                self.last = None;
                self.motion = None;
            }
            Command::Reset {} => {}
            _ if job.number == 0 => return,
            _ => self.last = Some(CommandedJob::new(job)),
        }
        self.outcome = None;
        self.trouble = None;
    }

    /// Notes a refused command of the program, refused at once or when it was due.
    pub(super) fn refused(&mut self) {
        self.ended(Outcome::Refused);
    }

    /// Marks the trouble as handled.
    pub(super) const fn handled(&mut self) {
        self.trouble = None;
    }

    /// Trouble that is not handled yet.
    pub(super) const fn trouble(&self) -> Option<Trouble> {
        self.trouble
    }

    /// Result of the last command.
    pub(super) const fn outcome(&self) -> Option<Outcome> {
        self.outcome
    }

    /// True if a command has not ended.
    pub(super) fn is_busy(&self) -> bool {
        let is_under_way = |followed: &CommandedJob| !followed.has_ended;
        self.last.as_ref().is_some_and(is_under_way)
            || self.motion.as_ref().is_some_and(is_under_way)
    }
}
