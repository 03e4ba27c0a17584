//! `coaxle sweep`.

use std::io::{IsTerminal, Write};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use clap::Args;
use coaxle_clock::Instant;
use coaxle_lab::catalog;
use coaxle_lab::finished::Progress;
use coaxle_lab::junit::{self, JunitCase};
use coaxle_lab::shell::{in_quotes, word};
use coaxle_lab::sweep::{MOST_RUNS, Options, Prepared, Setup, SweepAxis, SweepProgress, prepare};
use coaxle_os::exit::Exit;
use coaxle_os::machine::{self, Machine};
use coaxle_report::inspect::print_text;
use coaxle_report::sweep::{self, SweepOutcome};
use coaxle_trials::Bar;

/// Arguments of a sweep.
#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    /// Name of a built-in scenario, or path of a TOML file
    scenario: String,
    /// A field and its values: path.to.field=a,b,c. Several span a grid [default: the scenario's own]
    #[arg(long = "over", value_name = "PATH=VALUES")]
    over: Vec<SweepAxis>,
    /// With how many seeds to run each point: the scenario's and those that follow it. Tables have median, 5 % and 95 % quantile
    /// and the worst
    #[arg(long, value_name = "N", default_value = "1", value_parser = seeds)]
    seeds: NonZeroUsize,
    /// Set a field of the scenario at all points: path.to.field=value
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Only these receivers, and those they follow
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    receivers: Vec<String>,
    /// The figure to plot, as points.csv names it without its unit, such as slave.cut_length_error_max [default: that, the time error,
    /// or the next best]
    #[arg(long, value_name = "NAME")]
    figure: Option<String>,
    /// Folder for the results; points there of this very sweep are not run again [default: out/SCENARIO-sweep]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Run everything again, even if the folder holds another sweep
    #[arg(long)]
    fresh: bool,
    /// Write a report in JUnit's format: a case for each point
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
}

fn seeds(text: &str) -> Result<NonZeroUsize, String> {
    let seeds = text.parse().ok();
    let seeds = seeds.filter(|seeds: &NonZeroUsize| seeds.get() <= MOST_RUNS);
    seeds.ok_or_else(|| format!("received {text}, expected 1 to {MOST_RUNS}"))
}

/// Sweeps, prints the table and says where the rest is.
///
/// # Errors
/// Those of [`prepare`] and [`Prepared::run`], and a report that cannot be written.
pub(crate) fn run(args: &SweepArgs) -> anyhow::Result<Exit> {
    let suite = format!("sweep {}", args.scenario);
    // Also of an error: otherwise a build server finds no report at all.
    junit::report_error(args.junit.as_deref(), &suite, sweep(args))
}

fn sweep(args: &SweepArgs) -> anyhow::Result<Exit> {
    let source = catalog::find(&args.scenario)?;
    let prepared = prepare(&source, &args.setup())?;
    let default_out = || PathBuf::from("out").join(format!("{}-sweep", source.name));
    let options = Options {
        out: args.out.clone().unwrap_or_else(default_out),
        is_fresh: args.fresh,
        figure: args.figure.clone(),
    };
    let begin = machine::now();
    let outcome = run_with_progress(&prepared, &options, &args.command())?;
    if let Some(path) = &args.junit {
        let suite = format!("sweep {}", source.name);
        let took = machine::now() - begin;
        junit::write(path, &suite, took.as_secs_f64(), cases(&outcome))?;
    }
    print_text(&results_text(&outcome, args.seeds))?;
    if !outcome.is_whole() {
        let (over, all) = outcome.runs;
        tracing::warn!(
            "interrupted: the results are of {over} of {all} runs; the same command goes on with the others"
        );
        return Ok(Exit::Interrupted);
    }
    Ok(Exit::NotMet.done_if(outcome.failed().next().is_none()))
}

impl SweepArgs {
    fn setup(&self) -> Setup {
        Setup {
            axes: self.over.clone(),
            overrides: self.overrides.clone(),
            receivers: self.receivers.clone(),
            seeds: self.seeds,
        }
    }

    /// The command that repeats it, but for the folder.
    fn command(&self) -> String {
        let mut words = vec![format!("coaxle sweep {}", word(&self.scenario))];
        // In quotes: values may hold brackets and blanks, which a shell would take apart.
        words.extend(self.over.iter().map(|axis| {
            let over = format!("{}={}", axis.field, axis.values.join(","));
            format!("--over {}", in_quotes(&over))
        }));
        // Defaults are left out, so that the command is as the user would type it.
        if self.seeds.get() > 1 {
            words.push(format!("--seeds {}", self.seeds));
        }
        words.extend((self.overrides.iter()).map(|set| format!("--set {}", in_quotes(set))));
        if !self.receivers.is_empty() {
            words.push(format!("--receivers {}", word(&self.receivers.join(","))));
        }
        words.extend((self.figure.iter()).map(|figure| format!("--figure {}", word(figure))));
        words.join(" ")
    }
}

/// A case of the report for each point that was run.
fn cases(outcome: &SweepOutcome) -> impl Iterator<Item = JunitCase> {
    outcome.points.iter().map(|point| {
        let lines: Vec<_> = (point.failures.iter())
            .map(|(seed, line)| format!("seed {seed}: {line}"))
            .collect();
        JunitCase {
            name: point.name.clone(),
            failure: lines.first().map(|first| junit::JunitFailure {
                message: first.clone(),
                text: lines.join("\n"),
            }),
        }
    })
}

/// Greatest number of lines printed of unexpected results.
const MOST_LINES: usize = 20;

/// The results for a person.
fn results_text(outcome: &SweepOutcome, seeds: NonZeroUsize) -> String {
    let mut text = outcome.table.clone();
    if seeds.get() > 1 {
        text += &format!("\n\nmedians of {seeds} seeds");
    }
    text += &expectations(outcome);
    let tables: Vec<_> = (outcome.tables.iter())
        .map(|path| path.display().to_string())
        .collect();
    text += &format!("\n\ntables: {}", tables.join(", "));
    if let Some(plot) = &outcome.plot {
        text += &format!("\nplot: {}", plot.display());
    }
    text + &format!("\nreport: {}", outcome.report.display())
}

/// Empty if nothing was expected.
fn expectations(outcome: &SweepOutcome) -> String {
    let (points, failed) = (outcome.points.len(), outcome.failed().count());
    // "All points as expected" would be wrong without any expectation.
    if outcome.points.iter().all(|point| point.judged == 0) {
        return String::new();
    }
    let lines: Vec<_> = outcome
        .failed()
        .flat_map(|point| {
            let name = &point.name;
            let failures = point.failures.iter();
            failures.map(move |(seed, line)| format!("FAILED {name}, seed {seed}: {line}"))
        })
        .collect();
    let mut text = format!("\n\n{} of {points} points as expected", points - failed);
    for line in lines.iter().take(MOST_LINES) {
        text += &format!("\n{line}");
    }
    if let Some(more @ 1..) = lines.len().checked_sub(MOST_LINES) {
        text += &format!("\nand {more} more, which the report has");
    }
    text
}

fn run_with_progress(
    prepared: &Prepared,
    options: &Options,
    command: &str,
) -> anyhow::Result<SweepOutcome> {
    // Progress is reported by several threads.
    let bar = Mutex::new(Bar::new("of the grid".to_owned())?);
    let is_terminal = std::io::stderr().is_terminal();
    let lines = Mutex::new(ProgressLines::new());
    let outcome = sweep::run(prepared, options, command, &|so_far| {
        // A bar in a log file would be thousands of lines.
        if !is_terminal {
            let line = (lines.lock().unwrap_or_else(PoisonError::into_inner)).of(so_far);
            // A failure to write it is ignored.
            let _ = line.map(|line| writeln!(std::io::stderr(), "{line}"));
        }
        (bar.lock().unwrap_or_else(PoisonError::into_inner)).at(so_far.share)
    });
    bar.into_inner()
        .unwrap_or_else(PoisonError::into_inner)
        .clear();
    outcome
}

/// Lines of progress, where there is no terminal.
struct ProgressLines {
    begin: Instant<Machine>,
    /// Last part printed, in twentieths of the runs.
    part: Option<usize>,
}

impl ProgressLines {
    fn new() -> Self {
        Self {
            begin: machine::now(),
            part: None,
        }
    }

    /// A line for every twentieth part.
    fn of(&mut self, so_far: &SweepProgress) -> Option<String> {
        let SweepProgress {
            runs,
            kept,
            done,
            failed,
            share,
        } = *so_far;
        let missing = runs - kept;
        // Without a missing run the division has no result, and all is done.
        let part = (20 * done).checked_div(missing).unwrap_or(20);
        if self.part.is_some_and(|told| told >= part) {
            return None;
        }
        // The first line comes before anything is done, and has no rate as yet.
        if self.part.replace(part).is_none() {
            let of_before = match kept {
                0 => String::new(),
                kept => format!(", {kept} of them are in the folder already"),
            };
            return Some(format!("runs: {runs}{of_before}"));
        }
        let took = (machine::now() - self.begin).as_secs_f64();
        // By the share, which weighs the running ones as well, and not by whole runs.
        let (rate, left) = (done as f64 / took, took / share * (1.0 - share));
        let over = kept + done;
        Some(format!(
            "{over:7} of {runs}, {failed} failed, {rate:.2} a second, {left:.0} s to go"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        sweep: SweepArgs,
    }

    #[test]
    fn the_command_is_quoted_for_a_shell() {
        let words = [
            "",
            "my saw.toml",
            "--over",
            "receiver.mode='sync',0",
            "--set",
            "x=[1, 2]",
            "--receivers",
            "saw,press",
            "--figure",
            "slave.cut_length_error_max",
        ];
        let Line { sweep } = Line::try_parse_from(words).unwrap();
        assert_eq!(
            sweep.command(),
            r"coaxle sweep 'my saw.toml' --over 'receiver.mode='\''sync'\'',0' --set 'x=[1, 2]' --receivers saw,press --figure slave.cut_length_error_max"
        );
    }
}
