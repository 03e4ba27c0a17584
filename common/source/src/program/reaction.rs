//! Reactions of a program to its followers: a coupled stop, its end, and limits that change.

use coaxle_clock::Span;

use super::goal::{Goal, RestOfProgram};
use super::{Hold, MOST_AHEAD, MotionProgram};
use crate::config::{FollowersConfig, OnFailure};
use crate::followers::Followers;

impl MotionProgram {
    /// Reacts to the followers of the axis, as its config says.
    #[must_use]
    pub fn with_followers(mut self, config: &FollowersConfig) -> Self {
        self.on_failure = config.on_failure;
        self.keeps_their_limits = config.keep_limits;
        self
    }

    /// Reacts to the state of the followers. What it has promised stays as it is: a reaction takes effect by the lead later.
    pub(super) fn react(&mut self, since_start: Span, followers: &Followers) {
        if *followers == self.followers {
            return;
        }
        // With the state that was known until now.
        self.decide(since_start);
        // As many decisions wait as a plan has pieces. The reaction comes when there is room: nothing is noted until then.
        if self.ahead.len() >= MOST_AHEAD {
            return;
        }
        let before = std::mem::replace(&mut self.followers, *followers);
        let from = since_start + self.lead;
        let fail = followers.have_failed && self.on_failure != OnFailure::Ignore;
        let are_limits_new = self.keeps_their_limits && before.limits != followers.limits;
        let is_changed = match self.hold {
            Hold::Runs if fail => self.interrupt(from),
            Hold::Runs if are_limits_new => self.plan_again(from),
            Hold::Halted(rest) if !fail => self.go_on(rest, from),
            Hold::Runs | Hold::Halted(_) | Hold::Ended => false,
        };
        if is_changed {
            self.newest.from = from;
            self.note_newest(since_start);
        }
    }

    /// Ramps down as fast as the slowest follower can: in sync with all that have not failed.
    fn interrupt(&mut self, from: Span) -> bool {
        let rest = self.interrupted(from);
        self.hold = match self.on_failure == OnFailure::Halt {
            true => Hold::Halted(rest),
            false => Hold::Ended,
        };
        let now = self.newest.motion.at(from);
        if (now.velocity, now.acceleration) == (0.0, 0.0) {
            return false;
        }
        self.due = from;
        self.newest.command_number = self.newest.command_number.wrapping_add(1);
        self.start(Goal::Rest, &self.limits.at_most(&self.followers.limits));
        true
    }

    /// Goes on with what was interrupted.
    fn go_on(&mut self, rest: RestOfProgram, from: Span) -> bool {
        self.hold = Hold::Runs;
        let moves = !matches!(rest.goal, Goal::Rest);
        if moves {
            self.due = from;
            self.command(rest.goal);
        } else {
            // The stop of the interruption may still be under way.
            self.due = from.max(self.newest.motion.end());
        }
        self.due += rest.pause;
        moves
    }

    /// Plans the motion in progress within other limits.
    fn plan_again(&mut self, from: Span) -> bool {
        let RestOfProgram { goal, pause } = self.interrupted(from);
        if matches!(goal, Goal::Rest) {
            return false;
        }
        self.due = from;
        self.start(goal, &self.limits());
        self.due += pause;
        true
    }

    /// Rest of the newest motion at an instant.
    fn interrupted(&self, from: Span) -> RestOfProgram {
        let motion = &self.newest.motion;
        let goal = match self.goal {
            Goal::Position { .. } if motion.is_over(from) => Goal::Rest,
            goal => goal,
        };
        let pause = self.due - from.max(motion.end());
        RestOfProgram {
            goal,
            pause: pause.max(Span::ZERO),
        }
    }
}
