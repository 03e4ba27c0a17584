//! The tables for other programs: `points.csv`, `points.parquet`, `summary.csv`.

use std::fs::File;
use std::path::Path;

use anyhow::Context;
use coaxle_node::signal::Kind;
use coaxle_recording::Value;
use coaxle_recording::export::{ParquetTable, TypedColumn};

use super::grid::{self, SEED, SweepAxis};
use super::group::PointGroup;
use super::record::FigureRow;
use super::statistics::Statistics;
use crate::figures::{SummaryFigure, Units};
use crate::results_folder::ResultsFolder;

/// The tables, open.
pub(super) struct SweepTables<'a> {
    axes: &'a [SweepAxis],
    figures: &'a [SummaryFigure],
    has_seed: bool,
    points: csv::Writer<File>,
    parquet: ParquetTable<File>,
    summary: csv::Writer<File>,
}

impl<'a> SweepTables<'a> {
    /// Creates the files. `units` are those of all rows together.
    ///
    /// # Errors
    /// Names the file that cannot be written.
    pub(super) fn create(
        folder: &ResultsFolder,
        axes: &'a [SweepAxis],
        figures: &'a [SummaryFigure],
        units: &Units,
        facts: [(&str, String); 2],
    ) -> anyhow::Result<Self> {
        let columns = columns(axes, figures, units);
        let mut points = csv_file(&folder.file("points.csv"))?;
        let names = columns.iter().map(|column| &column.name);
        points.write_record(names).context("points.csv")?;
        let mut summary = csv_file(&folder.file("summary.csv"))?;
        let fields = axes.iter().map(|axis| axis.field.as_str());
        let header: Vec<&str> = fields.chain(SUMMARY).collect();
        summary.write_record(header).context("summary.csv")?;
        let path = folder.file("points.parquet");
        let file =
            File::create(&path).with_context(|| format!("cannot write {}", path.display()))?;
        let facts = facts.map(|(key, value)| (key.to_owned(), value));
        Ok(Self {
            axes,
            figures,
            has_seed: has_seed(axes),
            points,
            parquet: ParquetTable::new(file, &columns, &facts.into()).context("points.parquet")?,
            summary,
        })
    }

    /// Appends the figures of a run with a seed at a point.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn row(
        &mut self,
        point: &[String],
        seed: u64,
        row: &FigureRow,
    ) -> anyhow::Result<()> {
        let mut cells: Vec<_> = self.places(point).map(Some).collect();
        if self.has_seed {
            cells.push(Some(Value::Count(seed)));
        }
        cells.push(Some(Value::Text(row.receiver.clone())));
        cells.push(row.slave.clone().map(Value::Text));
        cells.extend(self.figures.iter().map(|figure| row.value(figure)));
        self.points.serialize(&cells).context("points.csv")?;
        let cells = cells.iter().map(Option::as_ref);
        self.parquet.row(cells).context("points.parquet")
    }

    /// Appends the statistics over all seeds of a point: a row for each figure.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn summary(
        &mut self,
        point: &[String],
        group: &PointGroup<'_>,
    ) -> anyhow::Result<()> {
        let places: Vec<_> = self.places(point).collect();
        for figure in self.figures {
            // A receiver's figures are written once.
            let is_said = if figure.is_of_slave {
                group.slave.is_some()
            } else {
                group.is_first
            };
            let Some(statistics) = Statistics::of(figure, &group.rows).filter(|_| is_said) else {
                continue;
            };
            let Statistics {
                known,
                median,
                low,
                high,
                worst,
            } = statistics;
            let slave = group.slave.filter(|_| figure.is_of_slave);
            let what = (
                group.receiver,
                slave,
                &figure.name,
                figure.unit(group.units),
            );
            let over = (group.rows.len(), known, median, low, high, worst);
            self.summary
                .serialize((&places, what, over))
                .context("summary.csv")?;
        }
        Ok(())
    }

    /// The values of the axes at a point.
    fn places(&self, point: &[String]) -> impl Iterator<Item = Value> {
        (self.axes.iter().zip(point)).map(|(axis, value)| place(axis, value))
    }

    /// Ends the files.
    ///
    /// # Errors
    /// A file that is not whole.
    pub(super) fn finish(mut self) -> anyhow::Result<()> {
        self.points.flush().context("points.csv")?;
        self.summary.flush().context("summary.csv")?;
        self.parquet.finish().context("points.parquet")
    }
}

/// The columns of `summary.csv` behind those of the axes.
const SUMMARY: [&str; 10] = [
    "receiver", "slave", "figure", "unit", "runs", "known", "median", "q05", "q95", "worst",
];

fn columns(axes: &[SweepAxis], figures: &[SummaryFigure], units: &Units) -> Vec<TypedColumn> {
    let column = |name: &str, kind, is_optional| TypedColumn {
        name: name.to_owned(),
        unit: String::new(),
        kind: Some(kind),
        is_optional,
    };
    let axes_columns = axes.iter().map(|axis| {
        let kind = match axis.numbers() {
            Some(_) => Kind::Number,
            None => Kind::Text,
        };
        column(&axis.field, kind, false)
    });
    let seed = has_seed(axes).then(|| column(SEED, Kind::Count, false));
    let whose = [
        column("receiver", Kind::Text, false),
        column("slave", Kind::Text, true),
    ];
    let figures = figures.iter().map(|figure| TypedColumn {
        name: figure.heading(units),
        unit: figure.unit(units),
        kind: Some(figure.kind),
        is_optional: true,
    });
    axes_columns
        .chain(seed)
        .chain(whose)
        .chain(figures)
        .collect()
}

/// True if the seed has a column: not where it is an axis.
fn has_seed(axes: &[SweepAxis]) -> bool {
    axes.iter().all(|axis| axis.field != SEED)
}

/// A value of an axis: a number where all of them are.
fn place(axis: &SweepAxis, value: &str) -> Value {
    // A column has one type: among words a number is a word, too.
    let number = grid::number(value).filter(|_| axis.numbers().is_some());
    number.map_or_else(|| Value::Text(value.to_owned()), Value::Number)
}

fn csv_file(path: &Path) -> anyhow::Result<csv::Writer<File>> {
    let cannot = || format!("cannot write {}", path.display());
    let file = File::create(path).with_context(cannot)?;
    let mut builder = csv::WriterBuilder::new();
    // The header is a record of its own, as rows are lists without names.
    Ok(builder.has_headers(false).from_writer(file))
}
