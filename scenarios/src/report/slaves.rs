//! Where the slaves were, and how well they cut.

use serde_json::Value;

use super::draw::{Pen, Shown, layout, numbers, range_of, thinned, vertical};
use super::drawing::{Drawing, TIME, axis_name, band, figure, subtitle};
use super::escaped;
use crate::summary::{Cut, Summary};
use crate::units;

/// The error of every cut, by receiver.
pub(super) fn cuts(summary: &Summary, receivers: &[Shown<'_>]) -> Drawing<'static> {
    let cuts = summary.receivers.values();
    let cuts = cuts.flat_map(|receiver| receiver.slaves.values().map(|slave| &slave.cuts));
    let cutting = cuts.filter(|cuts| cuts.cuts > 0);
    let fine = units::fine(&units::common(cutting.map(|cuts| &cuts.cut_unit)));
    let mut data = Vec::new();
    for receiver in receivers {
        let Some(figures) = summary.receivers.get(&receiver.curves.name) else {
            continue;
        };
        let mut in_legend = true;
        for slave in figures.slaves.values() {
            let list = &slave.cuts.cut_list;
            for (axis, error) in ERRORS {
                data.extend(line_of_cuts(
                    receiver,
                    list,
                    axis,
                    (error, fine.factor),
                    in_legend,
                ));
                in_legend &= list.is_empty();
            }
        }
    }
    let mut layout = layout(TIME);
    for (n, title) in ["piece too long", "off its mark"].iter().enumerate() {
        let title = format!("{title} ({})", fine.unit);
        let axis = axis_name(n).replacen('y', "yaxis", 1);
        layout[axis.as_str()] = vertical(&escaped(&title), None);
        layout[axis.as_str()]["domain"] = band(n, 2);
    }
    layout["xaxis"]["anchor"] = axis_name(1).into();
    Drawing {
        id: "cuts",
        title: "Every cut",
        caption: "Above: by how much each piece is longer than its marks are apart. Below: how far \
                  beyond its mark each cut is, a lag included.",
        height: 560,
        figure: figure(data, layout),
    }
}

type Error = fn(&Cut) -> Option<f64>;

const ERRORS: [(&str, Error); 2] = [
    ("y", |cut| cut.length_error),
    ("y2", |cut| cut.position_error),
];

fn line_of_cuts(
    receiver: &Shown<'_>,
    list: &[Cut],
    axis: &str,
    (error, factor): (Error, f64),
    in_legend: bool,
) -> Option<Value> {
    let known: Vec<_> = list
        .iter()
        .filter_map(|cut| Some((cut.t_s, factor * error(cut)?)))
        .collect();
    let pen = Pen {
        name: &receiver.name,
        group: &receiver.name,
        colour: receiver.colour,
        in_legend,
        axis,
    };
    let (x, y) = known.iter().copied().unzip::<_, _, Vec<_>, Vec<_>>();
    let mut line = pen.line(numbers(x), numbers(y));
    line["mode"] = "lines+markers".into();
    line["marker"] = serde_json::json!({ "size": 5 });
    (!known.is_empty()).then_some(line)
}

/// The set positions of all slaves, a panel per receiver, each curve of at most so many stretches.
pub(super) fn positions(receivers: &[Shown<'_>], most: usize) -> Drawing<'static> {
    let count = receivers.len();
    let mut data = Vec::new();
    let mut layout = layout(TIME);
    let mut titles = Vec::new();
    for (n, receiver) in receivers.iter().enumerate() {
        let axis = axis_name(n);
        let mut drawn = Vec::new();
        for (slave, curve) in receiver.curves.slaves.iter().enumerate() {
            let stretches = thinned(&curve.position, most, 0.0);
            let name = escaped(&curve.name);
            let pen = Pen {
                name: &name,
                group: &name,
                colour: COLOURS[slave % COLOURS.len()],
                in_legend: n == 0,
                axis: &axis,
            };
            data.extend(pen.curve(&stretches));
            drawn.extend(stretches);
        }
        let unit = units::common(receiver.curves.slaves.iter().map(|slave| &slave.unit));
        let mut vertical = vertical(&escaped(unit.as_str()), range_of(drawn.iter()));
        vertical["domain"] = band(n, count);
        layout[axis.replacen('y', "yaxis", 1)] = vertical;
        titles.push(subtitle(receiver, n, count));
    }
    layout["annotations"] = titles.into();
    layout["xaxis"]["anchor"] = axis_name(count.saturating_sub(1)).into();
    Drawing {
        id: "positions",
        title: "Where the slaves are",
        caption: "Set positions of all slaves of each receiver.",
        height: 90 + 190 * count,
        figure: figure(data, layout),
    }
}

/// Of the slaves, in the order of the config.
const COLOURS: [&str; 4] = ["#2f86d6", "#d99a00", "#0b9c78", "#b06fa8"];
