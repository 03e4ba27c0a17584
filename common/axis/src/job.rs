//! Accepted commands, whose progress can be followed to their end.

use core::fmt;

/// An accepted command. Two jobs of an axis with equal numbers are identical, until 4 billion
/// others have been accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Job {
    /// Number among the jobs of its axis, from 1; 0 for a command that was completed on acceptance,
    /// so that there is nothing to follow.
    pub number: u32,
    /// The command, by its PLC name.
    pub command: &'static str,
    /// Origin of the command.
    pub origin: Origin,
}

/// Origin of a command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Origin {
    /// Coupling from the start.
    Start,
    /// The program that the axis belongs to.
    #[default]
    Program,
    /// An order from outside.
    Order,
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Start => "from the start",
            Self::Program => "of the program",
            Self::Order => "of an order",
        })
    }
}

impl fmt::Display for Job {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            number,
            command,
            origin,
        } = self;
        write!(f, "{command} {origin}, job {number}")
    }
}
