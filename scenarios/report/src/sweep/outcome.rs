//! What a sweep came to.

use std::path::PathBuf;

use coaxle_lab::sweep::PointOutcome;

/// What a sweep came to, and where it lies.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The figures of most interest, a row for each point and receiver: of several seeds the medians.
    pub table: String,
    /// The runs that are over, and all that there are.
    pub runs: (usize, usize),
    /// The points that were run, in their order, and what was not as expected there.
    pub points: Vec<PointOutcome>,
    /// `points.csv`, `points.parquet`, `summary.csv`.
    pub tables: Vec<PathBuf>,
    /// The plot; none where no axis has two values, or no run has the figure.
    pub plot: Option<PathBuf>,
    /// The report.
    pub report: PathBuf,
}

impl Outcome {
    /// Whether all runs are over: none was ended before.
    #[must_use]
    pub const fn is_whole(&self) -> bool {
        self.runs.0 == self.runs.1
    }

    /// The points at which something was not as expected.
    pub fn failed(&self) -> impl Iterator<Item = &PointOutcome> {
        self.points
            .iter()
            .filter(|point| !point.failures.is_empty())
    }
}
