//! `report.html`: the sweep for a browser.

use std::fmt::Write as _;

use anyhow::Context;
use coaxle_lab::sweep::shown::ShownRows;
use coaxle_lab::sweep::{PointOutcome, Prepared};

use super::drawn::SweepDrawing;
use super::outcome::SweepOutcome;
use crate::page::{HINT, document, escaped, figure_element, maps_element};

/// Writes the report. Equal results give equal bytes.
///
/// # Errors
/// Names the file that cannot be written.
pub(super) fn write(
    sweep: &Prepared,
    shown: &ShownRows,
    plots: &[SweepDrawing],
    outcome: &SweepOutcome,
    command: &str,
) -> anyhow::Result<()> {
    let mut body = introduction(sweep, outcome);
    body += &not_met(outcome);
    body += "<h2>Plots</h2>\n";
    body += HINT;
    for plot in plots {
        body += &match plot {
            SweepDrawing::Curves(figure) => figure_element(figure),
            SweepDrawing::Maps(maps) => maps_element(maps),
        };
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
    let page = document(sweep.title(), &body);
    let path = &outcome.report;
    std::fs::write(path, page).with_context(|| format!("cannot write {}", path.display()))
}

fn introduction(sweep: &Prepared, outcome: &SweepOutcome) -> String {
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

/// Greatest number of lines of unmet expectations, and of rows of the table.
// A sweep has up to 10 000 points, with a row for each receiver: a browser takes long for such a table.
const MOST_LINES: usize = 500;

fn not_met(outcome: &SweepOutcome) -> String {
    let judged: usize = outcome.points.iter().map(|point| point.judged).sum();
    let lines = || outcome.failed().flat_map(failures);
    let failed = lines().count();
    let mut text = format!(
        "<h2>Expectations</h2>\n<p>{} of {judged} met.</p>\n",
        // Lines of failures are no more than what was judged, unless a record was edited.
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
