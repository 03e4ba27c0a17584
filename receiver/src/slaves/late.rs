//! Commands that were accepted and can still be refused when they are due.

use coaxle_motion::plc::CommandState;
use coaxle_motion::saw::SawFault;
use coaxle_motion::slave::{Accepted, Refusal, SlaveAxis, SlaveError};

/// Who gave a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// The slave's program.
    Program,
    /// Anybody else.
    Outside,
}

/// The newest accepted commands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Late {
    waiting: [Option<(Accepted, Origin)>; MOST],
    next: usize,
}

const MOST: usize = 8;

impl Late {
    pub(super) const fn remember(&mut self, accepted: Accepted, origin: Origin) {
        self.waiting[self.next] = Some((accepted, origin));
        self.next = (self.next + 1) % MOST;
    }

    /// A command that has been refused now.
    pub(super) fn refused(&mut self, axis: &SlaveAxis) -> Option<(Refusal, Origin)> {
        let mut found = None;
        for place in &mut self.waiting {
            let Some((accepted, origin)) = *place else {
                continue;
            };
            match fate(axis, accepted) {
                Fate::Open => {}
                Fate::Done => *place = None,
                Fate::Refused(refusal) => {
                    *place = None;
                    found = Some((refusal, origin));
                }
            }
        }
        found
    }
}

enum Fate {
    Open,
    Done,
    Refused(Refusal),
}

fn fate(axis: &SlaveAxis, accepted: Accepted) -> Fate {
    match accepted {
        Accepted::AtOnce => Fate::Done,
        Accepted::Job(number) => match axis.progress(number) {
            CommandState::Waiting | CommandState::Active => Fate::Open,
            // An axis in error stop says more than its command.
            CommandState::Failed(SlaveError::Cam(error)) if axis.error().is_none() => {
                Fate::Refused(error.into())
            }
            CommandState::Failed(SlaveError::Saw(SawFault::Refused(refusal)))
                if axis.error().is_none() =>
            {
                Fate::Refused(refusal.into())
            }
            _ => Fate::Done,
        },
        Accepted::Change(ticket) => match axis.change_progress(ticket) {
            CommandState::Waiting | CommandState::Active => Fate::Open,
            CommandState::Failed(error) if axis.error().is_none() => Fate::Refused(error.into()),
            _ => Fate::Done,
        },
    }
}
