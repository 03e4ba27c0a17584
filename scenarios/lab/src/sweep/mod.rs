//! A scenario over a grid of values, with one seed or several, in virtual time, on all cores.
//!
//! [`prepare`] checks the scenario at every point, [`Prepared::run`] runs those that the folder does not have yet, and leaves
//! tables there. An interrupted sweep continues where it was.

mod grid;
mod group;
mod outcome;
pub mod plot;
mod record;
mod results;
pub mod shown;
pub mod statistics;
mod store;
mod tables;
mod work;

use std::num::NonZeroUsize;
use std::path::PathBuf;

use anyhow::Context;
use coaxle_node::config::parse_table;
use coaxle_os::exit::{Mistake, wrong_file};

pub use self::grid::{MOST_RUNS, SweepAxis};
pub use self::outcome::{PointOutcome, SweepResult};
pub use self::work::SweepProgress;
use crate::catalog::Source;
use crate::figures::SummaryFigure;
use crate::results_folder::ResultsFolder;
use crate::scenario::Scenario;
use store::{Store, SweepIdentity};
use work::SweepRun;

/// Settings of a sweep.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setup {
    /// The axes of the grid; the scenario's own if there are none.
    pub axes: Vec<SweepAxis>,
    /// Fields to set at all points, each `path.to.field=value`.
    pub overrides: Vec<String>,
    /// Only these receivers, and those they follow; all if empty.
    pub receivers: Vec<String>,
    /// Number of seeds of each point: the scenario's and those that follow it.
    pub seeds: NonZeroUsize,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            axes: Vec::new(),
            overrides: Vec::new(),
            receivers: Vec::new(),
            seeds: NonZeroUsize::MIN,
        }
    }
}

/// Options of the results.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The folder.
    pub out: PathBuf,
    /// True to delete the results of an earlier sweep in the folder.
    pub is_fresh: bool,
    /// Name of the plotted figure in the tables; absent to choose one that suits the scenario.
    pub figure: Option<String>,
}

/// Bytes that the scenario may have at all points together: each is read.
const MOST_BYTES: usize = 16 << 20;

/// A scenario at every point of a grid, checked and ready to run.
#[derive(Clone, Debug)]
pub struct Prepared {
    identity: SweepIdentity,
    title: String,
    axes: Vec<SweepAxis>,
    seeds: NonZeroUsize,
    points: Vec<SweepPoint>,
}

/// A point of the grid.
#[derive(Clone, Debug)]
struct SweepPoint {
    /// A value for each axis.
    values: Vec<String>,
    scenario: Scenario,
}

impl SweepPoint {
    /// The scenario with the n-th of its seeds.
    fn with_seed(&self, n: usize) -> anyhow::Result<Scenario> {
        let mut scenario = self.scenario.clone();
        let seed = scenario.seed.checked_add(n as u64);
        // TOML has no larger integers, and the seed is part of a record's key.
        let seed = seed.filter(|seed| i64::try_from(*seed).is_ok());
        scenario.seed = seed.with_context(|| {
            let first = self.scenario.seed;
            format!(
                "seed: received {first}, expected one with {n} more behind it, up to {}",
                i64::MAX
            )
        })?;
        Ok(scenario)
    }
}

/// Checks a scenario at every point of the grid that the axes span, or of its own grid where there
/// are none. A scenario without any grid is one point.
///
/// # Errors
/// A field or value that the scenario does not take.
pub fn prepare(source: &Source, setup: &Setup) -> anyhow::Result<Prepared> {
    let axes: Vec<SweepAxis> = match setup.axes.as_slice() {
        [] => {
            let scenario = scenario_at(source, &[], &[], setup)?;
            scenario.grid.iter().map(SweepAxis::from).collect()
        }
        axes => axes.to_vec(),
    };
    let grid = grid::points(&axes, setup.seeds.get()).with_context(|| source.file.clone())?;
    check_bytes(source, grid.len())?;
    let points = grid.into_iter().map(|values| {
        let scenario = scenario_at(source, &axes, &values, setup)?;
        Ok(SweepPoint { values, scenario })
    });
    let points: Vec<SweepPoint> = points.collect::<anyhow::Result<_>>()?;
    let title = points.first().map(|point| point.scenario.title.clone());
    Ok(Prepared {
        identity: identity(source, &axes, setup)?,
        title: title.unwrap_or_default(),
        axes,
        seeds: setup.seeds,
        points,
    })
}

fn identity(source: &Source, axes: &[SweepAxis], setup: &Setup) -> anyhow::Result<SweepIdentity> {
    let mut table = parse_table(&source.file, &source.text)?;
    // The grid is in the fields: other values of them are the same sweep, and use its runs.
    table.remove("sweep");
    Ok(SweepIdentity {
        scenario: source.name.clone(),
        fields: axes.iter().map(|axis| axis.field.clone()).collect(),
        set: setup.overrides.clone(),
        receivers: setup.receivers.clone(),
        text: toml::to_string(&table).context("cannot write the scenario as TOML")?,
    })
}

fn check_bytes(source: &Source, points: usize) -> anyhow::Result<()> {
    let bytes = source.text.len();
    // A single point is the scenario itself.
    if points > 1 && bytes.saturating_mul(points) > MOST_BYTES {
        return wrong_file(format!(
            "{}: received {bytes} bytes at {points} points of a grid, expected at most {MOST_BYTES} bytes at all of \
             them together",
            source.file
        ));
    }
    Ok(())
}

fn scenario_at(
    source: &Source,
    axes: &[SweepAxis],
    point: &[String],
    setup: &Setup,
) -> anyhow::Result<Scenario> {
    let at_point = axes
        .iter()
        .zip(point)
        .map(|(axis, value)| format!("{}={value}", axis.field));
    let all: Vec<String> = setup.overrides.iter().cloned().chain(at_point).collect();
    let mut scenario = source.read(&all)?;
    if !setup.receivers.is_empty() {
        scenario
            .keep_receivers(&setup.receivers)
            .map_err(|reason| Mistake::in_argument(format!("--receivers: {reason}")))?;
    }
    Ok(scenario)
}

impl Prepared {
    /// The name of the scenario.
    #[must_use]
    pub fn scenario(&self) -> &str {
        &self.identity.scenario
    }

    /// The title of the scenario.
    #[must_use]
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The axes of the grid.
    #[must_use]
    pub fn axes(&self) -> &[SweepAxis] {
        &self.axes
    }

    /// The number of points of the grid.
    #[must_use]
    pub const fn points(&self) -> usize {
        self.points.len()
    }

    /// Number of seeds of each point.
    #[must_use]
    pub const fn seeds(&self) -> NonZeroUsize {
        self.seeds
    }

    /// Notes on its receivers, at the first point of the grid: a line each.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let first = self.points.first();
        let receivers = first
            .into_iter()
            .flat_map(|point| &point.scenario.receivers);
        let notes = receivers.flat_map(|receiver| {
            let name = &receiver.name;
            (receiver.notes().into_iter()).map(move |note| format!("receiver {name}: {note}"))
        });
        notes.collect()
    }

    /// Runs the points that the folder does not have yet, and leaves the results of all there. `on_progress` receives the progress, from
    /// any of its threads, and returns whether to continue: if not, the results are those up to then.
    ///
    /// # Errors
    /// The folder of another sweep, or one that another run writes to; an unknown figure; a run that fails; a file
    /// that cannot be written.
    pub fn run(
        &self,
        options: &Options,
        on_progress: &(dyn Fn(&SweepProgress) -> bool + Sync),
    ) -> anyhow::Result<SweepResult> {
        let figures = SummaryFigure::all();
        // Before hours of runs, not after them.
        plot::check_figure(options.figure.as_deref(), &figures)?;
        let folder = ResultsFolder::hold(&options.out)?;
        let store = Store::open(&folder, &self.identity, options.is_fresh)?;
        let runs = self.runs(&store)?;
        work::run_missing(
            &self.identity.scenario,
            &self.points,
            &runs,
            &figures,
            on_progress,
        )?;
        results::write(self, &runs, &figures, folder, options)
    }

    /// Every point with each seed, in their order.
    fn runs(&self, store: &Store) -> anyhow::Result<Vec<SweepRun>> {
        let runs = self.points.iter().enumerate().flat_map(|(n, point)| {
            (0..self.seeds.get()).map(move |nth_seed| {
                let scenario = point.with_seed(nth_seed)?;
                Ok(SweepRun {
                    point: n,
                    nth_seed,
                    seed: scenario.seed,
                    place: store.place(&scenario)?,
                })
            })
        });
        runs.collect()
    }
}
