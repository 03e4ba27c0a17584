//! Scenarios and sweeps, in virtual time.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use coaxle_lab::catalog;
use coaxle_lab::finished::Progress;
use coaxle_lab::run::{Options, TraceFormat, prepare};
use coaxle_lab::stage::VirtualTime;
use coaxle_lab::sweep as grid;
use coaxle_report::reported::{self, Presentation};
use coaxle_report::sweep as reported_sweep;
use pyo3::prelude::*;

use crate::error::told;

/// The names of the scenarios that come with it, each with its title.
#[pyfunction]
pub(crate) fn scenarios() -> PyResult<Vec<(String, String)>> {
    let titled = |(name, _): (&str, &str)| {
        let scenario = catalog::find(name)?.read(&[])?;
        Ok((name.to_owned(), scenario.title))
    };
    catalog::all()
        .map(titled)
        .collect::<anyhow::Result<_>>()
        .map_err(told)
}

/// Runs a scenario and leaves the results of `coaxle run` in `out`. Returns the summary, as JSON.
#[pyfunction]
#[pyo3(signature = (scenario, out, *, seed, overrides, receivers, trace))]
pub(crate) fn run(
    py: Python<'_>,
    scenario: &str,
    out: PathBuf,
    seed: Option<u64>,
    overrides: Vec<String>,
    receivers: Vec<String>,
    trace: bool,
) -> PyResult<String> {
    let source = catalog::find(scenario).map_err(told)?;
    let options = Options {
        seed,
        overrides,
        receivers,
        out,
        trace: trace.then_some(TraceFormat::Mcap),
    };
    let presentation = Presentation {
        command: format!("coaxle.run({scenario:?})"),
        figures: None,
    };
    // The error of Python is kept apart: the run itself knows only that it was ended.
    let mut interrupted = Interrupted(None);
    let outcome = py.detach(|| {
        let scenario = prepare(&source, &options)?;
        let outcome = reported::run(
            &source.name,
            &scenario,
            &options,
            &presentation,
            &VirtualTime,
            &mut interrupted,
        )?;
        Ok(serde_json::to_string(&outcome.summary)?)
    });
    match interrupted.0 {
        Some(error) => Err(error),
        None => outcome.map_err(|error: anyhow::Error| told(error)),
    }
}

/// Ends a run at a signal to Python, such as Ctrl-C.
struct Interrupted(Option<PyErr>);

impl Progress for Interrupted {
    fn at(&mut self, _share: f64) -> bool {
        // The lock is taken for this check alone.
        self.0 = Python::attach(|py| py.check_signals()).err();
        self.0.is_none()
    }
}

/// Runs a scenario over a grid and leaves the results of `coaxle sweep` in `out`. Returns the numbers of finished runs, and of all.
#[pyfunction]
#[pyo3(signature = (scenario, out, *, axes, overrides, receivers, seeds, fresh))]
#[expect(clippy::too_many_arguments, reason = "each has its name in Python")]
pub(crate) fn sweep(
    py: Python<'_>,
    scenario: &str,
    out: PathBuf,
    axes: Vec<String>,
    overrides: Vec<String>,
    receivers: Vec<String>,
    seeds: NonZeroUsize,
    fresh: bool,
) -> PyResult<(usize, usize)> {
    let axes = axes.iter().map(|axis| axis.parse());
    let axes = axes.collect::<Result<_, String>>();
    let setup = grid::Setup {
        axes: axes.map_err(crate::error::wrong)?,
        overrides,
        receivers,
        seeds,
    };
    let options = grid::Options {
        out,
        is_fresh: fresh,
        figure: None,
    };
    let command = format!("coaxle.sweep({scenario:?})");
    let outcome = py.detach(|| {
        let source = catalog::find(scenario)?;
        let goes_on = |_: &grid::SweepProgress| Python::attach(|py| py.check_signals()).is_ok();
        reported_sweep::run(
            &grid::prepare(&source, &setup)?,
            &options,
            &command,
            &goes_on,
        )
    });
    // Checked again: the closure can end the sweep, but not raise an exception.
    py.check_signals()?;
    Ok(outcome.map_err(told)?.runs)
}
