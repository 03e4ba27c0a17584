//! The command line that all programs share: arguments of a node and of a client, the log, durations, the exit code.

mod network_args;
mod node_args;

use std::io::{IsTerminal, Write};
use std::process::{Command, ExitCode};

use coaxle_clock::Span;
use coaxle_os::exit::{Exit, exit_of, lines_of};
use coaxle_os::{Os, System};
use tracing_appender::non_blocking::WorkerGuard;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::filter::{FilterExt, LevelFilter, Targets};
use tracing_subscriber::layer::{Filter, Layer, SubscriberExt};
use tracing_subscriber::registry::LookupSpan;
use tracing_subscriber::util::SubscriberInitExt;

use crate::machine::needs::Needs;
use crate::network::transport::ZENOH_RUNTIME;
use crate::node::audit;

pub use network_args::NetworkArgs;
pub use node_args::{NodeArgs, report_valid};

/// Log verbosity; flatten it into the arguments of a program.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct LogArgs {
    /// Log more; twice for everything. RUST_LOG has the last word, except about the audit
    #[arg(short, long, action = clap::ArgAction::Count, global = true)]
    pub verbose: u8,
    /// Log errors only, and the audit: who was refused what, and who did what
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
}

/// Logging guard: flushes the remaining lines when dropped.
#[must_use]
pub struct Logging {
    _writer: WorkerGuard,
}

impl LogArgs {
    /// Starts logging to standard error, until the result is dropped. Only the first call in a process has an effect.
    ///
    /// A separate thread writes, so no caller waits for a log that is full, closed or not read.
    /// Lines without room are dropped.
    pub fn init(self) -> Logging {
        let wish = std::env::var("RUST_LOG").ok();
        let (writer, guard) = tracing_appender::non_blocking(std::io::stderr());
        let lines = tracing_subscriber::fmt::layer()
            .with_writer(writer)
            // Standard error may be closed: an error about that, written to standard error, would panic.
            .log_internal_errors(false)
            .with_ansi(std::io::stderr().is_terminal())
            // The target names the module, which says something to people who look for a fault only.
            .with_target(self.verbose > 0)
            .with_filter(self.admitted(wish.as_deref()));
        // A second call in the process, as in tests, is refused by the global subscriber, and changes nothing.
        let _ = tracing_subscriber::registry().with(lines).try_init();
        Logging { _writer: guard }
    }

    /// Lines that are written: those that the options or RUST_LOG ask for, and the audit whatever they ask for.
    fn admitted<S>(self, wish: Option<&str>) -> impl Filter<S> + use<S>
    where
        S: tracing::Subscriber + for<'a> LookupSpan<'a>,
    {
        let wished = match wish {
            Some(wish) if !wish.is_empty() => EnvFilter::new(wish),
            _ => EnvFilter::new(self.filter()),
        };
        // An operator who silences a node must not silence who was refused what.
        let audit = Targets::new().with_target(audit::LOG, LevelFilter::INFO);
        audit.or(wished)
    }

    /// Zenoh's own lines repeat at every connection attempt, and end a node's log with errors (`unknown expr_id`) that are none. The
    /// nodes report each fault once, with its remedy. The library of OPC UA has some lines for each connection.
    fn filter(self) -> &'static str {
        match (self.quiet, self.verbose) {
            (true, _) => "error,zenoh=off,opcua=off",
            (false, 0) => "info,zenoh=off,opcua=warn,opcua_core=off",
            (false, 1) => "debug,zenoh=warn,opcua=info",
            (false, _) => "trace,zenoh=debug",
        }
    }
}

/// Prints an error as one line, from the outermost context to the cause, and returns the exit code.
/// Pending log lines are written first. For a config, every mistake has a line.
#[must_use]
pub fn exit_code(result: anyhow::Result<Exit>, logging: Logging) -> ExitCode {
    // Dropping it flushes. The error line would otherwise stand before the last lines of the log.
    drop(logging);
    let exit = result.unwrap_or_else(|error| {
        // Each line has a prefix of its own, so that a search for "error:" finds every mistake of a config.
        // An error is ignored here: standard error may be closed.
        for line in lines_of(&error) {
            let _ = writeln!(std::io::stderr(), "error: {line}");
        }
        exit_of(&error)
    });
    ExitCode::from(exit as u8)
}

/// Runs a program, as the only call in its `main`: with the threads of the transport as in [`ZENOH_RUNTIME`], and only if
/// the system gives what any program needs.
pub fn run_program(program: impl FnOnce() -> ExitCode) -> ExitCode {
    tune_transport();
    if let Err(missing) = Needs::PROGRAM.check() {
        // Before there is a log, which needs memory and a thread.
        let _ = writeln!(std::io::stderr(), "error: {missing}");
        return ExitCode::from(Exit::Failed as u8);
    }
    program()
}

/// Restarts the calling program with Zenoh's threads set as in [`ZENOH_RUNTIME`], unless the
/// environment sets them already.
///
/// Zenoh reads only the environment for this, and a program cannot safely change its own. The
/// process, its id, its arguments and its open files stay the same. Where a restart is not possible
/// the program continues with Zenoh's defaults.
fn tune_transport() {
    let (name, value) = ZENOH_RUNTIME;
    // An operator's own setting wins. The second start ends here, too: otherwise the program would restart for ever.
    if std::env::var_os(name).is_some() {
        return;
    }
    // Without a path there is nothing to restart: the settings are worth 26 % of the latency, not the start of the node.
    let Ok(program) = std::env::current_exe() else {
        return;
    };
    let mut command = Command::new(program);
    // The first argument is the name of the program, which the new call has already.
    command.args(std::env::args_os().skip(1)).env(name, value);
    // Returns only if it failed.
    let _ = Os::replace_this_process(&mut command);
}

/// Parses `10s`, `500ms`, `250us`, `2min` or `1h`, for clap's `value_parser`.
///
/// A number without a unit is refused: `--max-error 50` meant microseconds to its writer, and passed as 50 s before a motion.
///
/// # Errors
/// The text received and the expected form.
pub fn parse_duration(text: &str) -> Result<Span, BadDuration> {
    let bad = || BadDuration {
        received: text.to_owned(),
    };
    let trimmed = text.trim();
    let number_len = trimmed
        // A sign, an exponent, or `inf` and `nan` are no digits: `parse` alone would accept all of them.
        .find(|c: char| !(c.is_ascii_digit() || c == '.'))
        .unwrap_or(trimmed.len());
    let (number, unit) = trimmed.split_at(number_len);
    let seconds_per_unit = match unit.trim() {
        "us" | "µs" => 1e-6,
        "ms" => 1e-3,
        "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(bad()),
    };
    let number: f64 = number.parse().map_err(|_| bad())?;
    // Out-of-range numbers saturate, so that the comparison with the bounds below finds them.
    let span = Span::from_secs_f64(number * seconds_per_unit);
    // A duration of zero would end a run before its first cycle, and one of the greatest span never.
    if span > Span::ZERO && span < Span::MAX {
        Ok(span)
    } else {
        Err(bad())
    }
}

/// A text that is not a duration.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "received {received:?}, expected a duration above zero with its unit, such as 10s, 500ms, 250us, 2min or 1h"
)]
pub struct BadDuration {
    received: String,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use coaxle_node::config::ConfigError;
    use coaxle_os::exit::NodeNotFound;
    use std::sync::{Arc, Mutex};

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
            // A fraction of an hour: 1.5 · 3600 s.
            ("1.5h", Span::from_secs(5400)),
            (" 0.5 s ", Span::from_millis(500)),
        ] {
            assert_eq!(parse_duration(text), Ok(span), "{text}");
        }
    }

    #[test]
    fn what_is_no_duration_is_quoted() {
        for text in [
            // No number, no unit, a unit without a number, an unknown unit, a sign, zero, two points, and two that no span holds.
            "",
            "50",
            "0.5",
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
    fn no_option_and_no_wish_silences_the_audit() {
        for (quiet, wish) in [
            (true, None),
            (false, Some("off")),
            (false, Some("audit=off")),
            (true, Some("error,audit=error")),
            (false, Some("coaxle_host=debug")),
        ] {
            let written = Written::default();
            let args = LogArgs { verbose: 0, quiet };
            let writer = written.clone();
            let lines = tracing_subscriber::fmt::layer()
                .with_writer(move || writer.clone())
                .with_filter(args.admitted(wish));
            let subscriber = tracing_subscriber::registry().with(lines);
            tracing::subscriber::with_default(subscriber, || {
                tracing::info!(target: audit::LOG, "audit 1: on record");
                tracing::info!(target: "elsewhere", "chat");
            });
            let text = written.text();
            assert!(
                text.contains("audit 1: on record"),
                "{quiet} {wish:?}: {text}"
            );
            assert!(!text.contains("chat"), "{quiet} {wish:?}: {text}");
        }
    }

    /// Lines that were written.
    #[derive(Clone, Default)]
    struct Written(Arc<Mutex<Vec<u8>>>);

    impl Written {
        fn text(&self) -> String {
            String::from_utf8_lossy(&self.0.lock().unwrap()).into_owned()
        }
    }

    impl Write for Written {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn an_error_fails_the_program() {
        let code = |result| exit_code(result, LogArgs::default().init());
        assert_eq!(code(Ok(Exit::Done)), ExitCode::SUCCESS);
        assert_eq!(code(Ok(Exit::NoData)), ExitCode::from(5));
        assert_eq!(code(Err(anyhow::anyhow!("no"))), ExitCode::FAILURE);
        let wrong = ConfigError::whole("a.toml", "no").into();
        // 78 is EX_CONFIG of sysexits.h, by which a service manager sees that a restart does not help.
        assert_eq!(code(Err(wrong)), ExitCode::from(78));
        assert_eq!(
            code(Err(NodeNotFound("saw".to_owned()).into())),
            ExitCode::from(5)
        );
        assert_eq!(Exit::NotMet.done_if(true), Exit::Done);
        assert_eq!(Exit::NotMet.done_if(false), Exit::NotMet);
    }
}
