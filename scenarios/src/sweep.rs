//! One scenario over a grid of values, in virtual time, on all cores.

use std::path::Path;
use std::sync::Mutex;

use anyhow::{Context, bail};
use comfy_table::{Cell, CellAlignment, Table, presets};

use crate::catalog::Source;
use crate::finished::{Finished, Progress};
use crate::number::significant;
use crate::scenario::{GridAxis, Scenario};
use crate::summary::ReceiverSummary;
use crate::virtual_time;

/// One field and the values it takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// The path of the field, as `--set` takes it.
    pub field: String,
    /// The values, in the order they are run.
    pub values: Vec<String>,
}

impl std::str::FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("received {text:?}, expected path.to.field=a,b,c");
        let (field, values) = text.split_once('=').ok_or_else(expected)?;
        let values: Vec<String> = split_values(values);
        if field.trim().is_empty() || values.iter().any(String::is_empty) {
            return Err(expected());
        }
        Ok(Self {
            field: field.trim().to_owned(),
            values,
        })
    }
}

impl From<&GridAxis> for Axis {
    fn from(axis: &GridAxis) -> Self {
        Self {
            field: axis.field.clone(),
            values: axis.values.iter().map(ToString::to_string).collect(),
        }
    }
}

/// At commas, but not within brackets, braces or quotes: tables and lists are values too.
fn split_values(text: &str) -> Vec<String> {
    let mut values = vec![String::new()];
    let (mut depth, mut quoted) = (0_u32, false);
    for c in text.chars() {
        match c {
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth = depth.saturating_sub(1),
            ',' if !quoted && depth == 0 => {
                values.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(value) = values.last_mut() {
            value.push(c);
        }
    }
    values.iter().map(|value| value.trim().to_owned()).collect()
}

/// The figures of every receiver at every point of a grid.
#[derive(Clone, Debug)]
pub struct Sweep {
    fields: Vec<String>,
    rows: Vec<Row>,
    is_whole: bool,
}

#[derive(Clone, Debug)]
struct Row {
    values: Vec<String>,
    receiver: String,
    figures: ReceiverSummary,
}

/// Points of a grid at most: more is a mistake.
const MOST_POINTS: usize = 10_000;
/// Bytes that the scenario may have at all points together: each is read.
const MOST_BYTES: usize = 16 << 20;

/// A scenario at every point of a grid, checked and ready to run.
#[derive(Clone, Debug)]
pub struct Prepared {
    fields: Vec<String>,
    points: Vec<(Vec<String>, Scenario)>,
}

/// Checks a scenario at every point of the grid that the axes span, or of its own grid where there
/// are none. A scenario without any grid is one point.
///
/// # Errors
/// A field or value that the scenario does not take.
pub fn prepare(
    source: &Source,
    axes: &[Axis],
    overrides: &[String],
    receivers: &[String],
) -> anyhow::Result<Prepared> {
    let own: Vec<Axis>;
    let axes = match axes {
        [] => {
            own = source
                .read(overrides)?
                .grid
                .iter()
                .map(Axis::from)
                .collect();
            &own
        }
        axes => axes,
    };
    let grid = grid(axes).with_context(|| source.file.clone())?;
    check_bytes(source, grid.len())?;
    let points = grid.into_iter().map(|point| {
        let scenario = scenario_at(source, axes, &point, overrides, receivers)?;
        Ok((point, scenario))
    });
    Ok(Prepared {
        fields: axes.iter().map(|axis| axis.field.clone()).collect(),
        points: points.collect::<anyhow::Result<_>>()?,
    })
}

impl Prepared {
    /// What is worth a word of its receivers, at the first point of the grid: a line each.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let first = self.points.first();
        let receivers = first
            .into_iter()
            .flat_map(|(_, scenario)| &scenario.receivers);
        let notes = receivers.flat_map(|receiver| {
            let name = &receiver.name;
            (receiver.notes().into_iter()).map(move |note| format!("receiver {name}: {note}"))
        });
        notes.collect()
    }

    /// Runs them all.
    ///
    /// # Errors
    /// A run that fails.
    pub fn run(self, progress: &mut (dyn Progress + Send)) -> anyhow::Result<Sweep> {
        let results = in_parallel(&self.points, progress)?;
        let is_whole = results.iter().all(Option::is_some);
        let rows = self.points.into_iter().zip(results);
        let rows = rows.flat_map(|((values, _), figures)| {
            let figures = figures.into_iter().flatten();
            figures.map(move |(receiver, figures)| Row {
                values: values.clone(),
                receiver,
                figures,
            })
        });
        Ok(Sweep {
            rows: rows.collect(),
            fields: self.fields,
            is_whole,
        })
    }
}

fn check_bytes(source: &Source, points: usize) -> anyhow::Result<()> {
    let bytes = source.text.len();
    // One point is the scenario itself.
    if points > 1 && bytes.saturating_mul(points) > MOST_BYTES {
        bail!(
            "{}: received {bytes} bytes at {points} points of a grid, expected at most {MOST_BYTES} bytes at all of \
             them together",
            source.file
        );
    }
    Ok(())
}

/// All combinations, the last axis running fastest.
fn grid(axes: &[Axis]) -> anyhow::Result<Vec<Vec<String>>> {
    let count = axes.iter().try_fold(1_usize, |count, axis| {
        count
            .checked_mul(axis.values.len())
            .filter(|n| *n <= MOST_POINTS)
    });
    if count.is_none() {
        bail!("sweep: received a grid of more than {MOST_POINTS} points, expected fewer values");
    }
    let mut points = vec![Vec::new()];
    for axis in axes {
        points = points
            .iter()
            .flat_map(|point: &Vec<String>| {
                axis.values.iter().map(|value| {
                    let mut longer = point.clone();
                    longer.push(value.clone());
                    longer
                })
            })
            .collect();
    }
    Ok(points)
}

fn scenario_at(
    source: &Source,
    axes: &[Axis],
    point: &[String],
    overrides: &[String],
    receivers: &[String],
) -> anyhow::Result<Scenario> {
    let at_point = axes
        .iter()
        .zip(point)
        .map(|(axis, value)| format!("{}={value}", axis.field));
    let all: Vec<String> = overrides.iter().cloned().chain(at_point).collect();
    let mut scenario = source.read(&all)?;
    if !receivers.is_empty() {
        scenario
            .keep_receivers(receivers)
            .map_err(|reason| anyhow::anyhow!("--receivers: {reason}"))?;
    }
    Ok(scenario)
}

type Figures = Vec<(String, ReceiverSummary)>;

/// Each core takes the next scenario that nobody has begun. Those that nobody has, as the run was ended before, have no
/// figures.
fn in_parallel(
    scenarios: &[(Vec<String>, Scenario)],
    progress: &mut (dyn Progress + Send),
) -> anyhow::Result<Vec<Option<Figures>>> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let waiting = Mutex::new(scenarios.iter().enumerate());
    let finished: Mutex<Vec<Option<anyhow::Result<Figures>>>> =
        Mutex::new(scenarios.iter().map(|_| None).collect());
    let progress = Mutex::new((progress, 0_usize));
    std::thread::scope(|scope| {
        for _ in 0..cores.min(scenarios.len()) {
            scope.spawn(|| {
                while let Some((n, (_, scenario))) = lock(&waiting).next() {
                    let result =
                        virtual_time::run(scenario, &mut (), &mut ()).map(Finished::into_figures);
                    lock(&finished)[n] = Some(result);
                    let (progress, done) = &mut *lock(&progress);
                    *done += 1;
                    if !progress.at(*done as f64 / scenarios.len() as f64) {
                        break;
                    }
                }
            });
        }
    });
    finished
        .into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
        .into_iter()
        .map(Option::transpose)
        .collect()
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

type Figure = fn(&ReceiverSummary) -> Option<f64>;

/// The figures a sweep shows, with their units.
const COLUMNS: [(&str, Figure); 8] = [
    ("sync_s", |r| r.time_to_sync_s),
    ("drift_ppm", |r| r.last.far.drift_ppm),
    ("drift_true_ppm", |r| r.drift_ppm_true),
    ("ripple_max", |r| r.velocity_ripple_max),
    ("ripple_rms", |r| r.velocity_ripple_rms),
    ("time_error_rms_us", |r| r.corrected_time_error_rms_us),
    ("time_error_max_us", |r| r.corrected_time_error_max_us),
    ("lag_us", |r| r.lag_us),
];

impl Sweep {
    /// Whether all points were run: it was not ended before.
    #[must_use]
    pub const fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// The sweep as a table for people.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = Table::new();
        table.load_style(presets::ASCII_MARKDOWN);
        table.set_header(self.header());
        for row in &self.rows {
            table.add_row(self.cells(row).into_iter().enumerate().map(|(n, text)| {
                let alignment = if n <= self.fields.len() {
                    CellAlignment::Left
                } else {
                    CellAlignment::Right
                };
                Cell::new(text).set_alignment(alignment)
            }));
        }
        table.trim_fmt()
    }

    /// Writes the sweep as CSV.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_csv(&self, path: &Path) -> anyhow::Result<()> {
        let cannot = || format!("cannot write {}", path.display());
        let mut writer = csv::Writer::from_path(path).with_context(cannot)?;
        writer.write_record(self.header()).with_context(cannot)?;
        for row in &self.rows {
            writer.write_record(self.cells(row)).with_context(cannot)?;
        }
        writer.flush().with_context(cannot)
    }

    fn header(&self) -> Vec<String> {
        let columns = COLUMNS.iter().map(|(name, _)| (*name).to_owned());
        let receiver = std::iter::once("receiver".to_owned());
        self.fields
            .iter()
            .cloned()
            .chain(receiver)
            .chain(columns)
            .collect()
    }

    fn cells(&self, row: &Row) -> Vec<String> {
        let figures = COLUMNS
            .iter()
            .map(|(_, of)| of(&row.figures).map_or_else(|| "–".to_owned(), |n| significant(n, 4)));
        row.values
            .iter()
            .cloned()
            .chain(std::iter::once(row.receiver.clone()))
            .chain(figures)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_may_be_tables() {
        let axis: Axis = "network.jitter={ normal-us = 5 },{ exponential-us = [1, 2] },3"
            .parse()
            .unwrap();
        assert_eq!(
            axis.values,
            ["{ normal-us = 5 }", "{ exponential-us = [1, 2] }", "3"]
        );
        assert!("seed".parse::<Axis>().is_err());
        assert!("seed=1,,2".parse::<Axis>().is_err());
    }

    #[test]
    fn the_last_axis_runs_fastest() {
        let axes: Vec<Axis> = ["a=1,2", "b=x,y"].map(|text| text.parse().unwrap()).into();
        let points = grid(&axes).unwrap();
        assert_eq!(points, [["1", "x"], ["1", "y"], ["2", "x"], ["2", "y"]]);
    }

    #[test]
    fn every_point_and_receiver_has_a_row() {
        let source = crate::catalog::find("beat-sender-fast").unwrap();
        let axes = ["sender.master.clock.drift-ppm=400,800".parse().unwrap()];
        let overrides = ["duration-s=8".to_owned(), "expect=[]".to_owned()];
        let receivers = ["sync".to_owned(), "bypass".to_owned()];
        let prepared = prepare(&source, &axes, &overrides, &receivers).unwrap();
        let sweep = prepared.run(&mut ()).unwrap();
        assert_eq!(sweep.rows.len(), 4);
        let estimates: Vec<_> = sweep
            .rows
            .iter()
            .filter(|row| row.receiver == "sync")
            .map(|row| row.figures.last.far.drift_ppm.unwrap().round())
            .collect();
        assert_eq!(estimates, [400.0, 800.0]);
        assert!(sweep.table().lines().count() >= 6);
    }

    #[test]
    fn a_scenario_brings_its_own_grid() {
        let source = crate::catalog::find("observer-sweep").unwrap();
        let prepared = prepare(&source, &[], &[], &[]).unwrap();
        assert_eq!(prepared.fields.len(), 3);
        assert_eq!(prepared.points.len(), 36);
        let axes = ["seed=1,2".parse().unwrap()];
        let prepared = prepare(&source, &axes, &[], &[]).unwrap();
        assert_eq!(prepared.fields, ["seed"]);
    }

    #[test]
    fn a_value_that_does_not_fit_is_named_before_anything_runs() {
        let source = crate::catalog::find("beat").unwrap();
        let axes = ["network.loss=0.1,1.5".parse().unwrap()];
        let error = prepare(&source, &axes, &[], &[]).unwrap_err();
        assert!(format!("{error:#}").contains("network.loss: received 1.5"));
    }
}
