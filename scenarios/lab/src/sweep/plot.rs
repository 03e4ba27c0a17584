//! Plots of a sweep: a figure over the grid, for any drawing program.
//!
//! Over one axis it is a curve for each receiver or slave, over two a map for each; axes beyond the second have a map for each of
//! their values. Axes with a single value do not count.

use coaxle_node::signal::Kind;
use coaxle_os::exit::wrong_argument;

use super::grid::SweepAxis;
use super::group::PointGroup;
use super::shown::COLUMNS;
use super::statistics::Statistics;
use crate::figures::{SummaryFigure, Units};

/// First choice for a scenario with cuts.
const CUTTING: &str = "slave.cut_length_error_max";
/// Choice for every receiver.
const TIME_ERROR: &str = "corrected_time_error_rms_us";

/// A figure over the grid.
#[derive(Clone, Debug)]
pub struct Plot {
    /// The figure with its unit.
    pub heading: String,
    /// The horizontal field.
    pub across: Along,
    /// The vertical field of a map; absent for a plot of curves.
    pub up: Option<Along>,
    /// The curves or maps.
    pub panels: Vec<Panel>,
    /// Number of further panels that are left out.
    pub more: usize,
}

/// A field along which a plot goes.
#[derive(Clone, Debug)]
pub struct Along {
    /// Path of the field.
    pub field: String,
    /// Values of the field, numbers in their order.
    pub values: Vec<String>,
    /// Values as numbers, if all are numbers.
    pub numbers: Option<Vec<f64>>,
    /// Place of each value among the values of the axis.
    order: Vec<usize>,
}

/// A curve or a map.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The receiver, its slave, and the values of further axes.
    pub title: String,
    /// The figure at each value across, row by row upwards.
    pub cells: Vec<Option<Statistics>>,
}

/// Most curves or maps of a plot.
// Three columns of maps in four rows.
const MOST_PANELS: usize = 12;

/// Checks that the figure exists.
///
/// # Errors
/// Names the figure that was not found, and those that contain its name.
pub(super) fn check_figure(name: Option<&str>, figures: &[SummaryFigure]) -> anyhow::Result<()> {
    let plotted = |figure: &&SummaryFigure| figure.kind != Kind::Text;
    let Some(name) = name else {
        return Ok(());
    };
    if figures
        .iter()
        .filter(plotted)
        .any(|figure| figure.name == name)
    {
        return Ok(());
    }
    let alike = figures.iter().filter(plotted);
    let alike = alike.map(|figure| figure.name.as_str());
    let alike: Vec<_> = alike.filter(|known| known.contains(name)).collect();
    let known = match alike.as_slice() {
        [] => format!("such as {TIME_ERROR} or {CUTTING}"),
        alike => format!("such as {}", alike.join(", ")),
    };
    wrong_argument(format!(
        "--figure: received {name:?}, expected a figure as the columns of points.csv name them without their units, {known}"
    ))
}

/// A point: each field with its value.
pub(super) fn point_name(axes: &[SweepAxis], values: &[String]) -> String {
    let pairs = axes.iter().zip(values);
    let pairs: Vec<_> = pairs
        .map(|(axis, value)| format!("{}={value}", axis.field))
        .collect();
    match pairs.as_slice() {
        [] => "the scenario".to_owned(),
        pairs => pairs.join(" "),
    }
}

/// Collects the plotted figures, point by point.
pub(super) struct Plots<'a> {
    axes: &'a [SweepAxis],
    points: usize,
    drawn: Vec<PlottedFigure<'a>>,
}

/// A figure, and its statistics for each receiver or slave at each point.
struct PlottedFigure<'a> {
    figure: &'a SummaryFigure,
    series: Vec<(String, Vec<Option<Statistics>>)>,
}

impl<'a> Plots<'a> {
    /// Plots of the named figure and the usual ones.
    pub(super) fn new(
        axes: &'a [SweepAxis],
        figures: &'a [SummaryFigure],
        wanted: Option<&str>,
    ) -> Self {
        let usual = [CUTTING, TIME_ERROR].into_iter();
        // The first of the list is `plot.svg`: cuts are the purpose of a scenario that has some.
        let usual = usual.chain(COLUMNS.map(|(_, name)| name));
        let mut drawn: Vec<PlottedFigure<'_>> = Vec::new();
        for name in wanted.into_iter().chain(usual) {
            let is_new = drawn.iter().all(|drawn| drawn.figure.name != name);
            let figure = figures.iter().find(|figure| figure.name == name);
            if let (Some(figure), true) = (figure, is_new) {
                let series = Vec::new();
                drawn.push(PlottedFigure { figure, series });
            }
        }
        let points = axes.iter().map(|axis| axis.values.len()).product();
        Self {
            axes,
            points,
            drawn,
        }
    }

    /// Takes the figures of a receiver or slave at the n-th point.
    pub(super) fn add(&mut self, point: usize, group: &PointGroup<'_>) {
        for PlottedFigure { figure, series } in &mut self.drawn {
            let name = match (figure.is_of_slave, group.slave) {
                (true, Some(slave)) => format!("{}.{slave}", group.receiver),
                // Rows of further slaves repeat the receiver's figures.
                (false, _) if group.is_first => group.receiver.to_owned(),
                _ => continue,
            };
            let Some(statistics) = Statistics::of(figure, &group.rows) else {
                continue;
            };
            let place = series.iter().position(|(known, _)| *known == name);
            let place = place.unwrap_or_else(|| {
                series.push((name, vec![None; self.points]));
                series.len() - 1
            });
            series[place].1[point] = Some(statistics);
        }
    }

    /// A plot for each figure that has values, the most interesting one first.
    pub(super) fn finish(self, units: &Units) -> Vec<Plot> {
        let Self { axes, drawn, .. } = self;
        let plots = drawn.into_iter().filter_map(|drawn| {
            let heading = drawn.figure.heading(units);
            plot(axes, heading, drawn.series)
        });
        plots.collect()
    }
}

fn plot(
    axes: &[SweepAxis],
    heading: String,
    series: Vec<(String, Vec<Option<Statistics>>)>,
) -> Option<Plot> {
    let varied = axes.iter().enumerate();
    // A field with a single value has no direction to plot along.
    let mut varied = varied.filter(|(_, axis)| axis.values.len() > 1);
    let (first, second) = (varied.next()?, varied.next());
    let further: Vec<_> = varied.collect();
    let across = Along::of(first.1);
    let up = second.map(|(_, axis)| Along::of(axis));
    let mut panels = Vec::new();
    for (name, values) in series {
        for combination in combinations(&further) {
            let mut point = vec![0; axes.len()];
            let mut title = name.clone();
            for (n, value) in &combination {
                point[*n] = *value;
                title += &format!(", {}={}", axes[*n].field, axes[*n].values[*value]);
            }
            let rows = up.as_ref().map_or(&[0][..], |up| &up.order);
            let mut cells = Vec::with_capacity(rows.len() * across.order.len());
            for row in rows {
                for column in &across.order {
                    point[first.0] = *column;
                    if let Some((n, _)) = second {
                        point[n] = *row;
                    }
                    cells.push(values[index(axes, &point)]);
                }
            }
            panels.push(Panel { title, cells });
        }
    }
    let more = panels.len().saturating_sub(MOST_PANELS);
    panels.truncate(MOST_PANELS);
    (!panels.is_empty()).then_some(Plot {
        heading,
        across,
        up,
        panels,
        more,
    })
}

/// Every combination of these axes: the axes' indices with a value's index each.
fn combinations(axes: &[(usize, &SweepAxis)]) -> Vec<Vec<(usize, usize)>> {
    let mut all = vec![Vec::new()];
    for (n, axis) in axes {
        let longer = all.iter().flat_map(|begun: &Vec<(usize, usize)>| {
            (0..axis.values.len()).map(move |value| {
                let mut one = begun.clone();
                one.push((*n, value));
                one
            })
        });
        all = longer.collect();
    }
    all
}

/// Index of a point: the last axis runs fastest.
fn index(axes: &[SweepAxis], point: &[usize]) -> usize {
    let places = axes.iter().zip(point);
    places.fold(0, |index, (axis, place)| index * axis.values.len() + place)
}

impl Along {
    /// The field of an axis of the grid.
    #[must_use]
    pub fn of(axis: &SweepAxis) -> Self {
        let mut order: Vec<usize> = (0..axis.values.len()).collect();
        let numbers = axis.numbers();
        if let Some(numbers) = &numbers {
            // By number, as a line through values in the order of the command line would run back.
            order.sort_by(|a, b| numbers[*a].total_cmp(&numbers[*b]));
        }
        Self {
            field: axis.field.clone(),
            values: order.iter().map(|n| axis.values[*n].clone()).collect(),
            numbers: numbers.map(|numbers| order.iter().map(|n| numbers[*n]).collect()),
            order,
        }
    }

    /// Places of the values: at their numbers, or one beside the other.
    #[must_use]
    pub fn places(&self) -> Vec<f64> {
        let beside = || (0..self.values.len()).map(|n| n as f64).collect();
        self.numbers.clone().unwrap_or_else(beside)
    }
}

impl Plot {
    /// The least and the largest median of all panels; none without any.
    #[must_use]
    pub fn range(&self) -> Option<(f64, f64)> {
        let cells = self.panels.iter().flat_map(|panel| &panel.cells);
        let medians = cells.flatten().map(|cell| cell.median);
        medians.fold(None, |range, median| {
            let (low, high) = range.unwrap_or((median, median));
            Some((low.min(median), high.max(median)))
        })
    }
}

/// True if a logarithmic scale suits the values: all above zero, over more than this factor.
#[must_use]
pub fn is_logarithmic(values: impl Iterator<Item = f64>) -> bool {
    // A decade and a half: the least value would lie in the lowest thirtieth of a linear scale.
    const FACTOR: f64 = 30.0;
    // Without values `high` stays 0, below any multiple of infinity.
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    low > 0.0 && high > FACTOR * low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(texts: &[&str]) -> Vec<SweepAxis> {
        texts.iter().map(|text| text.parse().unwrap()).collect()
    }

    fn of(value: f64) -> Option<Statistics> {
        Some(Statistics {
            known: 1,
            median: value,
            low: value,
            high: value,
            worst: value,
        })
    }

    fn plotted(texts: &[&str]) -> Option<Plot> {
        let axes = axes(texts);
        let points: usize = axes.iter().map(|axis| axis.values.len()).product();
        let values = (0..points).map(|n| of(n as f64)).collect();
        plot(&axes, "x".to_owned(), vec![("observer".to_owned(), values)])
    }

    fn medians(panel: &Panel) -> Vec<f64> {
        let cells = panel.cells.iter().flatten();
        cells.map(|cell| cell.median).collect()
    }

    #[test]
    fn one_axis_is_a_curve_with_its_numbers_in_order() {
        let plot = plotted(&["b=7", "a=3,1,2"]).unwrap();
        assert!(plot.up.is_none());
        assert_eq!(plot.across.places(), [1.0, 2.0, 3.0]);
        assert_eq!(medians(&plot.panels[0]), [1.0, 2.0, 0.0]);
        assert_eq!(
            plotted(&["a=pt1,sync"]).unwrap().across.places(),
            [0.0, 1.0]
        );
        assert!(plotted(&["a=1"]).is_none());
        assert!(plotted(&[]).is_none());
    }

    #[test]
    fn two_axes_are_a_map_and_further_ones_more_maps() {
        let plot = plotted(&["a=1,2,3", "b=1,2"]).unwrap();
        assert_eq!(plot.panels.len(), 1);
        assert_eq!(medians(&plot.panels[0]), [0.0, 2.0, 4.0, 1.0, 3.0, 5.0]);
        assert_eq!(plot.range(), Some((0.0, 5.0)));
        let plot = plotted(&["a=1,2", "b=1,2", "c=x,y"]).unwrap();
        let titles: Vec<_> = plot.panels.iter().map(|panel| &panel.title).collect();
        assert_eq!(titles, ["observer, c=x", "observer, c=y"]);
        assert_eq!(medians(&plot.panels[1]), [1.0, 5.0, 3.0, 7.0]);
        let many = plotted(&["a=1,2", "b=1,2", "c=1,2,3,4,5", "d=1,2,3"]).unwrap();
        assert_eq!((many.panels.len(), many.more), (12, 3));
    }

    #[test]
    fn a_figure_that_there_is_not_is_named_with_those_like_it() {
        let figures = SummaryFigure::all();
        assert!(check_figure(Some("lag_us"), &figures).is_ok());
        for (name, part) in [
            ("ripple_settled", "velocity_ripple_settled_rms, "),
            ("xyz", TIME_ERROR),
            ("mode", "such as "),
        ] {
            let error = check_figure(Some(name), &figures).unwrap_err().to_string();
            assert!(
                error.contains("--figure") && error.contains(part),
                "{error}"
            );
        }
    }

    #[test]
    fn what_spans_decades_is_logarithmic() {
        assert!(is_logarithmic([1.0, 100.0].into_iter()));
        assert!(!is_logarithmic([1.0, 20.0].into_iter()));
        assert!(!is_logarithmic([0.0, 100.0].into_iter()));
        assert!(!is_logarithmic([].into_iter()));
    }
}
