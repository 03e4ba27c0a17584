//! The commands that a program has given, until they have come to their end.

use coaxle_axis::{AxisStatus, Job};
use coaxle_slave::Command;

use super::condition::Situation;
use super::outcome::{Outcome, Trouble};

/// The commands that a program has given, as far as it still has to know of them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Commanded {
    /// The one given last.
    last: Option<Followed>,
    /// The one that moves the slave, or did so last; none once somebody else's has taken over.
    motion: Option<Followed>,
    outcome: Option<Outcome>,
    /// What nothing has been done about yet.
    trouble: Option<Trouble>,
    was_in_error: bool,
}

/// A job until its end.
#[derive(Clone, Copy, Debug)]
struct Followed {
    job: Job,
    has_ended: bool,
}

impl Followed {
    const fn new(job: Job) -> Self {
        Self {
            job,
            has_ended: false,
        }
    }

    /// Its end, once.
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
    /// What became of them since the last scan. Another command that takes over from one that is done is
    /// trouble, unless an order was waited for.
    pub(super) fn look(
        &mut self,
        now: &Situation,
        waited_for_order: bool,
        end_of: impl Fn(Job) -> Option<Outcome>,
    ) {
        if let Some(last) = self.last
            && now.motion == Some(last.job)
        {
            self.motion = Some(last);
        }
        // Of what goes on beside, only trouble counts: done is the command given last.
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

    fn look_who_moves(&mut self, now: &Situation, waited_for_order: bool) {
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

    /// The slave was coupled by this from the start.
    pub(super) const fn started(&mut self, job: Job) {
        self.motion = Some(Followed::new(job));
    }

    /// A command of the program was accepted.
    pub(super) const fn accepted(&mut self, command: &Command, job: Job) {
        match command {
            // What was moving the slave ends by its own doing.
            Command::Power(false) => {
                self.last = None;
                self.motion = None;
            }
            Command::Reset {} => {}
            _ if job.number == 0 => return,
            _ => self.last = Some(Followed::new(job)),
        }
        self.outcome = None;
        self.trouble = None;
    }

    /// A command of the program was refused: at once, or when it was due.
    pub(super) fn refused(&mut self) {
        self.ended(Outcome::Refused);
    }

    /// The program does something about the trouble.
    pub(super) const fn handled(&mut self) {
        self.trouble = None;
    }

    /// What nothing has been done about yet.
    pub(super) const fn trouble(&self) -> Option<Trouble> {
        self.trouble
    }

    /// What became of the command given last.
    pub(super) const fn outcome(&self) -> Option<Outcome> {
        self.outcome
    }

    /// Whether one of them has not come to its end.
    pub(super) fn is_busy(&self) -> bool {
        let is_under_way = |followed: &Followed| !followed.has_ended;
        self.last.as_ref().is_some_and(is_under_way)
            || self.motion.as_ref().is_some_and(is_under_way)
    }
}
