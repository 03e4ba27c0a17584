//! Result of a sweep.

use std::path::PathBuf;

use coaxle_lab::sweep::PointOutcome;

/// Result of a sweep, and its files.
#[derive(Clone, Debug)]
pub struct SweepOutcome {
    /// The figures of most interest, a row for each point and receiver: of several seeds the medians.
    pub table: String,
    /// Numbers of finished runs and of all runs.
    pub runs: (usize, usize),
    /// The points that were run, in their order, with their failures.
    pub points: Vec<PointOutcome>,
    /// Paths of `points.csv`, `points.parquet`, `summary.csv`.
    pub tables: Vec<PathBuf>,
    /// The plot; none where no axis has two values, or no run has the figure.
    pub plot: Option<PathBuf>,
    /// Path of the report.
    pub report: PathBuf,
}

impl SweepOutcome {
    /// Reports whether all runs are finished: none was ended before.
    #[must_use]
    pub const fn is_whole(&self) -> bool {
        self.runs.0 == self.runs.1
    }

    /// Returns the points at which something was not as expected.
    pub fn failed(&self) -> impl Iterator<Item = &PointOutcome> {
        self.points
            .iter()
            .filter(|point| !point.failures.is_empty())
    }
}
