//! `report.html`: the sweep for a browser.

use std::fmt::Write as _;

use anyhow::Context;
use coaxle_lab::number::significant;
use coaxle_lab::sweep::plot::{Panel, Plot, is_logarithmic};
use coaxle_lab::sweep::shown::ShownRows;
use coaxle_lab::sweep::statistics::Statistics;
use coaxle_lab::sweep::{PointOutcome, Prepared};
use serde_json::{Value, json};

use super::outcome::Outcome;
use crate::page::{Drawing, document, escaped, figure_element, layout, vertical};
use crate::plotting::colour;

/// Writes the report. The same results give the same bytes.
///
/// # Errors
/// Names the file that cannot be written.
pub(super) fn write(
    sweep: &Prepared,
    shown: &ShownRows,
    plots: &[Plot],
    outcome: &Outcome,
    command: &str,
) -> anyhow::Result<()> {
    let mut body = introduction(sweep, outcome);
    body += &not_met(outcome);
    body += "<h2>Plots</h2>\n<p class=\"hint\">Drag to zoom in, double-click to zoom out.</p>\n";
    for (n, plot) in plots.iter().enumerate() {
        body += &drawing(n, plot);
    }
    if plots.is_empty() {
        body +=
            "<p class=\"hint\">Nothing to plot: no axis has two values, or no run is over.</p>\n";
    }
    body += &table(sweep, shown);
    let _ = writeln!(
        body,
        "<h2>Run it again</h2>\n<pre><code>{}</code></pre>",
        escaped(command)
    );
    let page = document(sweep.title(), &body)?;
    let path = &outcome.report;
    std::fs::write(path, page).with_context(|| format!("cannot write {}", path.display()))
}

fn introduction(sweep: &Prepared, outcome: &Outcome) -> String {
    let (over, all) = outcome.runs;
    let (points, seeds) = (sweep.points(), sweep.seeds());
    let axes: Vec<_> = (sweep.axes().iter())
        .map(|axis| format!("{}: {}", axis.field, axis.values.join(", ")))
        .collect();
    let ended = match outcome.is_whole() {
        true => String::new(),
        false => format!(" · <b>ended after {over} of {all} runs</b>"),
    };
    format!(
        "<header>\n<h1>{}</h1>\n<p class=\"facts\">Sweep of <b>{}</b> · virtual time · points: {points} · seeds: \
         {seeds}{ended}</p>\n<p class=\"facts\">{}</p>\n</header>\n",
        escaped(sweep.title()),
        escaped(sweep.scenario()),
        escaped(&axes.join(" · ")),
    )
}

/// Most lines of what was not as expected, and most rows of the table.
const MOST_LINES: usize = 500;

fn not_met(outcome: &Outcome) -> String {
    let judged: usize = outcome.points.iter().map(|point| point.judged).sum();
    let lines = || outcome.failed().flat_map(failures);
    let failed = lines().count();
    let mut text = format!(
        "<h2>Expectations</h2>\n<p>{} of {judged} met.</p>\n",
        judged.saturating_sub(failed)
    );
    if failed == 0 {
        return text;
    }
    text += "<div class=\"wide\"><table class=\"words\">\n<thead><tr><th>point</th><th>seed</th><th>not met</th></tr></thead>\n\
             <tbody>\n";
    text.extend(lines().take(MOST_LINES));
    text += "</tbody>\n</table></div>\n";
    text + &left_out(failed)
}

fn failures(point: &PointOutcome) -> impl Iterator<Item = String> {
    point.failures.iter().map(|(seed, line)| {
        let (name, line) = (escaped(&point.name), escaped(line));
        format!("<tr class=\"failed\"><td>{name}</td><td>{seed}</td><td>{line}</td></tr>\n")
    })
}

fn left_out(all: usize) -> String {
    match all.checked_sub(MOST_LINES) {
        None | Some(0) => String::new(),
        Some(more) => format!("<p class=\"hint\">{more} more are in the tables.</p>\n"),
    }
}

fn table(sweep: &Prepared, shown: &ShownRows) -> String {
    let cells = |tag: &str, cells: &[String]| {
        let cells = cells.iter();
        let cells: String = cells
            .map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell)))
            .collect();
        format!("<tr>{cells}</tr>\n")
    };
    let rows = shown.rows.iter().take(MOST_LINES);
    let rows: String = rows.map(|row| cells("td", row)).collect();
    let medians = match sweep.seeds().get() {
        1 => String::new(),
        seeds => format!("<p class=\"hint\">Medians of {seeds} seeds.</p>\n"),
    };
    format!(
        "<h2>Results</h2>\n{medians}<div class=\"wide\"><table>\n<thead>{}</thead>\n<tbody>\n{rows}</tbody>\n\
         </table></div>\n{}<p class=\"hint\">In full, with every other figure: points.csv, points.parquet; over the seeds: \
         summary.csv.</p>\n",
        cells("th", &shown.header),
        left_out(shown.rows.len()),
    )
}

fn drawing(n: usize, plot: &Plot) -> String {
    let (figure, height) = match plot.up {
        None => (curves(plot), 480),
        Some(_) => (maps(plot), 60 + 400 * plot.panels.len().div_ceil(COLUMNS)),
    };
    let caption = match (&plot.up, plot.more) {
        (None, _) => {
            "The median of the seeds; the whiskers are its 5 % and 95 % quantiles.".to_owned()
        }
        (Some(_), 0) => "The median of the seeds.".to_owned(),
        (Some(_), more) => format!("The median of the seeds. {more} more maps are left out."),
    };
    figure_element(&Drawing {
        id: &format!("figure-{n}"),
        title: &plot.heading,
        caption: &caption,
        height,
        figure,
    })
}

fn curves(plot: &Plot) -> Value {
    let along = &plot.across;
    let x: Vec<Value> = match &along.numbers {
        Some(numbers) => numbers.iter().map(|number| json!(number)).collect(),
        None => along.values.iter().map(|value| json!(value)).collect(),
    };
    let curve = |(n, panel): (usize, &Panel)| {
        let of = |value: fn(&Statistics) -> f64| -> Vec<Option<f64>> {
            let cells = panel.cells.iter();
            cells.map(|cell| cell.as_ref().map(value)).collect()
        };
        json!({
            "type": "scatter",
            "mode": "lines+markers",
            "name": escaped(&panel.title),
            "x": x,
            "y": of(|cell| cell.median),
            "line": { "color": colour(n) },
            "error_y": {
                "type": "data",
                "symmetric": false,
                "array": of(|cell| cell.high - cell.median),
                "arrayminus": of(|cell| cell.median - cell.low),
            },
        })
    };
    let data: Vec<_> = plot.panels.iter().enumerate().map(curve).collect();
    let mut layout = layout(&escaped(&along.field));
    layout["yaxis"] = vertical(&escaped(&plot.heading), None);
    let lows = plot
        .panels
        .iter()
        .flat_map(|panel| panel.cells.iter().flatten());
    if is_logarithmic(lows.map(|cell| cell.low)) {
        layout["yaxis"]["type"] = "log".into();
    }
    layout["xaxis"]["type"] = match &along.numbers {
        Some(numbers) if is_logarithmic(numbers.iter().copied()) => "log",
        Some(_) => "linear",
        None => "category",
    }
    .into();
    json!({ "data": data, "layout": layout })
}

/// Maps beside each other.
const COLUMNS: usize = 3;

fn maps(plot: &Plot) -> Value {
    let (along, Some(up)) = (&plot.across, &plot.up) else {
        return Value::Null;
    };
    let cells = plot
        .panels
        .iter()
        .flat_map(|panel| panel.cells.iter().flatten());
    let is_logarithmic = is_logarithmic(cells.map(|cell| cell.median));
    let columns = plot.panels.len().min(COLUMNS);
    let rows = plot.panels.len().div_ceil(columns);
    let mut page = layout("");
    let (mut data, mut titles) = (Vec::new(), Vec::new());
    for (n, panel) in plot.panels.iter().enumerate() {
        let number = if n == 0 {
            String::new()
        } else {
            (n + 1).to_string()
        };
        let (x, y) = (format!("x{number}"), format!("y{number}"));
        let row_of = |row: &[Option<Statistics>], is_colour: bool| -> Vec<Option<f64>> {
            let place = |value: f64| {
                if is_colour && is_logarithmic {
                    value.log10()
                } else {
                    value
                }
            };
            row.iter()
                .map(|cell| cell.as_ref().map(|cell| place(cell.median)))
                .collect()
        };
        let rows_of = |is_colour: bool| -> Vec<_> {
            let rows = panel.cells.chunks(along.values.len());
            rows.map(|row| row_of(row, is_colour)).collect()
        };
        // In its cells Plotly writes no other data than this.
        let word = |value: Option<f64>| value.map(|value| significant(value, 3));
        let words = rows_of(false).into_iter();
        let words = words.map(|row| row.into_iter().map(word).collect());
        let words: Vec<Vec<_>> = words.collect();
        data.push(json!({
            "type": "heatmap",
            "xaxis": x,
            "yaxis": y,
            "x": along.values,
            "y": up.values,
            "z": rows_of(true),
            "customdata": rows_of(false),
            "coloraxis": "coloraxis",
            "text": words,
            "texttemplate": "%{text}",
            "hovertemplate": "%{x}, %{y}: %{customdata:.6~g}<extra></extra>",
        }));
        let (column, row) = (n % columns, n / columns);
        let width = band(column, columns, 0.22);
        let height = band(rows - 1 - row, rows, 0.25);
        let axis = |title: &str, domain: [f64; 2], anchor: &str| json!({ "type": "category", "domain": domain, "anchor": anchor, "title": { "text": escaped(title) } });
        page[format!("xaxis{number}")] = axis(&along.field, width, &y);
        page[format!("yaxis{number}")] = axis(&up.field, height, &x);
        titles.push(json!({
            "text": escaped(&panel.title), "showarrow": false, "xref": "paper", "yref": "paper",
            "x": width[0], "xanchor": "left", "y": height[1], "yanchor": "bottom",
        }));
    }
    let unit = if is_logarithmic { "log10 of it" } else { "" };
    page["annotations"] = titles.into();
    page["coloraxis"] =
        json!({ "colorscale": "Viridis", "colorbar": { "title": { "text": unit } } });
    json!({ "data": data, "layout": page })
}

/// The n-th of so many parts of a length of 1, with such a share of each left for words.
fn band(n: usize, count: usize, gap: f64) -> [f64; 2] {
    let each = 1.0 / count as f64;
    let start = each * n as f64;
    [start, start + (1.0 - gap) * each]
}
