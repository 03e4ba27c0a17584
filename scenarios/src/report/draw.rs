//! What every plot is made of: numbers, lines, bands, axes and colours.

use serde_json::{Value, json};

use super::html::escaped;
use crate::curves::{Curves, Series, Stretch};

/// A receiver as plots show it.
#[derive(Clone, Debug)]
pub(super) struct Shown<'a> {
    pub(super) curves: &'a Curves,
    /// The name, safe where the plotting library would take tags for markup.
    pub(super) name: String,
    pub(super) colour: &'static str,
}

/// Distinguishable with any colour vision, and on white as on black. The first belong to the modes.
pub(crate) const COLOURS: [&str; 7] = [
    "#d9541e", "#d99a00", "#0b9c78", "#2f86d6", "#b06fa8", "#4fb0dc", "#8c7a5b",
];
/// Modes that have a colour of their own.
const MODES: usize = 4;
/// What is no receiver's: the drive, the truth.
pub(crate) const NEUTRAL: &str = "#8a8a8a";

/// The receivers with a colour each; the first of each mode has the mode's own, in every report.
pub(super) fn coloured<'a>(curves: &[&'a Curves]) -> Vec<Shown<'a>> {
    let mut taken = [false; COLOURS.len()];
    let own: Vec<Option<usize>> = curves
        .iter()
        .map(|curves| {
            let own = usize::from(crate::table::rank(curves.mode));
            (!std::mem::replace(&mut taken[own], true)).then_some(own)
        })
        .collect();
    // Those of absent modes last, so that a colour keeps its meaning as long as possible.
    let others = (MODES..COLOURS.len()).chain((0..MODES).filter(|n| !taken[*n]));
    let mut free = others.cycle();
    curves
        .iter()
        .zip(own)
        .map(|(curves, own)| Shown {
            curves,
            name: escaped(&curves.name),
            colour: COLOURS[own.or_else(|| free.next()).unwrap_or(0)],
        })
        .collect()
}

/// A number with seven significant digits; null where there is none.
pub(super) fn number(value: f64) -> Value {
    if !value.is_finite() {
        return Value::Null;
    }
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    if rounded.fract() == 0.0 && rounded.abs() < 1e9 {
        // Shorter than with the decimal point.
        Value::from(rounded as i64)
    } else {
        Value::from(rounded)
    }
}

/// Many numbers.
pub(super) fn numbers(values: impl IntoIterator<Item = f64>) -> Value {
    values.into_iter().map(number).collect()
}

/// The curve with at most so many stretches, neighbours joined; shifted by an offset.
pub(super) fn thinned(series: &Series, most: usize, offset: f64) -> Vec<Stretch> {
    let per_group = series.stretches.len().div_ceil(most.max(1)).max(1);
    series
        .stretches
        .chunks(per_group)
        .map(|group| {
            let low = group.iter().fold(f64::INFINITY, |low, s| low.min(s.low));
            let high = group
                .iter()
                .fold(f64::NEG_INFINITY, |high, s| high.max(s.high));
            Stretch {
                t_s: group[0].t_s,
                low: low + offset,
                high: high + offset,
            }
        })
        .collect()
}

/// How a curve looks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pen<'a> {
    pub(super) name: &'a str,
    /// Curves of a group are hidden together.
    pub(super) group: &'a str,
    pub(super) colour: &'a str,
    pub(super) in_legend: bool,
    /// `x`, and the vertical axis such as `y2`.
    pub(super) axis: &'a str,
}

impl Pen<'_> {
    /// A line through points.
    pub(super) fn line(&self, x: Value, y: Value) -> Value {
        json!({
            "type": "scatter",
            "mode": "lines",
            "name": self.name,
            "legendgroup": self.group,
            "showlegend": self.in_legend,
            "xaxis": "x",
            "yaxis": self.axis,
            "x": x,
            "y": y,
            "line": { "color": self.colour, "width": 1.3 },
        })
    }

    /// A curve: a filled band between its extremes where they differ, a line where they do not.
    pub(super) fn curve(&self, stretches: &[Stretch]) -> Vec<Value> {
        let x = numbers(stretches.iter().map(|s| s.t_s));
        let low = self.line(x.clone(), numbers(stretches.iter().map(|s| s.low)));
        if stretches.iter().all(|s| s.low == s.high) {
            return vec![low];
        }
        let mut low = low;
        low["showlegend"] = false.into();
        low["line"]["width"] = 0.8.into();
        let mut high = self.line(x, numbers(stretches.iter().map(|s| s.high)));
        high["line"]["width"] = 0.8.into();
        high["fill"] = "tonexty".into();
        high["fillcolor"] = format!("{}66", self.colour).into();
        vec![low, high]
    }
}

/// The layout all plots share.
pub(crate) fn layout(x_title: &str) -> Value {
    json!({
        "margin": { "l": 70, "r": 20, "t": 40, "b": 50 },
        "hovermode": "closest",
        "legend": { "orientation": "h", "x": 0, "y": 1, "yanchor": "bottom" },
        "xaxis": { "title": { "text": x_title }, "zeroline": false },
    })
}

/// A vertical axis.
pub(crate) fn vertical(title: &str, range: Option<(f64, f64)>) -> Value {
    let mut axis = json!({ "title": { "text": title }, "zeroline": false });
    if let Some((low, high)) = range {
        axis["range"] = numbers([low, high]);
    }
    axis
}

/// A range that shows all of these curves, but for rare values far beyond the others: a single jump
/// at the start must not flatten everything else. A beat's spike is not that far away.
pub(super) fn range_of<'a>(stretches: impl Iterator<Item = &'a Stretch>) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = stretches
        .flat_map(|s| [s.low, s.high])
        .filter(|value| value.is_finite())
        .collect();
    if values.is_empty() {
        return None;
    }
    values.sort_by(f64::total_cmp);
    let last = values.len() - 1;
    let usual_low = values[last / 50];
    let usual_high = values[last - last / 50];
    let reach = 2.0 * usual_low.abs().max(usual_high.abs());
    let (low, high) = if reach > 0.0 {
        (
            values[0].max(usual_low - reach),
            values[last].min(usual_high + reach),
        )
    } else {
        (values[0], values[last])
    };
    // What is constant must not look wild.
    let margin = (0.08 * (high - low)).max(5e-3 * high.abs()).max(1e-9);
    Some((low - margin, high + margin))
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::Unit;

    #[test]
    fn numbers_are_short_and_never_nan() {
        assert_eq!(number(f64::NAN), Value::Null);
        assert_eq!(number(f64::INFINITY), Value::Null);
        assert_eq!(number(1.234_567_891).to_string(), "1.234568");
        assert_eq!(number(499.999_999_99).to_string(), "500");
        assert_eq!(number(-0.000_012_345_678_9), Value::from(-1.234_568e-5));
    }

    #[test]
    fn thinning_keeps_the_extremes() {
        let mut series = Series::default();
        for k in 0..1_000 {
            let value = if k == 500 { 7.0 } else { 1.0 };
            series.push(f64::from(k), Some(value));
        }
        let thin = thinned(&series, 90, 1.0);
        assert!(thin.len() <= 90);
        assert_eq!(thin.iter().filter(|s| s.high == 8.0).count(), 1);
        assert!(thin.iter().all(|s| s.low == 2.0));
    }

    #[test]
    fn a_range_shows_beats_but_not_a_leap() {
        let mut values = vec![500.0; 998];
        values.push(0.0);
        values.push(1e9);
        let stretches: Vec<_> = values
            .into_iter()
            .map(|value| Stretch {
                t_s: 0.0,
                low: value,
                high: value,
            })
            .collect();
        let (low, high) = range_of(stretches.iter()).unwrap();
        assert!(low < 0.0 && low > -200.0, "{low}");
        assert!(high > 1000.0 && high < 2000.0, "{high}");
        assert_eq!(range_of([].iter()), None);
    }

    fn curves(name: &str, mode: &'static str) -> Curves {
        Curves::new(name, mode, Unit::default(), [("slave", Unit::default())])
    }

    #[test]
    fn every_mode_keeps_its_colour() {
        let bare = curves("a", "bypass");
        let first = curves("b", "sync");
        let second = curves("c", "sync");
        let one: Vec<_> = coloured(&[&first]).iter().map(|s| s.colour).collect();
        let all: Vec<_> = coloured(&[&bare, &first, &second])
            .iter()
            .map(|s| s.colour)
            .collect();
        assert_eq!(one[0], all[1]);
        assert_ne!(all[1], all[2]);
        assert_ne!(all[0], all[2]);
    }
}
