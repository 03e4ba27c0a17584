//! What a sweep came to.

use std::path::PathBuf;

use crate::results_folder::ResultsFolder;
use crate::sweep::plot::Plot;
use crate::sweep::shown::ShownRows;

/// What a sweep came to.
#[derive(Debug)]
pub struct Swept {
    /// The runs that are over, and all that there are.
    pub runs: (usize, usize),
    /// The points that were run, in their order, and what was not as expected there.
    pub points: Vec<PointOutcome>,
    /// `points.csv`, `points.parquet`, `summary.csv`.
    pub tables: Vec<PathBuf>,
    /// The figures of most interest.
    pub shown: ShownRows,
    /// What is plotted, the most interesting figure first.
    pub plots: Vec<Plot>,
    /// The folder: whoever leaves more there keeps it until then.
    pub folder: ResultsFolder,
}

/// What was not as expected at a point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PointOutcome {
    /// The point: each field with its value.
    pub name: String,
    /// How many expectations were judged, over all seeds.
    pub judged: usize,
    /// What was not met, with the seed.
    pub failures: Vec<(u64, String)>,
}
