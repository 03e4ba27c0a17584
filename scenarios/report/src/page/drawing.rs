//! Figures of the plotting library: with their words, and what several of them share.

use serde_json::{Value, json};

use super::html::{escaped, script_json};

/// A plot with its words.
#[derive(Clone, Debug)]
pub struct Drawing<'a> {
    /// Name within the page.
    pub id: &'a str,
    /// What it shows, in a line.
    pub title: &'a str,
    /// What to look at.
    pub caption: &'a str,
    /// Pixels.
    pub height: usize,
    /// `data` and `layout`.
    pub figure: Value,
}

/// The figure with its words.
pub fn figure_element(drawing: &Drawing<'_>) -> String {
    let Drawing { id, height, .. } = drawing;
    let title = escaped(drawing.title);
    let caption = escaped(drawing.caption);
    let json = script_json(&drawing.figure);
    format!(
        "<figure>\n<h3>{title}</h3>\n<figcaption>{caption}</figcaption>\n\
         <div class=\"plot\" id=\"{id}\" style=\"height:{height}px\"></div>\n\
         <script type=\"application/json\" id=\"{id}-figure\">{json}</script>\n</figure>\n"
    )
}

/// The layout all plots share.
pub fn layout(x_title: &str) -> Value {
    json!({
        "margin": { "l": 70, "r": 20, "t": 40, "b": 50 },
        "hovermode": "closest",
        "legend": { "orientation": "h", "x": 0, "y": 1, "yanchor": "bottom" },
        "xaxis": { "title": { "text": x_title }, "zeroline": false },
    })
}

/// A vertical axis.
pub fn vertical(title: &str, range: Option<(f64, f64)>) -> Value {
    let mut axis = json!({ "title": { "text": title }, "zeroline": false });
    if let Some((low, high)) = range {
        axis["range"] = json!([low, high]);
    }
    axis
}

/// `y`, `y2`, `y3` …
pub fn axis_name(n: usize) -> String {
    match n {
        0 => "y".to_owned(),
        n => format!("y{}", n + 1),
    }
}

/// The share of the plot's height that belongs to the n-th of so many, from the top.
pub fn band(n: usize, count: usize) -> Value {
    let each = 1.0 / count.max(1) as f64;
    let top = 1.0 - each * n as f64;
    // The gap holds the title.
    json!([top - each, top - 0.16 * each])
}
