//! One beat, every cycle of it.

use serde_json::{Value, json};

use super::draw::{NEUTRAL, Pen, Shown, layout, numbers, vertical};
use super::drawing::{Drawing, axis_name, band, figure};
use super::html::escaped;
use crate::row::Row;
use crate::units;

/// Positions and velocity around the beat that each receiver kept.
pub(super) fn drawing(receivers: &[Shown<'_>]) -> Drawing<'static> {
    let mut data = Vec::new();
    for receiver in receivers {
        let rows = &receiver.curves.around_beat;
        let Some(zero) = time_of_beat(rows) else {
            continue;
        };
        data.extend(curves(receiver, rows, zero));
    }
    let mut layout = layout("time from the beat (ms)");
    let unit = units::common(receivers.iter().map(|receiver| &receiver.curves.unit));
    let off = format!("position – truth ({unit})");
    layout["yaxis"] = vertical(&escaped(&off), None);
    layout["yaxis"]["domain"] = band(0, 2);
    let velocity = format!("velocity ({unit}/s)");
    layout["yaxis2"] = vertical(&escaped(&velocity), None);
    layout["yaxis2"]["domain"] = band(1, 2);
    layout["xaxis"]["anchor"] = axis_name(1).into();
    layout["shapes"] = json!([{
        "type": "line",
        "xref": "x",
        "yref": "paper",
        "x0": 0,
        "x1": 0,
        "y0": 0,
        "y1": 1,
        "line": { "color": NEUTRAL, "width": 1, "dash": "dot" },
    }]);
    Drawing {
        id: "beat",
        title: "Around one beat",
        caption: "Above: received (dotted) and corrected position (solid) of the far axis, minus \
                  its true position at that instant; the beat moves the received position by the \
                  way of one cycle. Below: how the corrected position moves from cycle to cycle, \
                  as the slaves are given it. Time counts from the beat as each receiver sees \
                  it; one cycle per point.",
        height: 560,
        figure: figure(data, layout),
    }
}

fn curves(receiver: &Shown<'_>, rows: &[Row], zero: f64) -> Vec<Value> {
    let x = numbers(rows.iter().map(|row| 1e3 * (row.t_s - zero)));
    let off = |position: fn(&Row) -> Option<f64>| {
        numbers(rows.iter().map(|row| {
            let off = position(row)
                .zip(row.truth)
                .map(|(p, (truth, _))| p - truth);
            off.unwrap_or(f64::NAN)
        }))
    };
    let pen = Pen {
        name: &receiver.name,
        group: &receiver.name,
        colour: receiver.colour,
        in_legend: true,
        axis: "y",
    };
    let corrected = pen.line(x.clone(), off(|row| row.record.axis.corrected_position));
    let pen = Pen {
        in_legend: false,
        ..pen
    };
    let mut received = pen.line(x.clone(), off(|row| row.record.axis.received_position));
    received["line"]["dash"] = "dot".into();
    let pen = Pen { axis: "y2", ..pen };
    let mut velocity = pen.line(x, numbers(velocities(rows)));
    // The difference quotient holds for the cycle that led here.
    velocity["line"]["shape"] = "vh".into();
    vec![corrected, received, velocity]
}

/// Difference quotients of the corrected position; the first row has none.
fn velocities(rows: &[Row]) -> impl Iterator<Item = f64> {
    let quotient = |pair: &[Row]| {
        let [before, after] = pair else {
            return None;
        };
        let way = after.record.axis.corrected_position? - before.record.axis.corrected_position?;
        Some(way / (after.t_s - before.t_s))
    };
    let first = rows.first().map(|_| f64::NAN);
    let others = rows
        .windows(2)
        .map(move |pair| quotient(pair).unwrap_or(f64::NAN));
    first.into_iter().chain(others)
}

/// When the beat was, s. The receivers' own detection comes a plateau later, so the step is looked
/// for in the sender's count before it: the split that leaves the least spread on either side.
fn time_of_beat(rows: &[Row]) -> Option<f64> {
    let detected = rows
        .windows(2)
        .position(|pair| pair[1].record.far.beats > pair[0].record.far.beats)
        .map_or(rows.len(), |n| n + 2);
    let counts: Vec<_> = rows[..detected]
        .iter()
        .filter_map(|row| Some((row.t_s, row.record.node.cycle, row.record.far.count?)))
        .collect();
    beat_in(&counts)
}

/// The same from the times, own cycles and sender's counts up to the detection.
fn beat_in(counts: &[(f64, u64, u64)]) -> Option<f64> {
    let (_, first_cycle, first) = *counts.first()?;
    let (_, last_cycle, last) = *counts.last()?;
    let cycles = last_cycle.saturating_sub(first_cycle).max(1) as f64;
    let per_cycle = last.saturating_sub(first) as f64 / cycles;
    // The cycle times are whole multiples of each other.
    let per_cycle = if per_cycle >= 1.0 {
        per_cycle.round()
    } else {
        1.0 / (1.0 / per_cycle.max(1e-3)).round()
    };
    let lead: Vec<f64> = counts
        .iter()
        .map(|(_, cycle, count)| {
            let cycles = cycle.saturating_sub(first_cycle) as f64;
            count.saturating_sub(first) as f64 - per_cycle * cycles
        })
        .collect();
    let (t, _, _) = counts.get(step_in(&lead)?)?;
    Some(*t)
}

/// Where two levels fit best: the first value of the second one.
fn step_in(values: &[f64]) -> Option<usize> {
    let total: f64 = values.iter().sum();
    let count = values.len() as f64;
    let mut before = 0.0;
    let mut best: Option<(f64, usize)> = None;
    for (n, value) in values
        .iter()
        .enumerate()
        .take(values.len().saturating_sub(1))
    {
        before += value;
        let left = (n + 1) as f64;
        let right = count - left;
        // The spread within both parts is least where the part between them is largest.
        let between = before * before / left + (total - before) * (total - before) / right;
        if best.is_none_or(|(most, _)| between > most) {
            best = Some((between, n + 1));
        }
    }
    best.map(|(_, n)| n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_found_among_stragglers() {
        let mut values = vec![0.0; 100];
        values.extend(vec![-1.0; 90]);
        // A late message, and the flutter of jitter right at the beat.
        values[150] = -2.0;
        values[97] = -1.0;
        assert_eq!(step_in(&values), Some(100));
    }

    #[test]
    fn the_beat_is_dated_where_the_count_steps() {
        // Own cycles, in which the sender's count gains one at the hundredth, or loses one.
        let counts = |per_cycle: f64, step: f64| -> Vec<(f64, u64, u64)> {
            (0..200_u64)
                .map(|cycle| {
                    let step = if cycle < 100 { 0.0 } else { step };
                    let count = (per_cycle * cycle as f64).floor() + 10.0 + step;
                    (cycle as f64 * 0.5, cycle, count as u64)
                })
                .collect()
        };
        for (per_cycle, step) in [
            (1.0, 1.0),
            (1.0, -1.0),
            (2.0, 1.0),
            (0.5, 1.0),
            (0.25, -1.0),
        ] {
            let found = beat_in(&counts(per_cycle, step));
            assert_eq!(found, Some(50.0), "{per_cycle} per cycle, {step}");
        }
    }

    #[test]
    fn no_values_no_step() {
        assert_eq!(step_in(&[]), None);
        assert_eq!(step_in(&[1.0]), None);
        assert_eq!(time_of_beat(&[]), None);
    }
}
