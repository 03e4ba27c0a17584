//! Result of a sweep.

use std::path::PathBuf;

use crate::results_folder::ResultsFolder;
use crate::sweep::plot::Plot;
use crate::sweep::shown::ShownRows;

/// Result of a sweep.
#[derive(Debug)]
pub struct SweepResult {
    /// Numbers of finished runs, and of all.
    pub runs: (usize, usize),
    /// The points that were run, in their order, with the expectations not met there.
    pub points: Vec<PointOutcome>,
    /// `points.csv`, `points.parquet`, `summary.csv`.
    pub tables: Vec<PathBuf>,
    /// The figures of most interest.
    pub shown: ShownRows,
    /// Plotted figures, the most interesting one first.
    pub plots: Vec<Plot>,
    /// The folder, held as long as more may be written there.
    pub folder: ResultsFolder,
}

/// Outcome of the expectations at a point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PointOutcome {
    /// The point: each field with its value.
    pub name: String,
    /// Number of expectations judged, over all seeds.
    pub judged: usize,
    /// Failures, with the seed.
    pub failures: Vec<(u64, String)>,
}
