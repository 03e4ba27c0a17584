//! One run, from the scenario's text to what it leaves in its folder.

mod cuts;
mod files;
mod size;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use coaxle_host::cli::Mistake;

use crate::catalog::Source;
use crate::curves::Drawn;
use crate::finished::{Finished, Progress};
use crate::invariants::{self, Invariant};
use crate::report::print;
use crate::report::{self, Report};
use crate::results_folder::ResultsFolder;
use crate::scenario::Scenario;
use crate::summary::{ReceiverSummary, RouterSummary, Summary, World};
use crate::topology::Topology;
use crate::{processes, virtual_time};
use files::Files;

pub use size::warning as trace_warning;

/// How to run a scenario.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where.
    pub world: World,
    /// Another seed than the scenario's.
    pub seed: Option<u64>,
    /// Fields to set, each `path.to.field=value`.
    pub overrides: Vec<String>,
    /// Only these receivers; all if empty.
    pub receivers: Vec<String>,
    /// Where to leave `summary.json`, the trace, `report.html`, and `cuts.csv` if a slave cuts.
    pub out: PathBuf,
    /// Where to leave each figure of the report as SVG and PDF, and how wide, mm; nowhere if none.
    pub figures: Option<(PathBuf, f64)>,
    /// As what to write the trace, a row per receiver cycle, with the raw arrivals of each receiver:
    /// `nodes/RECEIVER-arrivals.csv`, `nodes/RECEIVER-exchanges.csv`; none of them if none.
    pub trace: Option<TraceFormat>,
    /// The command that repeats the run, for the report.
    pub command: String,
}

/// As what a run leaves its trace.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum TraceFormat {
    /// `trace.mcap`, a recording.
    #[default]
    Mcap,
    /// `trace.csv`.
    Csv,
}

/// What a run came to, and where the rest of it lies.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The figures.
    pub summary: Summary,
    /// The report.
    pub report: PathBuf,
}

/// Runs a scenario as [`prepare`] gave it, under a name, and writes its files.
///
/// # Errors
/// A node that does not start, a file that cannot be written. Failed expectations are no error:
/// they are in the summary.
pub fn run(
    name: &str,
    scenario: &Scenario,
    options: &Options,
    progress: &mut dyn Progress,
) -> anyhow::Result<Outcome> {
    let out = &options.out;
    let folder = ResultsFolder::hold(out)?;
    let files = create_files(name, scenario, options)?;
    let topology = Topology::of(scenario).map_err(|wrong| wrong.in_file("scenario"))?;
    let mut sinks = (files, Drawn::new(scenario, &topology));
    let finished = match options.world {
        World::Virtual => virtual_time::run(scenario, &mut sinks, progress)?,
        World::Processes => processes::run(scenario, out, &mut sinks, progress)?,
    };
    let (files, drawn) = sinks;
    if let Some(files) = files {
        files.finish()?;
    }
    let curves = drawn.into_curves();
    let summary = judged(name, scenario, options.world, finished);
    write_summary(&folder.file("summary.json"), &summary)?;
    cuts::write(&folder.file("cuts.csv"), &summary)?;
    let report = folder.file("report.html");
    let scenario_toml =
        toml::to_string_pretty(scenario).context("cannot write the scenario as TOML")?;
    report::write(
        &report,
        &Report {
            summary: &summary,
            scenario_toml: &scenario_toml,
            curves: &curves,
            command: &options.command,
        },
    )?;
    if let Some((folder, width_mm)) = &options.figures {
        print::write(folder, &summary, &curves, *width_mm)?;
    }
    Ok(Outcome { summary, report })
}

/// The scenario as it is to be run.
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

/// A run in figures with everything that is expected of it.
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
    // One that was ended on its way has no end of its own.
    violations
        .retain(|one| summary.interrupted_at_s.is_none() || one.invariant != Invariant::EndsWell);
    let failed = invariants::judge(&scenario.exceptions, &violations, world);
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
    text.push('\n');
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// The files of all cycles, if they are wanted.
fn create_files(
    name: &str,
    scenario: &Scenario,
    options: &Options,
) -> anyhow::Result<Option<Files>> {
    let Some(format) = options.trace else {
        return Ok(None);
    };
    Files::create(name, scenario, options.world, format, &options.out).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog;

    /// Somebody who has seen enough.
    struct Until(f64);

    impl Progress for Until {
        fn at(&mut self, share: f64) -> bool {
            share < self.0
        }
    }

    #[test]
    fn a_run_that_is_ended_leaves_what_there_is_and_says_of_which_time() {
        let scratch = tempfile::tempdir().unwrap();
        let source = catalog::find("beat").unwrap();
        let options = Options {
            world: World::Virtual,
            seed: None,
            overrides: vec!["duration-s=20".to_owned()],
            receivers: Vec::new(),
            out: scratch.path().to_owned(),
            figures: None,
            trace: Some(TraceFormat::Csv),
            command: String::new(),
        };
        let scenario = prepare(&source, &options).unwrap();
        for (until, at) in [(0.5, Some(10.0)), (2.0, None)] {
            let outcome = run("beat", &scenario, &options, &mut Until(until)).unwrap();
            assert_eq!(outcome.summary.interrupted_at_s, at);
            let trace = std::fs::read_to_string(scratch.path().join("trace.csv")).unwrap();
            let last = trace.lines().last().unwrap();
            let ended: f64 = last.split(',').nth(1).unwrap().parse().unwrap();
            let expected = at.unwrap_or(20.0);
            assert!(
                (expected - 0.1..=expected + 0.1).contains(&ended),
                "{ended}"
            );
            assert!(outcome.report.exists());
        }
    }
}
