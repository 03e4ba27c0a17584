//! Progress of a command.

/// State of a command.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CommandState<E> {
    /// No command.
    #[default]
    Idle,
    /// Accepted, not yet in control of the axis.
    Waiting,
    /// In control of the axis, not yet at its goal.
    Active,
    /// Following its master.
    InSync,
    /// Finished.
    Done,
    /// Aborted by another command, or by the end of the coupling.
    Aborted,
    /// Refused or failed.
    Failed(E),
}

impl<E> CommandState<E> {
    /// Converts the error of the state.
    pub fn map_error<F>(self, of: impl FnOnce(E) -> F) -> CommandState<F> {
        match self {
            Self::Idle => CommandState::Idle,
            Self::Waiting => CommandState::Waiting,
            Self::Active => CommandState::Active,
            Self::InSync => CommandState::InSync,
            Self::Done => CommandState::Done,
            Self::Aborted => CommandState::Aborted,
            Self::Failed(error) => CommandState::Failed(of(error)),
        }
    }
}
