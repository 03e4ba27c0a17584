//! Position, velocity, acceleration and jerk as charts, one above the other.

use coaxle_curve::law::Motion;
use serde_json::{Value, json};

use super::QUANTITIES;
use crate::page::{axis_name, band, escaped, layout, vertical};
use crate::plotting::NEUTRAL;

/// Four charts over one axis.
pub struct Charts {
    /// What lies along the axis, with its unit.
    pub along: String,
    /// The quantities with their units.
    pub headings: [String; 4],
    /// The curves.
    pub course: Sampled,
    /// Places on them to point out.
    pub marks: Sampled,
    /// What they are.
    pub labels: Vec<String>,
    /// Levels to compare the curves with.
    pub lines: [Vec<Line>; 4],
}

/// A level in a chart.
pub struct Line {
    /// What it is.
    pub name: &'static str,
    /// Where it is.
    pub value: f64,
    /// Whether it binds: otherwise it is only dotted.
    pub binds: bool,
}

/// Places along the axis, and what the slave does there.
#[derive(Default)]
pub struct Sampled {
    along: Vec<f64>,
    values: [Vec<f64>; 4],
}

/// Of position, velocity, acceleration and jerk.
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
    /// Where the places are, and the position, velocity, acceleration and jerk there.
    pub const fn columns(&self) -> (&Vec<f64>, &[Vec<f64>; 4]) {
        (&self.along, &self.values)
    }
}

impl Charts {
    /// The figure, as the plotting library takes it.
    pub fn figure(&self) -> Value {
        let mut layout = layout(&escaped(&self.along));
        let mut data = Vec::new();
        for (n, heading) in self.headings.iter().enumerate() {
            let axis = axis_name(n);
            let mut scale = vertical(&escaped(heading), self.range(n));
            scale["domain"] = band(n, QUANTITIES.len());
            scale["exponentformat"] = "power".into();
            layout[axis.replacen('y', "yaxis", 1)] = scale;
            data.push(self.curve(n, &axis));
            data.push(self.points(n, &axis));
            data.extend(self.lines[n].iter().map(|line| self.level(line, &axis)));
        }
        layout["showlegend"] = false.into();
        layout["hovermode"] = "x".into();
        layout["hoversubplots"] = "axis".into();
        layout["xaxis"]["anchor"] = axis_name(QUANTITIES.len() - 1).into();
        if self.course.along.last() < self.course.along.first() {
            // Time shall go from left to right.
            layout["xaxis"]["autorange"] = "reversed".into();
        }
        json!({ "data": data, "layout": layout })
    }

    fn curve(&self, quantity: usize, axis: &str) -> Value {
        json!({
            "type": "scatter",
            "mode": "lines",
            "name": QUANTITIES[quantity],
            "xaxis": "x",
            "yaxis": axis,
            "x": self.course.along,
            "y": self.course.values[quantity],
            "line": { "color": COLOURS[quantity], "width": 1.5, "simplify": false },
            "hovertemplate": "%{y:.6~g}",
        })
    }

    fn points(&self, quantity: usize, axis: &str) -> Value {
        json!({
            "type": "scatter",
            "mode": "markers",
            "name": "points",
            "xaxis": "x",
            "yaxis": axis,
            "x": self.marks.along,
            "y": self.marks.values[quantity],
            "text": self.labels,
            "marker": { "color": NEUTRAL, "size": 7 },
            "hovertemplate": "%{text}<extra></extra>",
        })
    }

    fn level(&self, line: &Line, axis: &str) -> Value {
        let along = &self.course.along;
        json!({
            "type": "scatter",
            "mode": "lines",
            "name": line.name,
            "xaxis": "x",
            "yaxis": axis,
            "x": [along.first(), along.last()],
            "y": [line.value, line.value],
            "line": {
                "color": NEUTRAL,
                "width": 1.2,
                "dash": if line.binds { "dash" } else { "dot" },
            },
            "hovertemplate": "%{y:.6~g}",
        })
    }

    /// The curve with the levels near it: one far away must not flatten it. None where the charts
    /// may show everything.
    fn range(&self, quantity: usize) -> Option<(f64, f64)> {
        /// The least share of the height that is the curve's.
        const SHARE: f64 = 0.3;
        let lines = &self.lines[quantity];
        let values = &self.course.values[quantity];
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let height = high - low;
        if lines.is_empty() || !(height > 0.0 && height.is_finite()) {
            return None;
        }
        let near =
            |value: f64| (low - value).max(value - high) <= height / 2.0 * (1.0 / SHARE - 1.0);
        let shown = lines.iter().map(|line| line.value).filter(|&v| near(v));
        let (low, high) = shown.fold((low, high), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        let margin = 0.05 * (high - low);
        Some((low - margin, high + margin))
    }
}
