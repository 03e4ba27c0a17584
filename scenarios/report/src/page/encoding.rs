//! Figures as a page holds them: JSON, in which long curves are [text](super::numbers).

use coaxle_lab::curves::Stretch;
use serde_json::{Value, json};

use super::numbers::{fine_step_of, step_of, text, times};
use crate::figure::{Across, Curve, Data, Figure, Panel, Scale};

/// Encodes a figure for the page's script. All its numbers but those of words are places on their scales.
pub(super) fn figure(figure: &Figure) -> Value {
    let ranges = figure.ranges();
    let across = &figure.across;
    let panels: Vec<_> = (figure.panels.iter().zip(ranges))
        .map(|(one, range)| panel(across, one, range))
        .collect();
    json!({
        "unit": across.unit,
        "across": {
            "words": across.words(),
            "scale": across.scale.name(),
            "labels": across.scale.words(),
        },
        "extent": <[f64; 2]>::from(figure.extent()),
        "oneScale": figure.is_on_one_scale,
        "panels": panels,
    })
}

fn panel(across: &Across, panel: &Panel, range: Option<(f64, f64)>) -> Value {
    let curves = panel.curves.iter();
    let curves = curves.map(|one| curve(one, &across.scale, &panel.scale));
    let marks = panel.marks.iter().map(|mark| across.scale.place(*mark));
    json!({
        "title": panel.title,
        "quantity": panel.quantity,
        "unit": panel.unit,
        "height": panel.height,
        "range": range.map(|(low, high)| [number(low), number(high)]),
        "scale": panel.scale.name(),
        "words": panel.scale.words(),
        "marks": marks.map(number).collect::<Vec<_>>(),
        "curves": curves.collect::<Vec<_>>(),
    })
}

fn curve(curve: &Curve, across: &Scale, up: &Scale) -> Value {
    let data = match &curve.data {
        Data::Points(points) => json!({
            "x": points.iter().map(|(x, _)| number(across.place(*x))).collect::<Vec<_>>(),
            "y": points.iter().map(|(_, y)| number(up.place(*y))).collect::<Vec<_>>(),
        }),
        Data::Course(points) => {
            let [x, y] = [
                course(points.iter().map(|(x, _)| across.place(*x)).collect()),
                course(points.iter().map(|(_, y)| up.place(*y)).collect()),
            ];
            json!({ "x": x, "y": y, "isCourse": true })
        }
        Data::Levels {
            stretches: all,
            windows,
        } => {
            // A value may be missing in all cycles of a window.
            let windows = windows.iter().filter(|window| !window.is_empty());
            json!({
                "stretches": stretches(all),
                "windows": windows.map(|window| cycles(window)).collect::<Vec<_>>(),
            })
        }
    };
    let ends = |end: fn(&(f64, f64)) -> f64| -> Vec<Value> {
        let ends = curve.spread.iter().map(end);
        ends.map(|end| number(up.place(end))).collect()
    };
    json!({
        "name": curve.name,
        "group": curve.group,
        "colour": curve.colour,
        "look": curve.look.name(),
        "isAside": curve.is_aside,
        "labels": curve.labels,
        "spread": [ends(|ends| ends.0), ends(|ends| ends.1)],
        "data": data,
    })
}

/// Encodes a number with seven significant digits; null where there is none.
fn number(value: f64) -> Value {
    if !value.is_finite() {
        return Value::Null;
    }
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    // Larger whole numbers are shorter with an exponent.
    if rounded.fract() == 0.0 && rounded.abs() < 1e9 {
        // Shorter than with the decimal point.
        Value::from(rounded as i64)
    } else {
        Value::from(rounded)
    }
}

/// Encodes the numbers of a course as text; with a gap in it, as a list.
fn course(values: Vec<f64>) -> Value {
    // Differences of whole numbers have no code for a gap.
    if values.iter().any(|value| !value.is_finite()) {
        return values.into_iter().map(number).collect();
    }
    let step = fine_step_of(values.iter().copied());
    json!({ "step": step, "value": text(&values, step) })
}

fn stretches(stretches: &[Stretch]) -> Value {
    let lows: Vec<_> = stretches.iter().map(|stretch| stretch.low).collect();
    let heights = stretches.iter().map(|stretch| stretch.high - stretch.low);
    let heights: Vec<_> = heights.collect();
    // The step is a part of the range of all values, which is that of the ends.
    let ends = stretches.iter().flat_map(|s| [s.low, s.high]);
    // Both in the same steps, so that no height is less than nothing.
    let step = step_of(ends, &[&lows, &heights]);
    json!({
        "t": times(stretches.iter().map(|stretch| stretch.t_s).collect()),
        "step": step,
        "low": text(&lows, step),
        "height": text(&heights, step),
    })
}

fn cycles(cycles: &[(f64, f64)]) -> Value {
    let values: Vec<_> = cycles.iter().map(|(_, value)| *value).collect();
    let step = step_of(values.iter().copied(), &[&values]);
    json!({
        "t": times(cycles.iter().map(|(t, _)| *t).collect()),
        "step": step,
        "value": text(&values, step),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_never_nan() {
        assert_eq!(number(f64::NAN), Value::Null);
        assert_eq!(number(f64::INFINITY), Value::Null);
        assert_eq!(number(1.234_567_891).to_string(), "1.234568");
        assert_eq!(number(499.999_999_99).to_string(), "500");
        assert_eq!(number(-0.000_012_345_678_9), Value::from(-1.234_568e-5));
    }
}
