//! Results of a sweep in its folder, of the runs finished so far.

use super::group::groups;
use super::outcome::{PointOutcome, SweepResult};
use super::plot::{self, Plots};
use super::record::RunRecord;
use super::shown::ShownFigures;
use super::tables::SweepTables;
use super::work::SweepRun;
use super::{Options, Prepared, SweepPoint, store};
use crate::figures::{SummaryFigure, Units};
use crate::results_folder::ResultsFolder;

/// Writes the tables of the finished runs, and gathers the rows and plots to show. One point at a time is in memory.
///
/// # Errors
/// Names the file that cannot be written.
pub(super) fn write(
    sweep: &Prepared,
    runs: &[SweepRun],
    figures: &[SummaryFigure],
    folder: ResultsFolder,
    options: &Options,
) -> anyhow::Result<SweepResult> {
    let (axes, name) = (sweep.axes.as_slice(), sweep.identity.scenario.as_str());
    // Units are in the header, so all records are read once before the first row, and once more for it: not all fit into memory.
    let units = common_units(runs);
    let facts = [
        ("scenario", name.to_owned()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    let mut tables = SweepTables::create(&folder, axes, figures, &units, facts)?;
    let mut shown = ShownFigures::new(axes, figures);
    let mut plots = Plots::new(axes, figures, options.figure.as_deref());
    let (mut points, mut over) = (Vec::new(), 0);
    // Runs stand point after point, each with all of its seeds.
    let of_points = runs.chunks(sweep.seeds.get());
    for (n, (point, runs)) in sweep.points.iter().zip(of_points).enumerate() {
        let records = records_of(runs);
        for (seed, record) in &records {
            for row in &record.rows {
                tables.row(&point.values, *seed, row)?;
            }
        }
        for group in groups(&records) {
            tables.summary(&point.values, &group)?;
            shown.add(&point.values, &group);
            plots.add(n, &group);
        }
        over += records.len();
        points.extend(outcome_of(sweep, point, &records));
    }
    tables.finish()?;
    Ok(SweepResult {
        runs: (over, runs.len()),
        points,
        tables: ["points.csv", "points.parquet", "summary.csv"]
            .map(|file| folder.file(file))
            .into(),
        shown: shown.finish(),
        plots: plots.finish(&units),
        folder,
    })
}

/// Records of the finished ones of these runs, with their seeds.
fn records_of(runs: &[SweepRun]) -> Vec<(u64, RunRecord)> {
    let records = (runs.iter()).filter_map(|run| Some((run.seed, store::load(&run.place)?)));
    records.collect()
}

/// The units that all rows have.
fn common_units(runs: &[SweepRun]) -> Units {
    let mut seen: Vec<(Units, bool)> = Vec::new();
    for record in runs.iter().filter_map(|run| store::load(&run.place)) {
        for row in record.rows {
            let units = (row.units, row.slave.is_some());
            // A sweep has a handful of different units: a list suffices.
            if !seen.contains(&units) {
                seen.push(units);
            }
        }
    }
    Units::common(seen.iter().map(|(units, has_slave)| (units, *has_slave)))
}

/// Outcome of a point; none where no run is finished.
fn outcome_of(
    sweep: &Prepared,
    point: &SweepPoint,
    records: &[(u64, RunRecord)],
) -> Option<PointOutcome> {
    let failures = records.iter().flat_map(|(seed, record)| {
        let lines = record.failures.iter();
        lines.map(|line| (*seed, line.clone()))
    });
    (!records.is_empty()).then(|| PointOutcome {
        name: plot::point_name(&sweep.axes, &point.values),
        judged: records.iter().map(|(_, record)| record.judged).sum(),
        failures: failures.collect(),
    })
}
