//! How a program ends: exit codes, and mistakes of users.

use coaxle_node::cam_file::CamFileError;
use coaxle_node::config::ConfigError;
use coaxle_node::one_line;
use coaxle_node::text_file::{Unreadable, remedy};

/// How a program ended, as its exit code says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// As it should.
    Done = 0,
    /// It could not do its work: the network, a port, a disk, a thread. So do errors.
    Failed = 1,
    /// The command line is wrong. What clap finds wrong itself ends so, too.
    WrongCommandLine = 2,
    /// It did its work, and an expectation was not met.
    NotMet = 3,
    /// What it was to do was refused, and nothing moved.
    Refused = 4,
    /// A node's time was up, and nothing had come of any node it follows.
    NoData = 5,
    /// A config, or another file that it was to read, is wrong or not there: it is the next time, too, so that nobody need
    /// start it again. `EX_CONFIG` of sysexits.h, as service managers know it.
    WrongConfig = 78,
    /// Ctrl-C or SIGTERM came before it was done: what it left is of the time before.
    Interrupted = 130,
}

/// A node that was asked for is not there: who is, or why not.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NotThere(pub String);

/// Something that a user gave and that nothing can be done with: what was received, and what is expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text}")]
pub struct Mistake {
    text: String,
    exit: Exit,
}

impl Exit {
    /// This one where something did not go as it should.
    #[must_use]
    pub const fn unless(self, good: bool) -> Self {
        if good { Self::Done } else { self }
    }
}

impl Mistake {
    /// In an argument of the command line.
    #[must_use]
    pub fn in_argument(text: impl Into<String>) -> Self {
        let exit = Exit::WrongCommandLine;
        let text = text.into();
        Self { text, exit }
    }

    /// In a file that is read.
    #[must_use]
    pub fn in_file(text: impl Into<String>) -> Self {
        let exit = Exit::WrongConfig;
        let text = text.into();
        Self { text, exit }
    }
}

/// How a program ends that ended with this error.
#[must_use]
pub fn exit_of(error: &anyhow::Error) -> Exit {
    let is = |test: fn(&(dyn std::error::Error + 'static)) -> bool| error.chain().any(test);
    let mistake = (error.chain()).find_map(|cause| cause.downcast_ref::<Mistake>());
    if let Some(mistake) = mistake {
        mistake.exit
    } else if error.downcast_ref::<NotThere>().is_some() {
        Exit::NoData
    } else if is(|cause| {
        cause.is::<ConfigError>() || cause.is::<Unreadable>() || cause.is::<CamFileError>()
    }) {
        Exit::WrongConfig
    } else {
        Exit::Failed
    }
}

/// A [`Mistake::in_argument`].
///
/// # Errors
/// Always.
pub fn wrong_argument<T>(text: impl Into<String>) -> anyhow::Result<T> {
    Err(Mistake::in_argument(text).into())
}

/// A [`Mistake::in_file`].
///
/// # Errors
/// Always.
pub fn wrong_file<T>(text: impl Into<String>) -> anyhow::Result<T> {
    Err(Mistake::in_file(text).into())
}

/// What is wrong: a line for each mistake in a config, otherwise one with all of the causes.
#[must_use]
pub fn lines_of(error: &anyhow::Error) -> Vec<String> {
    match error.downcast_ref::<ConfigError>() {
        Some(config) => config.lines(),
        None => {
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
