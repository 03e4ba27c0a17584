//! A run, from the scenario's text to the results in its folder.

mod cuts;
mod files;
mod size;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use coaxle_os::exit::Mistake;

use crate::catalog::Source;
use crate::curves::{Curves, Drawn};
use crate::finished::{Finished, Progress};
use crate::invariants::{self, Invariant};
use crate::results_folder::ResultsFolder;
use crate::scenario::Scenario;
use crate::stage::Stage;
use crate::summary::{ReceiverSummary, RouterSummary, Summary, World};
use crate::topology::Topology;
use files::RunFiles;

pub use size::warning as trace_warning;

/// The folder, among the results of a run, of the files that nodes leave.
pub const NODES_FOLDER: &str = "nodes";

/// Options of a run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Another seed than the scenario's.
    pub seed: Option<u64>,
    /// Fields to set, each `path.to.field=value`.
    pub overrides: Vec<String>,
    /// Only these receivers; all if empty.
    pub receivers: Vec<String>,
    /// Folder for `summary.json`, the trace, and `cuts.csv` if a slave cuts.
    pub out: PathBuf,
    /// Format of the trace, a row per receiver cycle, with the raw arrivals of each receiver:
    /// `nodes/RECEIVER-arrivals.csv`, `nodes/RECEIVER-exchanges.csv`; no such files if absent.
    pub trace: Option<TraceFormat>,
}

/// Format of a trace.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum TraceFormat {
    /// `trace.mcap`, a recording.
    #[default]
    Mcap,
    /// `trace.csv`.
    Csv,
}

/// Result of a run.
#[derive(Debug)]
pub struct RunResult {
    /// The figures.
    pub summary: Summary,
    /// Curves for a report.
    pub curves: Vec<Curves>,
    /// The folder with its files, held as long as more may be written there.
    pub folder: ResultsFolder,
}

/// Plays a scenario as [`prepare`] gave it, under a name, and writes its files.
///
/// # Errors
/// A node that does not start, a file that cannot be written. Failed expectations are no error:
/// they are in the summary.
pub fn run(
    name: &str,
    scenario: &Scenario,
    options: &Options,
    stage: &dyn Stage,
    progress: &mut dyn Progress,
) -> anyhow::Result<RunResult> {
    let out = &options.out;
    // Before any file is opened: another run's files would be cut to nothing.
    let folder = ResultsFolder::hold(out)?;
    let files = create_files(name, scenario, options, stage.world())?;
    let topology = Topology::of(scenario).map_err(|wrong| wrong.in_file("scenario"))?;
    let mut sinks = (files, Drawn::new(scenario, &topology));
    let finished = stage.play(scenario, out, &mut sinks, progress)?;
    let (files, drawn) = sinks;
    if let Some(files) = files {
        files.finish()?;
    }
    let curves = drawn.into_curves();
    let summary = judged(name, scenario, stage.world(), finished);
    write_summary(&folder.file("summary.json"), &summary)?;
    cuts::write(&folder.file("cuts.csv"), &summary)?;
    Ok(RunResult {
        summary,
        curves,
        folder,
    })
}

/// The scenario with the options applied.
///
/// # Errors
/// Names the file, the field, what was received and what is expected.
pub fn prepare(source: &Source, options: &Options) -> anyhow::Result<Scenario> {
    let mut scenario = source.read(&options.overrides)?;
    if let Some(seed) = options.seed {
        scenario.seed = seed;
    }
    if !options.receivers.is_empty() {
        scenario
            .keep_receivers(&options.receivers)
            .map_err(|reason| Mistake::in_argument(format!("--receivers: {reason}")))?;
    }
    Ok(scenario)
}

/// Summary of a run, with the outcomes of all expectations.
pub(crate) fn judged(name: &str, scenario: &Scenario, world: World, finished: Finished) -> Summary {
    let seconds = finished
        .interrupted_at_s
        .unwrap_or(scenario.duration_s.get());
    let routers = finished.routers.iter();
    let routers = routers.map(|router| (router.name.clone(), RouterSummary::of(router, seconds)));
    let mut summary = summarise(name, scenario, world, finished.figures, routers.collect());
    summary.expectations.extend(finished.commands);
    summary.expectations.extend(finished.deaths);
    summary.interrupted_at_s = finished.interrupted_at_s;
    let mut violations = finished.violations;
    // An interrupted run has no end to judge.
    violations
        .retain(|one| summary.interrupted_at_s.is_none() || one.invariant != Invariant::EndsWell);
    let failed = invariants::judge(&scenario.exceptions, &violations, world);
    // Violations stand behind the expectations of the scenario, and fail the run alike.
    summary.expectations.extend(failed);
    summary
}

fn summarise(
    name: &str,
    scenario: &Scenario,
    world: World,
    receivers: BTreeMap<String, ReceiverSummary>,
    routers: BTreeMap<String, RouterSummary>,
) -> Summary {
    let mut summary = Summary {
        scenario: name.to_owned(),
        title: scenario.title.clone(),
        world,
        seed: scenario.seed,
        duration_s: scenario.duration_s.get(),
        interrupted_at_s: None,
        receivers,
        routers,
        expectations: Vec::new(),
    };
    summary.expectations = scenario
        .expectations
        .iter()
        .filter_map(|expectation| expectation.judge(&summary))
        .collect();
    summary
}

fn write_summary(path: &Path, summary: &Summary) -> anyhow::Result<()> {
    let mut text = serde_json::to_string_pretty(summary).context("cannot write the summary")?;
    // A line of text ends with a newline, as other tools expect.
    text.push('\n');
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// The files of all cycles, if requested.
fn create_files(
    name: &str,
    scenario: &Scenario,
    options: &Options,
    world: World,
) -> anyhow::Result<Option<RunFiles>> {
    let Some(format) = options.trace else {
        return Ok(None);
    };
    RunFiles::create(name, scenario, world, format, &options.out).map(Some)
}
