//! The report of a run: one HTML page that opens without a network, its figures drawn by a script of its own.

mod around_beat;
mod figures;
mod places;
mod plant;
mod results;
mod shown;
mod slaves;

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Context;
use coaxle_lab::curves::Curves;
use coaxle_lab::summary::{Summary, World};

use self::results::{expectations, results};
use crate::figure::Figure;
use crate::page::{HINT, document, escaped};
use crate::{page, print, table};

/// Content of the report.
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

/// Writes the report. Equal runs give equal bytes.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, report: &Report<'_>) -> anyhow::Result<()> {
    std::fs::write(path, page_of(report))
        .with_context(|| format!("cannot write {}", path.display()))
}

/// Writes each figure of a run as SVG and PDF, `width_mm` wide.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn write_figures(
    folder: &Path,
    summary: &Summary,
    curves: &[Curves],
    width_mm: f64,
) -> anyhow::Result<()> {
    print::write(folder, &figures::all(summary, curves), width_mm)
}

fn page_of(report: &Report<'_>) -> String {
    document(&report.summary.title, &body(report))
}

fn body(report: &Report<'_>) -> String {
    let mut body = introduction(report);
    body += &results(report.summary);
    body += &expectations(report.summary);
    body += &plant::element(report);
    body += "<h2>Plots</h2>\n";
    body += HINT;
    body += ABOUT_BANDS;
    body += &places(report.curves);
    for figure in &figures::all(report.summary, report.curves) {
        body += &figure_element(figure);
    }
    body += &repeating(report);
    body
}

const ABOUT_BANDS: &str = "<p class=\"hint\">The plots over time move together. Bands are the extremes of stretches of time; around \
     what happens every cycle is there.</p>\n";

/// Returns buttons that show the places where every cycle is kept.
fn places(curves: &[Curves]) -> String {
    let places = places::of(curves);
    let buttons = places.iter().map(|place| {
        format!(
            "<button data-from=\"{:.6}\" data-to=\"{:.6}\">{:.2} s: {}</button>\n",
            place.from_s,
            place.to_s,
            place.from_s,
            escaped(&place.words),
        )
    });
    if places.is_empty() {
        return String::new();
    }
    format!(
        "<details class=\"places\">\n<summary>Where every cycle is kept</summary>\n<button \
         data-all>the whole run</button>\n{}</details>\n",
        buttons.collect::<String>()
    )
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

/// Returns the figure with its words, or the reason why there is none.
fn figure_element(figure: &Figure) -> String {
    if !figure.is_empty() {
        return page::figure_element(figure);
    }
    let title = escaped(&figure.title);
    format!(
        "<figure>\n<h3>{title}</h3>\n<p class=\"hint\">No receiver of this run has anything to \
         show here.</p>\n</figure>\n"
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
