//! Exit codes of a program, and mistakes of users.

use coaxle_node::config::ConfigError;
use coaxle_node::one_line;
use coaxle_node::text_file::{Unreadable, remedy};

/// End of a program, as its exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Success.
    Done = 0,
    /// Failure of the network, a port, a disk or a thread. Other errors end like this, too.
    Failed = 1,
    /// Wrong command line, also as found by clap.
    WrongCommandLine = 2,
    /// Completed, with an expectation not met.
    NotMet = 3,
    /// Refused command, without any motion.
    Refused = 4,
    /// End of a node's configured time without any data from the nodes it follows.
    NoData = 5,
    /// A config or another input file that is wrong or missing. It will be so the next time, too, so a
    /// restart is of no use. `EX_CONFIG` of sysexits.h, as known to service managers.
    WrongConfig = 78,
    /// Ctrl-C or SIGTERM before the end: its results are those up to then.
    Interrupted = 130,
}

/// Error of a named node that is not there: with the nodes present, or the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NodeNotFound(pub String);

/// Unusable input of a user: the value received, and the value expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text}")]
pub struct Mistake {
    text: String,
    exit: Exit,
}

impl Exit {
    /// Returns `Done` if `good`, else this one.
    #[must_use]
    pub const fn done_if(self, good: bool) -> Self {
        if good { Self::Done } else { self }
    }
}

impl Mistake {
    /// Makes a mistake in an argument of the command line.
    #[must_use]
    pub fn in_argument(text: impl Into<String>) -> Self {
        let exit = Exit::WrongCommandLine;
        let text = text.into();
        Self { text, exit }
    }

    /// Makes a mistake in a file that is read.
    #[must_use]
    pub fn in_file(text: impl Into<String>) -> Self {
        let exit = Exit::WrongConfig;
        let text = text.into();
        Self { text, exit }
    }
}

/// Returns the exit code of a program that ended with this error.
#[must_use]
pub fn exit_of(error: &anyhow::Error) -> Exit {
    let is = |test: fn(&(dyn std::error::Error + 'static)) -> bool| error.chain().any(test);
    // Any depth of the chain: contexts are added on the way up, and the mistake is the innermost.
    let mistake = (error.chain()).find_map(|cause| cause.downcast_ref::<Mistake>());
    if let Some(mistake) = mistake {
        mistake.exit
    } else if error.downcast_ref::<NodeNotFound>().is_some() {
        Exit::NoData
    } else if is(|cause| cause.is::<ConfigError>() || cause.is::<Unreadable>()) {
        Exit::WrongConfig
    } else {
        Exit::Failed
    }
}

/// Fails with a [`Mistake::in_argument`].
///
/// # Errors
/// Always.
pub fn wrong_argument<T>(text: impl Into<String>) -> anyhow::Result<T> {
    Err(Mistake::in_argument(text).into())
}

/// Fails with a [`Mistake::in_file`].
///
/// # Errors
/// Always.
pub fn wrong_file<T>(text: impl Into<String>) -> anyhow::Result<T> {
    Err(Mistake::in_file(text).into())
}

/// Returns the lines of an error: one for each mistake in a config, otherwise one with all of the causes.
#[must_use]
pub fn lines_of(error: &anyhow::Error) -> Vec<String> {
    match error.downcast_ref::<ConfigError>() {
        Some(config) => config.lines(),
        None => {
            // The remedy belongs to the error of the system, which is below the contexts.
            let by_system = error.chain().find_map(|cause| cause.downcast_ref());
            vec![one_line(&format!(
                "{error:#}{}",
                by_system.map_or("", remedy)
            ))]
        }
    }
}

/// The exit codes, for `--help`.
pub const EXIT_CODES: &str = "Exit codes: 0 done; 1 could not (network, port, disk); 2 wrong command line; \
    3 an expectation was not met; 4 refused; 5 no data came; 78 a config or file is wrong or missing; 130 interrupted";
