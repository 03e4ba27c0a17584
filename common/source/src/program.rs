//! A virtual axis that runs a program.

mod active_motion;
mod goal;
mod planned_pieces;
mod reaction;

use std::collections::VecDeque;

use coaxle_axis::motion_plan::MotionPlan;
use coaxle_clock::Span;
use coaxle_curve::profile::{Kinematics, Limits, to_velocity};

use self::active_motion::ActiveMotion;
use self::goal::{Goal, RestOfProgram};
use self::planned_pieces::PlannedPieces;
use crate::config::{OnFailure, ProgramConfig};
use crate::followers::Followers;
use crate::instructions::{Instruction, compile};
use crate::source::{Activity, AxisSource, SourceSample};

/// Greatest number of instructions run in one cycle. A node that has slept through more of them catches
/// up over its next cycles.
const INSTRUCTIONS_PER_CYCLE: usize = 256;

/// Decisions that are taken ahead and have not begun: more of them wait.
// A plan has eight pieces at most, and a decision leads to one at least.
const MOST_AHEAD: usize = 8;

/// A virtual axis that runs a program.
///
/// It may take its decisions ahead, by a lead: what it will do until then is known and will not change
/// ([`AxisSource::plan`]). Its motion is the same at any lead, but for its reactions to followers, which come by the lead later.
#[derive(Debug)]
pub struct MotionProgram {
    limits: Limits,
    instructions: Vec<Instruction>,
    /// The passes in progress, by depth.
    passes: Vec<Pass>,
    /// The next instruction.
    next: usize,
    /// Time at which it is due.
    due: Span,
    /// The newest decision, …
    newest: Decision,
    /// … the one in force, and those between that have not begun.
    in_force: Decision,
    ahead: VecDeque<Decision>,
    /// Time by which decisions are taken ahead.
    lead: Span,
    /// Number of decisions.
    decisions: u64,
    /// End of the newest motion.
    goal: Goal,
    /// The followers, as far as it has reacted to them.
    followers: Followers,
    on_failure: OnFailure,
    keeps_their_limits: bool,
    hold: Hold,
}

/// Hold of a program by a follower that has failed.
#[derive(Clone, Copy, Debug)]
enum Hold {
    /// No hold: the program runs.
    Runs,
    /// Until the followers are well again.
    Halted(RestOfProgram),
    /// For good.
    Ended,
}

/// A pass through a loop.
#[derive(Clone, Copy, Debug, Default)]
struct Pass {
    began: Span,
    /// Remaining passes after it; none: endless.
    left: Option<u32>,
}

/// State of the axis from a time on.
#[derive(Clone, Copy, Debug)]
struct Decision {
    from: Span,
    motion: ActiveMotion,
    enabled: bool,
    command_number: u16,
}

impl MotionProgram {
    /// Makes the axis at the start of its program.
    #[must_use]
    pub fn new(config: &ProgramConfig) -> Self {
        let limits = config.limits.limits();
        let (instructions, depth) = compile(config);
        let start = Kinematics {
            velocity: config.start_velocity.get(),
            ..Kinematics::at_rest(config.start_position.get())
        };
        let moves = start.velocity != 0.0;
        let activity = if moves {
            Activity::Continuous
        } else {
            Activity::Idle
        };
        let first = Decision {
            from: Span::ZERO,
            motion: ActiveMotion {
                began: Span::ZERO,
                // A profile to its own velocity: moving on, or standing, needs no case of its own.
                profile: to_velocity(&start, start.velocity, &limits),
                under_way: activity,
                afterwards: activity,
            },
            enabled: moves,
            command_number: u16::from(moves),
        };
        Self {
            limits,
            instructions,
            passes: vec![Pass::default(); depth],
            next: 0,
            due: Span::ZERO,
            newest: first,
            in_force: first,
            ahead: VecDeque::new(),
            lead: Span::ZERO,
            decisions: 0,
            goal: match moves {
                true => Goal::Velocity {
                    value: start.velocity,
                },
                false => Goal::Rest,
            },
            followers: Followers::UNKNOWN,
            on_failure: OnFailure::Ignore,
            keeps_their_limits: false,
            hold: Hold::Runs,
        }
    }

    /// Takes decisions ahead by this time, or less if many follow each other.
    #[must_use]
    pub fn with_lead(mut self, lead: Span) -> Self {
        self.lead = lead.max(Span::ZERO);
        if self.lead > Span::ZERO {
            // And one reaction to followers, which does not wait.
            self.ahead.reserve_exact(MOST_AHEAD + 1);
        }
        self
    }

    /// Runs an instruction; true if it decides on the state of the axis.
    fn run(&mut self, instruction: Instruction) -> bool {
        match instruction {
            Instruction::Enable(enabled) => {
                self.newest.enabled = enabled;
                return true;
            }
            Instruction::MoveAbsolute { position, limits } => self.go_to(position, limits),
            Instruction::MoveRelative { distance, limits } => {
                // Where the axis is when the step is due, which lies between two cycles: steps do not wait for one.
                let from = self.newest.motion.at(self.due).position;
                self.go_to(from + distance, limits);
            }
            Instruction::Velocity { value, keep } => {
                self.command(Goal::Velocity { value });
                // Counted from the end of the ramp, at which the command has set the due time.
                self.due += keep;
            }
            Instruction::Halt => {
                let now = self.newest.motion.at(self.due);
                // A halt at rest is none: otherwise it would count as a command and change the state.
                if (now.velocity, now.acceleration) == (0.0, 0.0) {
                    return false;
                }
                self.command(Goal::Rest);
            }
            // Its due time was set when it was released.
            Instruction::AwaitSync => return false,
            Instruction::Dwell(time) => {
                self.due += time;
                return false;
            }
            Instruction::LoopBegin { depth, passes } => {
                self.passes[depth] = Pass {
                    began: self.due,
                    left: passes.map(|count| count.get() - 1),
                };
                return false;
            }
            Instruction::LoopEnd { depth, body } => {
                self.end_pass(depth, body);
                return false;
            }
        }
        true
    }

    fn go_to(&mut self, target: f64, limits: Limits) {
        self.command(Goal::Position { target, limits });
    }

    /// Begins a motion at the due time, which then is that of its end.
    fn command(&mut self, goal: Goal) {
        self.newest.command_number = self.newest.command_number.wrapping_add(1);
        self.start(goal, &self.limits());
    }

    fn start(&mut self, goal: Goal, limits: &Limits) {
        let now = self.newest.motion.at(self.due);
        let (under_way, afterwards) = match goal {
            Goal::Rest => (Activity::Halting, Activity::Halted),
            Goal::Position { .. } => (Activity::Positioning, Activity::InTarget),
            Goal::Velocity { .. } => (Activity::Continuous, Activity::Continuous),
        };
        self.goal = goal;
        self.newest.motion = ActiveMotion {
            began: self.due,
            profile: goal.profile(&now, limits),
            under_way,
            afterwards,
        };
        self.due = self.newest.motion.end();
    }

    /// Limits of its motions: its own, and those of its followers if it keeps them.
    fn limits(&self) -> Limits {
        match self.keeps_their_limits {
            true => self.limits.at_most(&self.followers.limits),
            false => self.limits,
        }
    }

    fn end_pass(&mut self, depth: usize, body: usize) {
        let pass = &mut self.passes[depth];
        pass.left = match pass.left {
            // The loop is done, and `next` is already the instruction behind it.
            Some(0) => return,
            // Endless: none stays none.
            left => left.map(|count| count - 1),
        };
        self.next = body;
        // A pass without duration lasts until the next cycle, or it would be run endlessly.
        if self.due == pass.began {
            self.due += Span::from_nanos(1);
        }
        pass.began = self.due;
    }

    /// Runs all instructions that are due in a cycle, and those ahead.
    fn decide(&mut self, since_start: Span) {
        while let Some(next) = self.ahead.front().filter(|next| next.from <= since_start) {
            self.in_force = *next;
            self.ahead.pop_front();
        }
        for _ in 0..INSTRUCTIONS_PER_CYCLE {
            let (Hold::Runs, Some(&instruction)) = (self.hold, self.instructions.get(self.next))
            else {
                return;
            };
            // Due times are exact and cycles are not: several instructions may be due in one cycle, or none.
            let is_due = self.due <= since_start;
            let may_be_ahead = self.ahead.len() < MOST_AHEAD && self.due <= since_start + self.lead;
            if !(is_due || may_be_ahead) {
                return;
            }
            if instruction == Instruction::AwaitSync {
                if !self.followers.are_in_sync {
                    return;
                }
                // The wait ends now: what follows may be promised from here on.
                self.due = self.due.max(since_start + self.lead);
            }
            self.next += 1;
            let from = self.due;
            if self.run(instruction) {
                self.newest.from = from;
                self.note_newest(since_start);
            }
        }
    }

    /// Notes the newest decision, which is in force at once if it is due.
    fn note_newest(&mut self, since_start: Span) {
        self.decisions = self.decisions.wrapping_add(1);
        if self.newest.from <= since_start {
            // None of those ahead of it can be later.
            self.ahead.clear();
            self.in_force = self.newest;
            return;
        }
        match self.ahead.back_mut() {
            // Decisions at one instant: the last one counts.
            Some(last) if last.from == self.newest.from => *last = self.newest,
            _ => self.ahead.push_back(self.newest),
        }
    }

    /// The instant until which all is decided.
    fn decided_until(&self, since_start: Span) -> Span {
        let horizon = since_start + self.lead;
        match (self.hold, self.instructions.get(self.next)) {
            // A wait ends by the lead later at the earliest.
            (Hold::Runs, Some(Instruction::AwaitSync)) => horizon,
            // An instruction that waits for room, or for the next cycle, takes effect when it is due.
            (Hold::Runs, Some(_)) => horizon.min(self.due),
            // As is any reaction to followers.
            _ => horizon,
        }
    }
}

impl AxisSource for MotionProgram {
    fn sample(&mut self, since_start: Span) -> SourceSample {
        self.decide(since_start);
        // After all instructions: the motion of the newest one, begun at its own time and not with the cycle.
        let Decision {
            motion,
            enabled,
            command_number,
            ..
        } = &self.in_force;
        let kinematics = motion.at(since_start);
        let activity = if motion.is_over(since_start) {
            motion.afterwards
        } else {
            motion.under_way
        };
        SourceSample {
            motion: kinematics,
            seen: kinematics,
            enabled: *enabled,
            activity,
            command_number: *command_number,
            target_position: match activity {
                // A constant velocity has no target, and its profile ends with the ramp.
                Activity::Continuous => kinematics.position,
                _ => motion.profile.end().position,
            },
        }
    }

    fn take_followers(&mut self, since_start: Span, followers: &Followers) {
        self.react(since_start, followers);
    }

    fn is_held(&self) -> bool {
        !matches!(self.hold, Hold::Runs)
    }

    fn decisions(&self) -> u64 {
        self.decisions
    }

    fn plan(&self, since_start: Span, origin: Span) -> Option<MotionPlan> {
        if self.lead == Span::ZERO {
            return None;
        }
        let ahead = self.ahead.iter();
        let motions = std::iter::once(&self.in_force).chain(ahead);
        let motions = motions.map(|decision| &decision.motion);
        let decided_until = self.decided_until(since_start);
        let pieces = PlannedPieces::of(motions, since_start, decided_until);
        pieces.plan(origin, &self.limits)
    }
}
