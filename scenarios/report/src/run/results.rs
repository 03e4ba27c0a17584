//! The tables of a report: figures of the whole run, those of its phases, and the expectations.

use std::fmt::Write as _;

use coaxle_lab::summary::{ReceiverSummary, Summary};
use coaxle_lab::verdict::Verdict;

use crate::page::escaped;
use crate::table;

/// Returns the figures of every receiver: of the whole run, and apart of the settled time and of locking in.
pub(super) fn results(summary: &Summary) -> String {
    let receivers = table::in_order(summary);
    let mut figures = table::rows(&receivers);
    // A page has room for the phases in a table of their own. On a terminal they are rows of the only one.
    figures.retain(|(label, _)| !table::is_of_a_phase(label));
    let phases = table::phases(&receivers);
    let mut text = format!(
        "<h2>Results</h2>\n{}<p class=\"hint\">From the first synchronisation on, or from the start where a receiver never \
         synchronises. Time errors without their mean, which is the lag.</p>\n",
        figures_of(&receivers, &[("", figures)])
    );
    if !phases.is_empty() {
        let _ = writeln!(
            text,
            "<h3>Settled, and while locking in</h3>\n{}<p class=\"hint\">Settled: in sync for a second or more, or all the \
             time where a receiver never synchronises; before that it locks in.</p>",
            figures_of(&receivers, &phases)
        );
    }
    text
}

/// Returns a row for each receiver; the name of each phase, if it has one, is above its columns.
fn figures_of(receivers: &[(&str, &ReceiverSummary)], phases: &[table::Phase]) -> String {
    let mut text = "<div class=\"wide\"><table>\n<thead>".to_owned();
    if phases.iter().any(|(name, _)| !name.is_empty()) {
        text += "<tr><th></th>";
        for (name, figures) in phases {
            let _ = write!(
                text,
                "<th class=\"phase\" colspan=\"{}\">{name}</th>",
                figures.len()
            );
        }
        text += "</tr>\n";
    }
    text += "<tr><th>receiver</th>";
    let figures = || phases.iter().flat_map(|(_, figures)| figures);
    for (label, _) in figures() {
        let _ = write!(text, "<th>{}</th>", escaped(label));
    }
    text += "</tr></thead>\n<tbody>\n";
    for (n, (name, _)) in receivers.iter().enumerate() {
        let _ = write!(text, "<tr><th>{}</th>", escaped(name));
        for (_, values) in figures() {
            let _ = write!(text, "<td>{}</td>", escaped(&values[n]));
        }
        text += "</tr>\n";
    }
    text + "</tbody>\n</table></div>\n"
}

/// Returns the expectations, and whether each is met.
pub(super) fn expectations(summary: &Summary) -> String {
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
