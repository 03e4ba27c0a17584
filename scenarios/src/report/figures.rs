//! The plots of a run, in the order of the page.

use coaxle_receiver::StateName;
use serde_json::{Value, json};

use super::draw::{
    NEUTRAL, Pen, Shown, coloured, layout, number, numbers, range_of, thinned, vertical,
};
use super::drawing::{Drawing, TIME, axis_name, band, figure, subtitle};
use super::html::escaped;
use super::{around_beat, slaves};
use crate::curves::{Curves, Series, Stretch};
use crate::summary::Summary;
use crate::table;

/// All plots of a run.
pub(super) fn all(summary: &Summary, curves: &[Curves]) -> Vec<Drawing<'static>> {
    let mut curves: Vec<_> = curves.iter().collect();
    curves.sort_by(|a, b| {
        let key = |c: &Curves| (table::rank(c.mode), c.name.clone());
        key(a).cmp(&key(b))
    });
    let shown = coloured(&curves);
    let run = Run {
        summary,
        receivers: &shown,
        most: (MOST_POINTS / (5 * shown.len().max(1))).clamp(300, 4_000),
    };
    let cuts = slaves::cuts(summary, &shown);
    let several = curves.iter().any(|curves| curves.slaves.len() > 1);
    // Nobody misses these where there is nothing in them.
    let of_cuts = cuts.figure.is_some().then_some(cuts);
    let of_slaves = several.then(|| slaves::positions(&shown, run.most));
    let of_the_far_axis = [
        run.velocity(),
        around_beat::drawing(&shown),
        run.correction(),
        run.time_error(),
        run.drift(),
        run.state(),
    ];
    of_cuts
        .into_iter()
        .chain(of_slaves)
        .chain(of_the_far_axis)
        .collect()
}

/// Stretches in all curves together; keeps the page below some megabytes.
const MOST_POINTS: usize = 80_000;

struct Run<'a> {
    summary: &'a Summary,
    receivers: &'a [Shown<'a>],
    /// Stretches per curve.
    most: usize,
}

impl Run<'_> {
    fn velocity(&self) -> Drawing<'static> {
        let set: Vec<_> = self.thin(|curves| &curves.set_velocity);
        let drive: Vec<_> = self.thin(|curves| &curves.drive_velocity);
        let range = range_of(set.iter().chain(&drive).flatten());
        let count = self.receivers.len();
        let mut data = Vec::new();
        let mut layout = layout(TIME);
        let mut titles = Vec::new();
        let mut marks = Vec::new();
        for (n, receiver) in self.receivers.iter().enumerate() {
            let axis = axis_name(n);
            let pen = Pen {
                name: "set velocity",
                group: "set",
                colour: receiver.colour,
                in_legend: n == 0,
                axis: &axis,
            };
            data.extend(pen.curve(&set[n]));
            let pen = Pen {
                name: "actual velocity of the drive",
                group: "drive",
                colour: NEUTRAL,
                ..pen
            };
            data.extend(pen.curve(&drive[n]));
            let unit = receiver.curves.drive_unit().in_place_of_u("u/s");
            let mut vertical = vertical(&escaped(&unit), range);
            vertical["domain"] = band(n, count);
            if n > 0 {
                vertical["matches"] = "y".into();
            }
            layout[axis.replacen('y', "yaxis", 1)] = vertical;
            titles.push(subtitle(receiver, n, count));
            marks.extend(self.mark_of_sync(receiver, &axis));
        }
        layout["annotations"] = titles.into();
        layout["shapes"] = marks.into();
        layout["xaxis"]["anchor"] = axis_name(count.saturating_sub(1)).into();
        let height = 90 + 190 * count;
        layout["legend"]["y"] = number(1.0 + 26.0 / (height - 90).max(1) as f64);
        Drawing {
            id: "velocity",
            title: "Velocity, without correction and with it",
            caption: "Set velocity (coloured) and actual velocity of the drive (grey), every \
                      receiver on the same scale, those without correction first. Spikes are \
                      beats: messages missed or received twice because two clocks drift. A \
                      dotted line marks the first synchronisation.",
            height,
            figure: figure(data, layout),
        }
    }

    /// When the receiver first synchronised.
    fn mark_of_sync(&self, receiver: &Shown<'_>, axis: &str) -> Option<Value> {
        let figures = self.summary.receivers.get(&receiver.curves.name)?;
        figures.time_to_sync_s?;
        let at = number(figures.evaluated_from_s?);
        Some(json!({
            "type": "line",
            "xref": "x",
            "yref": format!("{axis} domain"),
            "x0": at,
            "x1": at,
            "y0": 0,
            "y1": 1,
            "line": { "color": NEUTRAL, "width": 1, "dash": "dot" },
        }))
    }

    fn correction(&self) -> Drawing<'static> {
        Drawing {
            id: "correction",
            title: "Correction time",
            caption: "By how much the received axis is extrapolated. A steady ramp, set back by \
                      one cycle at every beat, is the drift being compensated.",
            height: 380,
            figure: self.over_time("µs", |curves| &curves.correction_us, |_| 0.0),
        }
    }

    fn time_error(&self) -> Drawing<'static> {
        Drawing {
            id: "time-error",
            title: "Error of the corrected time",
            caption: "The far time each set value stands for, minus the true one, without the \
                      mean (the lag). Times the velocity it is the position error.",
            height: 380,
            figure: self.over_time(
                "µs",
                |curves| &curves.time_error_us,
                // The mean error is minus the lag.
                |receiver| {
                    let figures = self.summary.receivers.get(&receiver.curves.name);
                    figures
                        .and_then(|figures| figures.lag_us)
                        .unwrap_or_else(|| -middle(&receiver.curves.time_error_us))
                },
            ),
        }
    }

    fn drift(&self) -> Drawing<'static> {
        let mut figure = self.over_time("ppm", |curves| &curves.drift_ppm, |_| 0.0);
        if let Some(Value::Array(data)) = figure.as_mut().map(|figure| figure["data"].take()) {
            let truth = self.receivers.iter().filter_map(|receiver| {
                let figures = self.summary.receivers.get(&receiver.curves.name)?;
                let ppm = number(figures.drift_ppm_true?);
                let pen = Pen {
                    name: "true",
                    group: &receiver.name,
                    colour: receiver.colour,
                    in_legend: false,
                    axis: "y",
                };
                let ends = numbers([0.0, self.summary.duration_s]);
                let mut line = pen.line(ends, json!([ppm, ppm]));
                line["line"]["dash"] = "dash".into();
                Some(line)
            });
            let data: Vec<_> = data.into_iter().chain(truth).collect();
            if let Some(figure) = &mut figure {
                figure["data"] = data.into();
            }
        }
        Drawing {
            id: "drift",
            title: "Estimated drift",
            caption: "The sender's clock against the receiver's own, positive when the sender's \
                      is the faster one. Dashed: the true value at the end of the run.",
            height: 380,
            figure,
        }
    }

    fn state(&self) -> Drawing<'static> {
        let mut data = Vec::new();
        let count = self.receivers.len() as f64;
        for (n, receiver) in self.receivers.iter().enumerate() {
            let states = &receiver.curves.states;
            let Some(last) = states.last() else {
                continue;
            };
            // Side by side, so that none hides another.
            let shift = 0.5 * ((n as f64 + 0.5) / count - 0.5);
            let height = |state: Option<StateName>| level(state) - shift;
            let end = self.summary.duration_s.max(last.0);
            let x = states.iter().map(|(t, _)| *t).chain([end]);
            let y = states.iter().map(|(_, state)| height(*state));
            let pen = Pen {
                name: &receiver.name,
                group: &receiver.name,
                colour: receiver.colour,
                in_legend: true,
                axis: "y",
            };
            let mut line = pen.line(numbers(x), numbers(y.chain([height(last.1)])));
            line["line"]["shape"] = "hv".into();
            line["line"]["width"] = 2.into();
            line["hovertemplate"] = "%{x} s".into();
            data.push(line);
        }
        let mut layout = layout(TIME);
        layout["yaxis"] = json!({
            "tickvals": [0, 1, 2, 3, 4, 5],
            "ticktext": ["no data", "bypass", "pt1", "time", "sync", "observer"],
            "range": [-0.5, 5.5],
            "zeroline": false,
        });
        Drawing {
            id: "state",
            title: "State",
            caption: "The mode that makes the set values.",
            height: 320,
            figure: figure(data, layout),
        }
    }

    /// One curve per receiver over the whole run.
    fn over_time(
        &self,
        unit: &str,
        series: impl Fn(&Curves) -> &Series,
        offset: impl Fn(&Shown<'_>) -> f64,
    ) -> Option<Value> {
        let mut data = Vec::new();
        let mut drawn = Vec::new();
        for receiver in self.receivers {
            let stretches = thinned(series(receiver.curves), self.most, offset(receiver));
            if stretches.is_empty() {
                continue;
            }
            let pen = Pen {
                name: &receiver.name,
                group: &receiver.name,
                colour: receiver.colour,
                in_legend: true,
                axis: "y",
            };
            data.extend(pen.curve(&stretches));
            drawn.extend(stretches);
        }
        let mut layout = layout(TIME);
        layout["yaxis"] = vertical(unit, range_of(drawn.iter()));
        figure(data, layout)
    }

    fn thin(&self, series: impl Fn(&Curves) -> &Series) -> Vec<Vec<Stretch>> {
        self.receivers
            .iter()
            .map(|receiver| thinned(series(receiver.curves), self.most, 0.0))
            .collect()
    }
}

fn level(state: Option<StateName>) -> f64 {
    match state {
        None => 0.0,
        Some(StateName::Bypass) => 1.0,
        Some(StateName::Pt1) => 2.0,
        Some(StateName::Time) => 3.0,
        Some(StateName::Sync) => 4.0,
        Some(StateName::Observer) => 5.0,
    }
}

fn middle(series: &Series) -> f64 {
    let count = series.stretches.len().max(1) as f64;
    let sum: f64 = series.stretches.iter().map(|s| s.low + s.high).sum();
    sum / (2.0 * count)
}
