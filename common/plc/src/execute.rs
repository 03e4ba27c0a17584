//! The PLC interface of a command: one state inside, levels, edges and booleans only here.
//!
//! A block's behaviour is in plain `start(command) -> Result` and `update(..)` functions. This module
//! holds the rest of a PLC function block: the rising edge of `Execute`, and the outputs `Busy`,
//! `Active`, `InSync`, `Done`, `CommandAborted`, `Error`, `ErrorID`, all derived from one
//! [`CommandState`].

use coaxle_axis::CommandState;

/// The outputs of a PLC function block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// The command is in progress.
    #[doc(alias = "Busy")]
    pub busy: bool,
    /// The command controls the axis.
    #[doc(alias = "Active")]
    pub active: bool,
    /// The slave follows its master.
    #[doc(alias = "InSync")]
    #[doc(alias = "InGear")]
    #[doc(alias = "InVelocity")]
    pub in_sync: bool,
    /// The command is finished.
    #[doc(alias = "Done")]
    pub done: bool,
    /// The command was aborted.
    #[doc(alias = "CommandAborted")]
    pub command_aborted: bool,
    /// The command failed.
    #[doc(alias = "Error")]
    pub error: bool,
    /// NC error code of a failed command, 0 = none.
    #[doc(alias = "ErrorID")]
    pub error_id: u32,
}

impl Outputs {
    /// Makes the outputs of a command; `code` returns an error's number.
    #[must_use]
    pub fn of<E>(state: &CommandState<E>, code: impl FnOnce(&E) -> u32) -> Self {
        let off = Self::default();
        match state {
            CommandState::Idle => off,
            // Outputs exclude each other as in PLCopen, except Busy, Active and InSync of a command in progress.
            CommandState::Waiting => Self { busy: true, ..off },
            CommandState::Active => Self {
                busy: true,
                active: true,
                ..off
            },
            CommandState::InSync => Self {
                busy: true,
                active: true,
                in_sync: true,
                ..off
            },
            CommandState::Done => Self { done: true, ..off },
            CommandState::Aborted => Self {
                command_aborted: true,
                ..off
            },
            CommandState::Failed(error) => Self {
                error: true,
                error_id: code(error),
                ..off
            },
        }
    }
}

/// The `Execute` input of a block: `K` names a command in progress, `E` is its error.
///
/// A rising edge starts the command with the inputs of that scan. Results stay on the outputs while
/// `Execute` is held, and for at least one scan if it fell before. The falling edge never affects the
/// command itself.
#[derive(Clone, Copy, Debug)]
pub struct Execute<K, E> {
    level: bool,
    command: Option<K>,
    state: CommandState<E>,
    result_shown: bool,
}

impl<K, E> Default for Execute<K, E> {
    fn default() -> Self {
        Self {
            level: false,
            command: None,
            state: CommandState::Idle,
            result_shown: false,
        }
    }
}

impl<K, E> Execute<K, E> {
    /// Runs one scan of the block: `start` is called on the rising edge, `state` for a command in
    /// progress; both get the commanded `axis`, of any type.
    pub fn scan<A>(
        &mut self,
        execute: bool,
        axis: &mut A,
        start: impl FnOnce(&mut A) -> Result<K, E>,
        state: impl FnOnce(&A, &K) -> CommandState<E>,
    ) -> &CommandState<E> {
        let rising = execute && !self.level;
        self.level = execute;
        // A rising edge before the results: it ends their display, even if they were never read.
        if rising {
            self.result_shown = false;
            match start(axis) {
                Ok(command) => self.command = Some(command),
                Err(error) => {
                    // The previous command goes on in the axis, but this block shows the refusal.
                    self.command = None;
                    self.state = CommandState::Failed(error);
                }
            }
        // Only after one scan with the result: a short pulse of Execute would otherwise miss it.
        } else if self.result_shown && !execute {
            self.command = None;
            self.state = CommandState::Idle;
        }
        // In the starting scan too: a command that is done at once shows Done at once.
        if let Some(command) = &self.command {
            self.state = state(axis, command);
        }
        self.result_shown |= is_result(&self.state);
        &self.state
    }

    /// Returns the state of the command.
    pub const fn state(&self) -> &CommandState<E> {
        &self.state
    }
}

/// True if a fallen `Execute` clears the state, once it has been shown.
const fn is_result<E>(state: &CommandState<E>) -> bool {
    !matches!(
        state,
        // InSync counts as a result: a fallen Execute clears the outputs, and the coupling
        // goes on.
        CommandState::Idle | CommandState::Waiting | CommandState::Active
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// A command that takes `left` scans.
    struct Axis {
        left: u32,
        starts: u32,
    }

    fn run(executes: &[bool], takes: u32) -> Vec<CommandState<u32>> {
        let mut axis = Axis { left: 0, starts: 0 };
        let mut block = Execute::default();
        executes
            .iter()
            .map(|&execute| {
                let state = *block.scan(
                    execute,
                    &mut axis,
                    |axis| {
                        axis.starts += 1;
                        axis.left = takes;
                        Ok::<u32, u32>(axis.starts)
                    },
                    |axis, _| match axis.left {
                        0 => CommandState::Done,
                        _ => CommandState::Active,
                    },
                );
                axis.left = axis.left.saturating_sub(1);
                state
            })
            .collect()
    }

    #[test]
    fn a_pulse_of_one_scan_still_shows_the_result_for_one_scan() {
        use CommandState::{Active, Done, Idle};
        assert_eq!(run(&[true, false, false], 0), [Done, Idle, Idle]);
        assert_eq!(
            run(&[true, false, false, false], 2),
            [Active, Active, Done, Idle]
        );
    }

    #[test]
    fn a_held_execute_holds_the_result_and_starts_but_once() {
        use CommandState::{Active, Done, Idle};
        assert_eq!(
            run(&[false, true, true, true, false, true], 1),
            [Idle, Active, Done, Done, Idle, Active]
        );
    }

    #[test]
    fn a_refusal_stays_while_execute_is_held() {
        let mut block = Execute::<u32, u32>::default();
        let mut scan = |execute| {
            let state = block.scan(
                execute,
                &mut (),
                |()| Err(0x4b04),
                |(), _| CommandState::Idle,
            );
            Outputs::of(state, |code| *code)
        };
        let failed = Outputs {
            error: true,
            error_id: 0x4b04,
            ..Outputs::default()
        };
        assert_eq!(scan(true), failed);
        assert_eq!(scan(true), failed);
        assert_eq!(scan(false), Outputs::default());
    }

    #[test]
    fn done_and_error_never_show_together() {
        let states = [
            CommandState::Idle,
            CommandState::Waiting,
            CommandState::Active,
            CommandState::InSync,
            CommandState::Done,
            CommandState::Aborted,
            CommandState::Failed(7),
        ];
        for state in states {
            let o = Outputs::of(&state, |code| *code);
            let results = [o.done, o.command_aborted, o.error, o.busy];
            assert!(
                results.into_iter().filter(|on| *on).count() <= 1,
                "{state:?}"
            );
            assert_eq!(o.error, o.error_id != 0);
        }
    }
}
