//! How far a command is, whoever takes it.

/// What has become of a command.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CommandState<E> {
    /// Nothing was commanded.
    #[default]
    Idle,
    /// Accepted, not yet in control of the axis.
    Waiting,
    /// In control of the axis, not yet where it is meant to be.
    Active,
    /// Following its master.
    InSync,
    /// Finished.
    Done,
    /// Another command, or the end of the coupling, cut it short.
    Aborted,
    /// Refused or broken off.
    Failed(E),
}

impl<E> CommandState<E> {
    /// The same state, with an error of another kind.
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
