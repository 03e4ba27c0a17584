//! A run with its report.

use std::path::PathBuf;

use anyhow::Context;
use coaxle_lab::catalog::Source;
use coaxle_lab::finished::Progress;
use coaxle_lab::run::{self, Options, RunResult};
use coaxle_lab::scenario::Scenario;
use coaxle_lab::stage::{Stage, VirtualTime};
use coaxle_lab::summary::Summary;

use crate::run::{Report, write, write_figures};

/// Command and figures that a report has beside the run.
#[derive(Clone, Debug, Default)]
pub struct Presentation {
    /// The command that repeats the run.
    pub command: String,
    /// Folder for each figure of the report as SVG and PDF, and their width, mm; none: no figures are written.
    pub figures: Option<(PathBuf, f64)>,
}

/// Result of a run, and its report.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Figures of the run.
    pub summary: Summary,
    /// Path of the report.
    pub report: PathBuf,
}

/// Runs a scenario as [`run::prepare`] gave it, under a name, and writes its files, with `report.html` among them.
///
/// # Errors
/// A node that does not start, a file that cannot be written. Failed expectations are no error:
/// they are in the summary.
pub fn run(
    name: &str,
    scenario: &Scenario,
    options: &Options,
    presentation: &Presentation,
    stage: &dyn Stage,
    progress: &mut dyn Progress,
) -> anyhow::Result<Outcome> {
    let RunResult {
        summary,
        curves,
        folder,
    } = run::run(name, scenario, options, stage, progress)?;
    let report = folder.file("report.html");
    let scenario_toml =
        toml::to_string_pretty(scenario).context("cannot write the scenario as TOML")?;
    write(
        &report,
        &Report {
            summary: &summary,
            scenario_toml: &scenario_toml,
            curves: &curves,
            command: &presentation.command,
        },
    )?;
    if let Some((folder, width_mm)) = &presentation.figures {
        write_figures(folder, &summary, &curves, *width_mm)?;
    }
    Ok(Outcome { summary, report })
}

/// Runs a scenario in virtual time, which this command repeats, and writes its files: used by a soak for failed runs.
///
/// # Errors
/// Errors of [`run()`].
pub fn leave(source: &Source, options: &Options, command: &str) -> anyhow::Result<()> {
    let scenario = run::prepare(source, options)?;
    let presentation = Presentation {
        command: command.to_owned(),
        figures: None,
    };
    run(
        &source.name,
        &scenario,
        options,
        &presentation,
        &VirtualTime,
        &mut (),
    )?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_lab::catalog;
    use coaxle_lab::run::{TraceFormat, prepare};

    /// Progress that ends the run at a share of it.
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
            seed: None,
            overrides: vec!["duration-s=20".to_owned()],
            receivers: Vec::new(),
            out: scratch.path().to_owned(),
            trace: Some(TraceFormat::Csv),
        };
        let scenario = prepare(&source, &options).unwrap();
        for (until, at) in [(0.5, Some(10.0)), (2.0, None)] {
            let outcome = run(
                "beat",
                &scenario,
                &options,
                &Presentation::default(),
                &VirtualTime,
                &mut Until(until),
            )
            .unwrap();
            // Progress is reported after each second of virtual time, so the run ends at half of its 20 s exactly.
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
