//! What the binaries share: the log, durations on the command line, errors and exit codes.

use std::io::{IsTerminal, Write};
use std::process::{Command, ExitCode};

use coaxle_clock::Span;
use coaxle_node::cam_file::CamFileError;
use coaxle_node::config::ConfigError;
use coaxle_node::one_line;
use coaxle_node::text_file::{Unreadable, remedy};
use tracing_appender::non_blocking::WorkerGuard;
use tracing_subscriber::EnvFilter;

use crate::os::{Os, System};
use crate::transport::ZENOH_RUNTIME;

/// How much a program logs; flatten it into its arguments.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct LogArgs {
    /// Log more; twice for everything. RUST_LOG has the last word
    #[arg(short, long, action = clap::ArgAction::Count, global = true)]
    pub verbose: u8,
    /// Log errors only
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
}

/// Logging: what is left is written when it is dropped.
#[must_use]
pub struct Logging {
    _writer: WorkerGuard,
}

impl LogArgs {
    /// Starts logging to standard error, until the result is dropped. Only the first call in a process has an effect.
    ///
    /// A thread of its own writes: nobody waits for a log that is full, closed or not read. What there is no room for is
    /// dropped.
    pub fn init(self) -> Logging {
        let filter = match std::env::var("RUST_LOG") {
            Ok(wish) if !wish.is_empty() => EnvFilter::new(wish),
            _ => EnvFilter::new(self.filter()),
        };
        let (writer, guard) = tracing_appender::non_blocking(std::io::stderr());
        let _ = tracing_subscriber::fmt()
            .with_env_filter(filter)
            .with_writer(writer)
            .log_internal_errors(false)
            .with_ansi(std::io::stderr().is_terminal())
            .with_target(self.verbose > 0)
            .try_init();
        Logging { _writer: guard }
    }

    /// Zenoh's own warnings repeat at every attempt to connect what the nodes say once.
    fn filter(self) -> &'static str {
        match (self.quiet, self.verbose) {
            (true, _) => "error",
            (false, 0) => "info,zenoh=error",
            (false, 1) => "debug,zenoh=warn",
            (false, _) => "trace,zenoh=debug",
        }
    }
}

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

/// The exit codes, for `--help`.
pub const EXIT_CODES: &str = "Exit codes: 0 done; 1 could not (network, port, disk); 2 wrong command line; \
    3 an expectation was not met; 4 refused; 5 no data came; 78 a config or file is wrong or missing; 130 interrupted";

impl Exit {
    /// This one where something did not go as it should.
    #[must_use]
    pub const fn unless(self, good: bool) -> Self {
        if good { Self::Done } else { self }
    }
}

/// Prints an error as one line, from the outermost context to the cause, and gives the exit code. What was logged comes
/// before it. Of a config every mistake has a line.
#[must_use]
pub fn exit_code(result: anyhow::Result<Exit>, logging: Logging) -> ExitCode {
    drop(logging);
    let exit = result.unwrap_or_else(|error| {
        // With standard error closed there is nobody left to tell.
        for line in lines_of(&error) {
            let _ = writeln!(std::io::stderr(), "error: {line}");
        }
        exit_of(&error)
    });
    ExitCode::from(exit as u8)
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

/// Starts the calling program anew with Zenoh's threads shared out as [`ZENOH_RUNTIME`] says,
/// unless the environment has an opinion already. To be called first in `main`.
///
/// Zenoh reads nothing but the environment for this, and a program cannot safely change its own.
/// The process, its id, its arguments and its open files stay the same. Where starting anew is not
/// possible the program goes on with Zenoh's defaults.
pub fn tune_transport() {
    let (name, value) = ZENOH_RUNTIME;
    if std::env::var_os(name).is_some() {
        return;
    }
    let Ok(program) = std::env::current_exe() else {
        return;
    };
    let mut command = Command::new(program);
    command.args(std::env::args_os().skip(1)).env(name, value);
    // Returns only if it failed.
    let _ = Os::replace_this_process(&mut command);
}

/// Parses `10s`, `500ms`, `250us`, `2min`, `1h`, or plain seconds, for clap's `value_parser`.
///
/// # Errors
/// Says what was received and what is expected.
pub fn parse_duration(text: &str) -> Result<Span, BadDuration> {
    let bad = || BadDuration {
        received: text.to_owned(),
    };
    let trimmed = text.trim();
    let number_len = trimmed
        .find(|c: char| !(c.is_ascii_digit() || c == '.'))
        .unwrap_or(trimmed.len());
    let (number, unit) = trimmed.split_at(number_len);
    let seconds_per_unit = match unit.trim() {
        "us" | "µs" => 1e-6,
        "ms" => 1e-3,
        "" | "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(bad()),
    };
    let number: f64 = number.parse().map_err(|_| bad())?;
    let span = Span::from_secs_f64(number * seconds_per_unit);
    if span > Span::ZERO && span < Span::MAX {
        Ok(span)
    } else {
        Err(bad())
    }
}

/// A text that is no duration.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "received {received:?}, expected a duration above zero such as 10s, 500ms, 2min, 1h, or plain \
     seconds"
)]
pub struct BadDuration {
    received: String,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Args {
        #[command(flatten)]
        log: LogArgs,
        #[arg(long = "for", value_parser = parse_duration)]
        run_for: Option<Span>,
    }

    #[test]
    fn durations_have_units() {
        for (text, span) in [
            ("10s", Span::from_secs(10)),
            ("500ms", Span::from_millis(500)),
            ("250us", Span::from_micros(250)),
            ("2min", Span::from_secs(120)),
            ("1.5h", Span::from_secs(5400)),
            ("3", Span::from_secs(3)),
            (" 0.5 s ", Span::from_millis(500)),
        ] {
            assert_eq!(parse_duration(text), Ok(span), "{text}");
        }
    }

    #[test]
    fn what_is_no_duration_is_quoted() {
        for text in [
            "",
            "s",
            "10 parsecs",
            "-3s",
            "0s",
            "1.2.3s",
            "1e400h",
            "99999999999h",
        ] {
            let error = parse_duration(text).unwrap_err().to_string();
            assert!(error.contains(&format!("{text:?}")), "{error}");
            assert!(error.contains("500ms"), "{error}");
        }
    }

    #[test]
    fn the_command_line_takes_them() {
        let args = Args::try_parse_from(["x", "-vv", "--for", "2s"]).unwrap();
        assert_eq!(
            (args.log.verbose, args.run_for),
            (2, Some(Span::from_secs(2)))
        );
        let error = Args::try_parse_from(["x", "--for", "soon"]).err().unwrap();
        assert!(error.to_string().contains("received \"soon\""), "{error}");
        assert!(Args::try_parse_from(["x", "-q", "-v"]).is_err());
    }

    #[test]
    fn an_error_fails_the_program() {
        let code = |result| exit_code(result, LogArgs::default().init());
        assert_eq!(code(Ok(Exit::Done)), ExitCode::SUCCESS);
        assert_eq!(code(Ok(Exit::NoData)), ExitCode::from(5));
        assert_eq!(code(Err(anyhow::anyhow!("no"))), ExitCode::FAILURE);
        let wrong = ConfigError::whole("a.toml", "no").into();
        assert_eq!(code(Err(wrong)), ExitCode::from(78));
        assert_eq!(
            code(Err(NotThere("saw".to_owned()).into())),
            ExitCode::from(5)
        );
        assert_eq!(Exit::NotMet.unless(true), Exit::Done);
        assert_eq!(Exit::NotMet.unless(false), Exit::NotMet);
    }
}
