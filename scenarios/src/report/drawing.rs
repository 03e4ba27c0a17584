//! A plot with its words, and what plots of several panels share.

use serde_json::{Value, json};

use super::draw::{Shown, number, numbers};
use crate::table;

/// A plot with its words.
#[derive(Clone, Debug)]
pub(crate) struct Drawing<'a> {
    /// Name within the page.
    pub(crate) id: &'a str,
    pub(crate) title: &'a str,
    /// What to look at.
    pub(crate) caption: &'a str,
    /// Pixels.
    pub(crate) height: usize,
    /// `data` and `layout`; none if there is nothing to draw.
    pub(crate) figure: Option<Value>,
}

/// What the time axis is called.
pub(super) const TIME: &str = "time (s)";

/// Data and layout, if there is any curve.
pub(super) fn figure(data: Vec<Value>, layout: Value) -> Option<Value> {
    let drawn = data
        .iter()
        .any(|curve| curve["x"].as_array().is_some_and(|x| !x.is_empty()));
    drawn.then(|| json!({ "data": data, "layout": layout }))
}

/// `y`, `y2`, `y3` …
pub(crate) fn axis_name(n: usize) -> String {
    match n {
        0 => "y".to_owned(),
        n => format!("y{}", n + 1),
    }
}

/// The share of the plot's height that belongs to the n-th of so many, from the top.
pub(crate) fn band(n: usize, count: usize) -> Value {
    let each = 1.0 / count.max(1) as f64;
    let top = 1.0 - each * n as f64;
    // The gap holds the title.
    numbers([top - each, top - 0.16 * each])
}

/// What stands above the n-th of so many panels.
pub(super) fn subtitle(receiver: &Shown<'_>, n: usize, count: usize) -> Value {
    let each = 1.0 / count as f64;
    let correction = match receiver.curves.mode {
        "bypass" => "without correction",
        mode => table::correction(mode),
    };
    json!({
        "text": format!("<b>{}</b> – {correction}", receiver.name),
        "xref": "paper",
        "yref": "paper",
        "x": 0,
        "xanchor": "left",
        "y": number(1.0 - each * (n as f64 + 0.15)),
        "yanchor": "bottom",
        "showarrow": false,
    })
}
