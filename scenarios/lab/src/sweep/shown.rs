//! The figures of most interest, as people read them.

use super::grid::SweepAxis;
use super::group::PointGroup;
use super::statistics::Statistics;
use crate::figures::SummaryFigure;
use crate::number::significant;

/// Heading of each column, and its figure.
pub(super) const COLUMNS: [(&str, &str); 8] = [
    ("sync_s", "time_to_sync_s"),
    ("drift_ppm", "drift_ppm"),
    ("drift_true_ppm", "drift_ppm_true"),
    ("ripple_max", "velocity_ripple_max"),
    ("ripple_rms", "velocity_ripple_rms"),
    ("time_error_rms_us", "corrected_time_error_rms_us"),
    ("time_error_max_us", "corrected_time_error_max_us"),
    ("lag_us", "lag_us"),
];

/// A row for each point and receiver.
pub(super) struct ShownFigures<'a> {
    figures: Vec<&'a SummaryFigure>,
    shown: ShownRows,
}

/// The figures of most interest as words: a row for each point and receiver.
#[derive(Clone, Debug)]
pub struct ShownRows {
    /// Number of columns that are no figures: those on the left.
    pub words: usize,
    /// Heading of each column.
    pub header: Vec<String>,
    /// The rows, of several seeds with the medians.
    pub rows: Vec<Vec<String>>,
}

impl<'a> ShownFigures<'a> {
    pub(super) fn new(axes: &[SweepAxis], figures: &'a [SummaryFigure]) -> Self {
        let fields = axes.iter().map(|axis| axis.field.as_str());
        let headings = COLUMNS.map(|(heading, _)| heading);
        let header = fields.chain(["receiver"]).chain(headings);
        let named = |name| figures.iter().find(|figure| figure.name == name);
        Self {
            figures: (COLUMNS.iter())
                .filter_map(|(_, name)| named(*name))
                .collect(),
            shown: ShownRows {
                words: axes.len() + 1,
                header: header.map(str::to_owned).collect(),
                rows: Vec::new(),
            },
        }
    }

    /// Appends a receiver at a point: of several seeds the medians.
    pub(super) fn add(&mut self, point: &[String], group: &PointGroup<'_>) {
        // Figures of a receiver are in the rows of each of its slaves.
        if !group.is_first {
            return;
        }
        let words = point.iter().map(String::as_str).chain([group.receiver]);
        let figures = self.figures.iter().map(|figure| {
            let known = Statistics::of(figure, &group.rows);
            // Four digits keep the columns narrow: the full numbers are in the tables.
            known.map_or_else(|| "–".to_owned(), |known| significant(known.median, 4))
        });
        let row = words.map(str::to_owned).chain(figures);
        self.shown.rows.push(row.collect());
    }

    /// The finished rows.
    pub(super) fn finish(self) -> ShownRows {
        self.shown
    }
}
