//! A program, flattened: running it needs neither recursion nor memory.

use std::num::NonZeroU32;

use coaxle_clock::Span;
use coaxle_curve::profile::Limits;
use coaxle_node::config::{AtLeastZero, AxisLimit};

use crate::config::{FollowersState, ProgramConfig, Repeat, StepConfig};

/// Instruction of a flat program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Instruction {
    Enable(bool),
    MoveAbsolute {
        position: f64,
        limits: Limits,
    },
    MoveRelative {
        distance: f64,
        limits: Limits,
    },
    Velocity {
        value: f64,
        keep: Span,
    },
    Halt,
    Dwell(Span),
    /// Waits until all followers are in sync.
    AwaitSync,
    /// Begins `passes` passes (none: endless) up to the matching end, counted at `depth`.
    LoopBegin {
        depth: usize,
        passes: Option<NonZeroU32>,
    },
    /// Ends a pass of the loop with its body at the instruction `body`.
    LoopEnd {
        depth: usize,
        body: usize,
    },
}

/// Returns the instructions of a program, and the depth of its loops: the whole counts as one, too.
pub(crate) fn compile(program: &ProgramConfig) -> (Vec<Instruction>, usize) {
    let mut compiler = Compiler {
        limits: program.limits.limits(),
        instructions: Vec::new(),
        depth: 0,
        deepest: 0,
    };
    let passes = match program.repeat {
        Repeat::Forever => None,
        Repeat::Times(count) => Some(count),
    };
    // The whole program is a loop like any other, so that repeating needs no rule of its own.
    compiler.repeated(passes, &program.steps);
    (compiler.instructions, compiler.deepest)
}

struct Compiler {
    limits: Limits,
    instructions: Vec<Instruction>,
    depth: usize,
    deepest: usize,
}

impl Compiler {
    fn repeated(&mut self, passes: Option<NonZeroU32>, steps: &[StepConfig]) {
        let depth = self.depth;
        self.depth += 1;
        self.deepest = self.deepest.max(self.depth);
        self.push(Instruction::LoopBegin { depth, passes });
        // Behind the begin, which sets the number of passes and must run once per loop only.
        let body = self.instructions.len();
        for step in steps {
            self.step(step);
        }
        self.push(Instruction::LoopEnd { depth, body });
        // Loops side by side share a counter: only one of them runs at a time.
        self.depth = depth;
    }

    fn step(&mut self, step: &StepConfig) {
        match step {
            StepConfig::Enable(true) => self.push(Instruction::Enable(true)),
            StepConfig::Enable(false) => {
                // `MC_Power` on a moving axis: a drive is switched off at rest.
                self.push(Instruction::Halt);
                self.push(Instruction::Enable(false));
            }
            StepConfig::MoveAbsolute { position, velocity } => {
                self.push(Instruction::MoveAbsolute {
                    position: position.get(),
                    limits: self.limits_of_move(*velocity),
                });
            }
            StepConfig::MoveRelative { distance, velocity } => {
                self.push(Instruction::MoveRelative {
                    distance: distance.get(),
                    limits: self.limits_of_move(*velocity),
                });
            }
            StepConfig::Velocity { value, for_s } => self.push(Instruction::Velocity {
                value: value.get(),
                keep: span(*for_s),
            }),
            StepConfig::Halt {} => self.push(Instruction::Halt),
            StepConfig::When {
                followers: FollowersState::InSync,
            } => self.push(Instruction::AwaitSync),
            StepConfig::Dwell { for_s } => self.push(Instruction::Dwell(span(*for_s))),
            StepConfig::Loop { count, steps } => self.repeated(Some(*count), steps),
        }
    }

    fn limits_of_move(&self, velocity: Option<AxisLimit>) -> Limits {
        match velocity {
            Some(velocity) => self
                .limits
                .with_velocity(velocity.get())
                // Guaranteed by its type.
                .expect("a positive number is a valid limit"),
            None => self.limits,
        }
    }

    fn push(&mut self, instruction: Instruction) {
        self.instructions.push(instruction);
    }
}

fn span(seconds: AtLeastZero) -> Span {
    Span::from_secs_f64(seconds.get())
}
