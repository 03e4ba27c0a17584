//! The report of a run: one HTML page that opens without a network.

mod around_beat;
mod draw;
mod drawing;
mod figures;
mod html;
mod slaves;

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Context;
use plotly::Plot;

pub(crate) use self::draw::{COLOURS, NEUTRAL, layout, vertical};
pub(crate) use self::drawing::{Drawing, axis_name, band};
pub(crate) use self::html::escaped;
use self::html::script_json;
use crate::curves::Curves;
use crate::summary::{Summary, World};
use crate::table;
use crate::verdict::Verdict;

/// What the report shows.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// The run in figures.
    pub summary: &'a Summary,
    /// The scenario as it was run, TOML.
    pub scenario_toml: &'a str,
    /// The curves of every receiver.
    pub curves: &'a [Curves],
    /// The command that repeats the run.
    pub command: &'a str,
}

/// Writes the report. The same run gives the same bytes.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, report: &Report<'_>) -> anyhow::Result<()> {
    let page = document(&report.summary.title, &body(report))?;
    std::fs::write(path, page).with_context(|| format!("cannot write {}", path.display()))
}

/// The plotting library as a script element. The crate hands out a formula renderer behind it,
/// which no figure here needs.
fn plotting_script() -> anyhow::Result<String> {
    let mut scripts = Plot::offline_js_sources();
    let end = scripts
        .find(SCRIPT_END)
        .context("the plotting library is not a script element")?;
    scripts.truncate(end + SCRIPT_END.len());
    Ok(scripts)
}

const SCRIPT_END: &str = "</script>";

/// A page that opens without a network, drawing its figures in the browser's own colours.
///
/// # Errors
/// The plotting library is not what it was.
pub(crate) fn document(title: &str, body: &str) -> anyhow::Result<String> {
    Ok(page(title, body, &plotting_script()?))
}

fn page(title: &str, body: &str, plotting_script: &str) -> String {
    let title = escaped(title);
    let css = include_str!("report.css");
    let js = include_str!("report.js");
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n\
         <style>\n{css}</style>\n{plotting_script}\n</head>\n<body>\n<main>\n{body}</main>\n\
         <script>\n{js}</script>\n</body>\n</html>\n"
    )
}

fn body(report: &Report<'_>) -> String {
    let mut body = introduction(report);
    body += &results(report.summary);
    body += &expectations(report.summary);
    body += "<h2>Plots</h2>\n<p class=\"hint\">Drag to zoom in, double-click to zoom out, click a \
             name to hide its curve. The plots over time zoom together.</p>\n";
    for drawing in &figures::all(report.summary, report.curves) {
        body += &figure_element(drawing);
    }
    body += &repeating(report);
    body
}

fn introduction(report: &Report<'_>) -> String {
    let summary = report.summary;
    let title = escaped(&summary.title);
    let name = escaped(&summary.scenario);
    let world = match summary.world {
        World::Virtual => "virtual time",
        World::Processes => "real processes over Zenoh",
    };
    let mut text = format!("<header>\n<h1>{title}</h1>\n");
    if let Some(description) = description(report.scenario_toml) {
        let _ = writeln!(text, "<p>{}</p>", escaped(description.trim()));
    }
    let _ = writeln!(
        text,
        "<p class=\"facts\">Scenario <b>{name}</b> · {world} · seed {} · {} s</p>\n</header>",
        summary.seed, summary.duration_s,
    );
    if let Some(conclusion) = table::conclusion(summary) {
        let lines: Vec<_> = conclusion.lines().map(escaped).collect();
        let _ = writeln!(text, "<p class=\"conclusion\">{}</p>", lines.join("<br>\n"));
    }
    text
}

fn description(scenario_toml: &str) -> Option<String> {
    let scenario: toml::Table = scenario_toml.parse().ok()?;
    let text = scenario.get("description")?.as_str()?.trim().to_owned();
    (!text.is_empty()).then_some(text)
}

fn results(summary: &Summary) -> String {
    let mut text =
        "<h2>Results</h2>\n<div class=\"wide\"><table>\n<thead><tr><th>receiver</th>".to_owned();
    let receivers = table::in_order(summary);
    let figures = table::rows(&receivers);
    for (label, _) in &figures {
        let _ = write!(text, "<th>{}</th>", escaped(label));
    }
    text += "</tr></thead>\n<tbody>\n";
    for (n, (name, _)) in receivers.iter().enumerate() {
        let _ = write!(text, "<tr><th>{}</th>", escaped(name));
        for (_, values) in &figures {
            let _ = write!(text, "<td>{}</td>", escaped(&values[n]));
        }
        text += "</tr>\n";
    }
    text += "</tbody>\n</table></div>\n<p class=\"hint\">From the first synchronisation on, or from \
             the start where a receiver never synchronises. Settled: in sync for a second or more; \
             before that it locks in. Time errors without their mean, which is the lag.</p>\n";
    text
}

fn expectations(summary: &Summary) -> String {
    if summary.expectations.is_empty() {
        return String::new();
    }
    let mut text =
        "<h2>Expectations</h2>\n<div class=\"wide\"><table class=\"words\">\n<thead><tr>\
                    <th></th><th>receiver</th><th>figure</th><th>is</th><th>expected</th></tr>\
                    </thead>\n<tbody>\n"
            .to_owned();
    for verdict in &summary.expectations {
        text += &expectation(verdict);
    }
    text += "</tbody>\n</table></div>\n";
    text
}

fn expectation(verdict: &Verdict) -> String {
    let (class, outcome) = if verdict.met {
        ("met", "✓ met")
    } else {
        ("failed", "✗ failed")
    };
    format!(
        "<tr class=\"{class}\"><td class=\"outcome\">{outcome}</td><td>{}</td><td>{}</td>\
         <td>{}</td><td>{}</td></tr>\n",
        escaped(&verdict.receiver),
        escaped(&verdict.field),
        escaped(&table::value(&verdict.received)),
        escaped(&verdict.expected),
    )
}

/// The figure with its words.
pub(crate) fn figure_element(drawing: &Drawing<'_>) -> String {
    let Drawing {
        id,
        title,
        caption,
        height,
        figure,
    } = drawing;
    let title = escaped(title);
    let caption = escaped(caption);
    let Some(figure) = figure else {
        return format!(
            "<figure>\n<h3>{title}</h3>\n<p class=\"hint\">No receiver of this run has anything to \
             show here.</p>\n</figure>\n"
        );
    };
    let json = script_json(figure);
    format!(
        "<figure>\n<h3>{title}</h3>\n<figcaption>{caption}</figcaption>\n\
         <div class=\"plot\" id=\"{id}\" style=\"height:{height}px\"></div>\n\
         <script type=\"application/json\" id=\"{id}-figure\">{json}</script>\n</figure>\n"
    )
}

fn repeating(report: &Report<'_>) -> String {
    format!(
        "<h2>Run it again</h2>\n<pre><code>{}</code></pre>\n<details>\n<summary>The scenario\
         </summary>\n<pre><code>{}</code></pre>\n</details>\n",
        escaped(report.command),
        escaped(report.scenario_toml),
    )
}

#[cfg(test)]
mod tests;
