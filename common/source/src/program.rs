//! A virtual axis that runs a program.

use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::{Kinematics, Limits, Profile, to_position, to_velocity};

use crate::config::ProgramConfig;
use crate::instructions::{Instruction, compile};
use crate::source::{Activity, AxisSource, SourceSample};

/// Greatest number of instructions run in one cycle. A node that has slept through more of them catches
/// up over its next cycles.
const INSTRUCTIONS_PER_CYCLE: usize = 256;

/// A virtual axis that runs a program.
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
    motion: ActiveMotion,
    enabled: bool,
    command_number: u16,
}

/// A pass through a loop.
#[derive(Clone, Copy, Debug, Default)]
struct Pass {
    began: Span,
    /// Remaining passes after it; none: endless.
    left: Option<u32>,
}

/// The motion in progress, and the state that it leaves.
#[derive(Clone, Copy, Debug)]
struct ActiveMotion {
    began: Span,
    profile: Profile,
    under_way: Activity,
    afterwards: Activity,
}

impl ActiveMotion {
    fn is_over(&self, at: Span) -> bool {
        Seconds::from(at - self.began) >= self.profile.duration()
    }

    fn at(&self, at: Span) -> Kinematics {
        self.profile.at(Seconds::from(at - self.began))
    }

    /// Returns the first nanosecond at which it is certainly over.
    fn end(&self) -> Span {
        // Rounded up and one more: at a rounded-down end the profile would be a fraction of a nanosecond from its
        // target.
        let nanos = (self.profile.duration().0 * 1e9).ceil();
        // A motion without duration takes no time at all, not one nanosecond.
        if nanos > 0.0 {
            self.began + Span::from_nanos(nanos as i64) + Span::from_nanos(1)
        } else {
            self.began
        }
    }
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
        Self {
            limits,
            instructions,
            passes: vec![Pass::default(); depth],
            next: 0,
            due: Span::ZERO,
            motion: ActiveMotion {
                began: Span::ZERO,
                // A profile to its own velocity: moving on, or standing, needs no case of its own.
                profile: to_velocity(&start, start.velocity, &limits),
                under_way: activity,
                afterwards: activity,
            },
            enabled: moves,
            command_number: u16::from(moves),
        }
    }

    fn run(&mut self, instruction: Instruction) {
        match instruction {
            Instruction::Enable(enabled) => self.enabled = enabled,
            Instruction::MoveAbsolute { position, limits } => self.go_to(position, &limits),
            Instruction::MoveRelative { distance, limits } => {
                // Where the axis is when the step is due, which lies between two cycles: steps do not wait for one.
                let from = self.motion.at(self.due).position;
                self.go_to(from + distance, &limits);
            }
            Instruction::Velocity { value, keep } => {
                let profile = to_velocity(&self.motion.at(self.due), value, &self.limits);
                self.start(profile, Activity::Continuous, Activity::Continuous);
                // Counted from the end of the ramp, at which `start` has set the due time.
                self.due += keep;
            }
            Instruction::Halt => {
                let now = self.motion.at(self.due);
                // A halt at rest is none: otherwise it would count as a command and change the state.
                if (now.velocity, now.acceleration) != (0.0, 0.0) {
                    let profile = to_velocity(&now, 0.0, &self.limits);
                    self.start(profile, Activity::Halting, Activity::Halted);
                }
            }
            Instruction::Dwell(time) => self.due += time,
            Instruction::LoopBegin { depth, passes } => {
                self.passes[depth] = Pass {
                    began: self.due,
                    left: passes.map(|count| count.get() - 1),
                };
            }
            Instruction::LoopEnd { depth, body } => self.end_pass(depth, body),
        }
    }

    fn go_to(&mut self, target: f64, limits: &Limits) {
        let profile = to_position(&self.motion.at(self.due), target, limits);
        self.start(profile, Activity::Positioning, Activity::InTarget);
    }

    fn start(&mut self, profile: Profile, under_way: Activity, afterwards: Activity) {
        self.motion = ActiveMotion {
            began: self.due,
            profile,
            under_way,
            afterwards,
        };
        self.due = self.motion.end();
        self.command_number = self.command_number.wrapping_add(1);
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
}

impl AxisSource for MotionProgram {
    fn sample(&mut self, since_start: Span) -> SourceSample {
        for _ in 0..INSTRUCTIONS_PER_CYCLE {
            let Some(&instruction) = self.instructions.get(self.next) else {
                break;
            };
            // Due times are exact and cycles are not: several instructions may be due in one cycle, or none.
            if self.due > since_start {
                break;
            }
            self.next += 1;
            self.run(instruction);
        }
        // After all instructions: the motion of the newest one, begun at its own time and not with the cycle.
        let kinematics = self.motion.at(since_start);
        let activity = if self.motion.is_over(since_start) {
            self.motion.afterwards
        } else {
            self.motion.under_way
        };
        SourceSample {
            motion: kinematics,
            seen: kinematics,
            enabled: self.enabled,
            activity,
            command_number: self.command_number,
            target_position: match activity {
                // A constant velocity has no target, and its profile ends with the ramp.
                Activity::Continuous => kinematics.position,
                _ => self.motion.profile.end().position,
            },
        }
    }
}
