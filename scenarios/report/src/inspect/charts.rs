//! Position, velocity, acceleration and jerk as charts, one above the other.

use coaxle_curve::law::Motion;

use super::QUANTITIES;
use crate::figure::{Across, Curve, Data, Figure, Look, Panel, Scale, around, thinned};
use crate::plotting::NEUTRAL;

/// Four charts over one axis.
pub struct Charts {
    /// Quantity along the axis, and its unit.
    pub along: (String, String),
    /// Units of the four quantities.
    pub units: [String; 4],
    /// The curves.
    pub course: Sampled,
    /// Places on the curves to mark.
    pub marks: Sampled,
    /// Labels of the marks.
    pub labels: Vec<String>,
    /// Levels to compare the curves with.
    pub lines: [Vec<LevelLine>; 4],
}

/// A level in a chart.
pub struct LevelLine {
    /// Name of the level.
    pub name: &'static str,
    /// Value of the level.
    pub value: f64,
    /// True if it binds: otherwise it is only dotted.
    pub binds: bool,
}

/// Places along the axis, and the motion of the slave there.
#[derive(Default)]
pub struct Sampled {
    along: Vec<f64>,
    values: [Vec<f64>; 4],
}

/// Colours of position, velocity, acceleration and jerk.
const COLOURS: [&str; 4] = ["#2f86d6", "#0b9c78", "#d99a00", "#d9541e"];

impl Sampled {
    /// Appends a place.
    pub fn push(&mut self, along: f64, motion: Motion) {
        let Motion {
            position,
            velocity,
            acceleration,
            jerk,
        } = motion;
        self.along.push(along);
        let values = [position, velocity, acceleration, jerk];
        for (column, value) in self.values.iter_mut().zip(values) {
            column.push(value);
        }
    }
}

impl Sampled {
    /// Returns the points of a quantity over the places.
    fn points(&self, quantity: usize) -> Vec<(f64, f64)> {
        let values = self.values[quantity].iter();
        self.along.iter().copied().zip(values.copied()).collect()
    }

    /// Returns the least and the largest value of a quantity.
    fn extent(&self, quantity: usize) -> (f64, f64) {
        let values = self.values[quantity].iter();
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(*value), high.max(*value))
        })
    }

    /// Returns the places, and the position, velocity, acceleration and jerk there.
    pub const fn columns(&self) -> (&Vec<f64>, &[Vec<f64>; 4]) {
        (&self.along, &self.values)
    }
}

/// Columns that a curve of very many places is thinned to: about what a screen has. Four points a column are kept, so that the
/// page of a table of noise in all four charts stays below 200 kB; fewer than 3 200 places are all there.
const COLUMNS: usize = 800;
/// Height of a chart in a browser, pixels.
const HEIGHT: usize = 210;

impl Charts {
    /// Returns the figure, without its words.
    #[must_use]
    pub fn figure(&self) -> Figure {
        let (name, unit) = &self.along;
        let mut across = Across::of(name, unit);
        across.is_padded = true;
        if self.course.along.last() < self.course.along.first() {
            // Time shall go from left to right.
            across.scale = Scale::Backwards;
        }
        let panel = |(n, unit): (usize, &String)| Panel {
            quantity: QUANTITIES[n].to_owned(),
            unit: unit.clone(),
            height: HEIGHT,
            range: self.range(n),
            curves: self.curves(n),
            ..Panel::default()
        };
        Figure {
            across,
            panels: self.units.iter().enumerate().map(panel).collect(),
            ..Figure::default()
        }
    }

    fn curves(&self, quantity: usize) -> Vec<Curve> {
        let levels = self.lines[quantity].iter();
        let levels = levels.map(|line| self.level(line, quantity));
        let course = thinned(&self.course.points(quantity), COLUMNS);
        let course = Curve::new(
            QUANTITIES[quantity],
            COLOURS[quantity],
            Data::Course(course),
        );
        let marks = Data::Points(self.marks.points(quantity));
        let marks = Curve {
            look: Look::Marks,
            labels: self.labels.clone(),
            ..Curve::new("points", NEUTRAL, marks)
        };
        let mut curves: Vec<_> = levels.chain([course]).collect();
        if !marks.data.is_empty() {
            curves.push(marks);
        }
        curves
    }

    fn level(&self, line: &LevelLine, quantity: usize) -> Curve {
        let along = &self.course.along;
        // Without a course a level has no ends, and points that are not numbers are not drawn.
        let [from, to] = [along.first(), along.last()].map(|end| end.copied().unwrap_or(f64::NAN));
        Curve {
            look: if line.binds {
                Look::Dashed
            } else {
                Look::Dotted
            },
            is_aside: !self.is_near(line.value, quantity),
            ..Curve::level(line.name, line.value, from, to)
        }
    }

    /// Reports whether a level lies so near the curve that both can be shown: one far away must not flatten it.
    fn is_near(&self, level: f64, quantity: usize) -> bool {
        /// Least share of the height for the curve.
        const SHARE: f64 = 0.3;
        let (low, high) = self.course.extent(quantity);
        let height = high - low;
        // A constant cannot be flattened.
        let is_flat = !(height > 0.0 && height.is_finite());
        // Limits come in pairs: with a level at distance d on either side, h of the height h + 2·d is the curve's.
        is_flat || (low - level).max(level - high) <= height / 2.0 * (1.0 / SHARE - 1.0)
    }

    /// Returns the range of the curve with the levels near it.
    fn range(&self, quantity: usize) -> Option<(f64, f64)> {
        let lines = self.lines[quantity].iter().map(|line| line.value);
        let near = lines.filter(|value| self.is_near(*value, quantity));
        around(
            self.course.values[quantity].iter().copied().chain(near),
            0.05,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn charts(values: &[f64], lines: Vec<LevelLine>) -> Charts {
        let mut course = Sampled::default();
        for (n, value) in values.iter().enumerate() {
            let motion = Motion {
                position: *value,
                velocity: 0.0,
                acceleration: 0.0,
                jerk: 0.0,
            };
            // Only the position matters here: each quantity has a chart of its own.
            course.push(n as f64, motion);
        }
        Charts {
            along: ("master".to_owned(), "°".to_owned()),
            units: Default::default(),
            course,
            marks: Sampled::default(),
            labels: Vec::new(),
            lines: [lines, Vec::new(), Vec::new(), Vec::new()],
        }
    }

    #[test]
    fn a_limit_far_away_is_there_and_decides_no_range() {
        let limit = |value| LevelLine {
            name: "limit",
            value,
            binds: true,
        };
        let charts = charts(&[0.0, 1.0], vec![limit(1.5), limit(100.0)]);
        let figure = charts.figure();
        let [near, far, course] = figure.panels[0].curves.as_slice() else {
            panic!("three curves");
        };
        assert!(!near.is_aside && far.is_aside && !course.is_aside);
        let (low, high) = figure.panels[0].range.unwrap();
        assert!(low < 0.0 && high > 1.5 && high < 2.0, "{low} {high}");
    }

    #[test]
    fn a_row_of_a_long_table_is_not_lost() {
        let mut values = vec![0.0; 50_000];
        values[31_007] = 3.0;
        let figure = charts(&values, Vec::new()).figure();
        let Data::Course(points) = &figure.panels[0].curves[0].data else {
            panic!("a course");
        };
        assert!(points.len() <= 4 * (COLUMNS + 1), "{}", points.len());
        assert!(points.contains(&(31_007.0, 3.0)));
        assert_eq!(points.last(), Some(&(49_999.0, 0.0)));
    }
}
