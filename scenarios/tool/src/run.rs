//! `coaxle run SCENARIO`: a scenario in virtual time, or with real processes.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use coaxle_lab::catalog;
use coaxle_lab::junit::{self, JunitCase};
use coaxle_lab::run::{Options, TraceFormat, prepare, trace_warning};
use coaxle_lab::shell::{in_quotes, word};
use coaxle_lab::stage::{Stage, VirtualTime};
use coaxle_lab::summary::World;
use coaxle_lab::verdict::Verdict;
use coaxle_os::exit::Exit;
use coaxle_os::machine;
use coaxle_report::inspect::print_text;
use coaxle_report::print::COLUMN_MM;
use coaxle_report::reported::{self, Outcome, Presentation};
use coaxle_report::table;
use coaxle_trials::Bar;
use coaxle_trials::processes::Processes;

/// The scenario, and what to write.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Name of a built-in scenario, or path of a TOML file
    scenario: String,
    /// In virtual time, as fast as it goes (the default)
    #[arg(long = "virtual", conflicts_with = "processes")]
    virtual_time: bool,
    /// As real processes over real Zenoh on this machine, in real time
    #[arg(long)]
    processes: bool,
    /// Another seed than the scenario's
    #[arg(long, value_parser = crate::seed::parser())]
    seed: Option<u64>,
    /// Set a field of the scenario: path.to.field=value, e.g. sender.master.clock.drift-ppm=50
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Only these receivers, and those they follow
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    receivers: Vec<String>,
    /// Folder for the results [default: out/SCENARIO-WORLD]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write each figure of the report into this folder as SVG and PDF, for papers: docs/REPORTS.md
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Width of the figures, mm: a column of a paper, unless another width is given
    #[arg(long, value_name = "MM", default_value_t = COLUMN_MM, value_parser = millimetres, requires = "figures")]
    figure_width: f64,
    /// Format of the trace, a row per receiver cycle: trace.mcap (docs/RECORDING.md) or trace.csv
    #[arg(long, value_enum, default_value_t, conflicts_with = "no_trace")]
    trace: TraceFormat,
    /// Do not write the trace (gigabytes for a day), nor the raw arrivals of each receiver
    /// (nodes/RECEIVER-arrivals.csv and -exchanges.csv)
    #[arg(long)]
    no_trace: bool,
    /// Print the summary as JSON instead of a table
    #[arg(long)]
    json: bool,
    /// Write a report in JUnit's format: a case for each expectation
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
}

/// Runs a scenario, and reports an error to JUnit as well.
pub(crate) fn run(args: &RunArgs) -> anyhow::Result<Exit> {
    let suite = format!("run {}", args.scenario);
    junit::report_error(args.junit.as_deref(), &suite, try_run(args))
}

/// The run of the demonstration: pieces cut to length, with real processes.
pub(crate) fn demonstration() -> RunArgs {
    RunArgs {
        scenario: "cut-to-length".to_owned(),
        virtual_time: false,
        processes: true,
        seed: None,
        overrides: Vec::new(),
        receivers: Vec::new(),
        out: None,
        figures: None,
        figure_width: COLUMN_MM,
        trace: TraceFormat::default(),
        no_trace: false,
        json: false,
        junit: None,
    }
}

fn try_run(args: &RunArgs) -> anyhow::Result<Exit> {
    let source = catalog::find(&args.scenario)?;
    let stage: &dyn Stage = if args.processes {
        &Processes
    } else {
        &VirtualTime
    };
    let world = stage.world();
    let default_out = || PathBuf::from("out").join(format!("{}-{}", source.name, world.name()));
    let options = Options {
        seed: args.seed,
        overrides: args.overrides.clone(),
        receivers: args.receivers.clone(),
        out: args.out.clone().unwrap_or_else(default_out),
        trace: (!args.no_trace).then_some(args.trace),
    };
    let presentation = Presentation {
        command: command_of(args),
        figures: (args.figures.clone()).map(|folder| (folder, args.figure_width)),
    };
    let scenario = prepare(&source, &options)?;
    if !args.json {
        print_text(&format!("{}: {}", source.name, scenario.title))?;
        print_text(&announcement(
            world,
            scenario.duration_s.get(),
            scenario.senders.len() + scenario.receivers.len(),
        ))?;
        let warning = (options.trace).and_then(|format| trace_warning(&scenario, format));
        warning.map_or(Ok(()), |warning| print_text(&warning))?;
    }
    let mut bar = Bar::new(format!("of {} s", scenario.duration_s.get()))?;
    let begin = machine::now();
    let outcome = reported::run(
        &source.name,
        &scenario,
        &options,
        &presentation,
        stage,
        &mut bar,
    );
    bar.clear();
    let outcome = outcome?;
    if let Some(path) = &args.junit {
        let (suite, took) = (format!("run {}", source.name), machine::now() - begin);
        let cases = outcome.summary.expectations.iter().map(case);
        junit::write(path, &suite, took.as_secs_f64(), cases)?;
    }
    if args.json {
        let text = serde_json::to_string_pretty(&outcome.summary)
            .context("cannot write the summary as JSON")?;
        print_text(&text)?;
    } else {
        print_results(&outcome)?;
    }
    if let Some(at) = outcome.summary.interrupted_at_s {
        tracing::warn!("interrupted after {at:.1} s: the results are of the time before");
        return Ok(Exit::Interrupted);
    }
    Ok(Exit::NotMet.done_if(outcome.summary.failed().next().is_none()))
}

/// An expectation, for the report.
fn case(verdict: &Verdict) -> JunitCase {
    let failure = (!verdict.met).then(|| junit::JunitFailure {
        message: verdict.to_string(),
        text: String::new(),
    });
    JunitCase {
        name: format!("{} {}", verdict.place(), verdict.expected),
        failure,
    }
}

fn announcement(world: World, seconds: f64, nodes: usize) -> String {
    match world {
        World::Virtual => format!("{nodes} nodes, {seconds} s of virtual time"),
        World::Processes => {
            format!("{nodes} processes over Zenoh on this machine, {seconds} s of real time")
        }
    }
}

fn print_results(outcome: &Outcome) -> anyhow::Result<()> {
    let summary = &outcome.summary;
    print_text(&format!("\n{}", table::results(summary)))?;
    if let Some(conclusion) = table::conclusion(summary) {
        print_text(&format!("\n{conclusion}"))?;
    }
    if !summary.routers.is_empty() {
        print_text(&format!("\n{}", table::routers(summary)))?;
    }
    if !summary.expectations.is_empty() {
        print_text(&format!("\n{}", table::verdicts(summary)))?;
    }
    print_text(&format!("\nreport: {}", outcome.report.display()))
}

/// The command that repeats a run, but for the folder.
fn command_of(args: &RunArgs) -> String {
    let mut words = vec!["coaxle".to_owned(), "run".to_owned(), word(&args.scenario)];
    if args.processes {
        words.push("--processes".to_owned());
    }
    if let Some(seed) = args.seed {
        words.push(format!("--seed {seed}"));
    }
    words.extend((args.overrides.iter()).map(|set| format!("--set {}", in_quotes(set))));
    if !args.receivers.is_empty() {
        words.push(format!("--receivers {}", word(&args.receivers.join(","))));
    }
    words.join(" ")
}

/// A width that letters fit into.
fn millimetres(text: &str) -> Result<f64, String> {
    let width = text.parse().ok().filter(|mm| (40.0..=500.0).contains(mm));
    width.ok_or_else(|| "expected a width from 40 to 500 mm".to_owned())
}
