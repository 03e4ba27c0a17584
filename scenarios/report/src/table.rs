//! The results for a person at a terminal.

mod cuts;
mod many;
mod routers;

use std::fmt::Write as _;

use coaxle_lab::number::significant;
use coaxle_lab::summary::{ReceiverSummary, Summary};
use coaxle_lab::units;
use coaxle_lab::verdict::Verdict;
use coaxle_node::config::Unit;
use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{Cell, CellAlignment, Table};
use serde_json::Value;

pub use routers::routers;

/// Returns the table of results: a column per receiver, a row per figure. Where the terminal is too narrow for all receivers
/// the table is continued below, so that nothing is cut.
#[must_use]
pub fn results(summary: &Summary) -> String {
    let terminal = terminal_size::terminal_size_of(std::io::stdout());
    let width = terminal.map_or(WIDTH_OF_A_FILE, |(width, _)| width.0);
    results_within(summary, width.into())
}

/// Columns assumed where the output is no terminal.
const WIDTH_OF_A_FILE: u16 = 100;

/// Greatest number of receivers that have a column each: of more, their ranges are shown.
const MOST_COLUMNS: usize = 24;

fn results_within(summary: &Summary, width: usize) -> String {
    let receivers = in_order(summary);
    if receivers.len() > MOST_COLUMNS {
        return many::ranges(&receivers).trim_fmt();
    }
    let mut blocks = Vec::new();
    let mut rest = receivers.as_slice();
    while !rest.is_empty() {
        let mut count = rest.len();
        let mut table = block(&rest[..count]);
        // Characters, not bytes: a dash or µ has several. A single receiver is shown however wide it is.
        while count > 1 && table.lines().any(|line| line.chars().count() > width) {
            count -= 1;
            // Widths depend on all cells of a column, so that only drawing it tells.
            table = block(&rest[..count]);
        }
        blocks.push(table.trim_fmt());
        rest = &rest[count..];
    }
    blocks.join("\n\n")
}

fn block(receivers: &[(&str, &ReceiverSummary)]) -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY);
    let names = receivers.iter().map(|(name, _)| right(name));
    table.set_header(std::iter::once(Cell::new("receiver")).chain(names));
    for (label, values) in rows(receivers) {
        let values = values.iter().map(|value| right(value));
        table.add_row(std::iter::once(Cell::new(label)).chain(values));
    }
    // The horizontal style would draw a line under every row.
    table.style_mut().row_separator = comfy_table::LineStyle::none();
    table
}

fn right(text: &str) -> Cell {
    Cell::new(text).set_alignment(CellAlignment::Right)
}

/// Returns the expectations, one a line: those that failed last, where the eye is. Of very many that are met, only their
/// number. Empty if there are none.
#[must_use]
pub fn verdicts(summary: &Summary) -> String {
    let (met, failed): (Vec<_>, Vec<_>) = summary.expectations.iter().partition(|v| v.met);
    let met = match met.len() {
        // Hundreds of lines would push the failed ones off the screen.
        0..=MOST_MET => met.into_iter().map(verdict).collect(),
        many => vec![format!("ok     {many} expectations are met")],
    };
    let lines: Vec<_> = met
        .into_iter()
        .chain(failed.into_iter().map(verdict))
        .collect();
    lines.join("\n")
}

/// Greatest number of met expectations that are listed one by one.
const MOST_MET: usize = 100;

fn verdict(verdict: &Verdict) -> String {
    let outcome = if verdict.met { "ok    " } else { "FAILED" };
    let (place, expected) = (verdict.place(), &verdict.expected);
    let received = value(&verdict.received);
    format!("{outcome} {place} is {received}, expected {expected}")
}

/// Returns the conclusion of the run, in a few lines: without correction, and with each kind of it. None where the scenario
/// does not compare them.
#[must_use]
pub fn conclusion(summary: &Summary) -> Option<String> {
    cuts::conclusion(summary).or_else(|| velocities(summary))
}

/// The corrections, with their names in a line of a conclusion.
const CORRECTIONS: [(&str, &str); 4] = [
    ("pt1", "with a PT1 filter:  "),
    ("time", "with time mode:     "),
    ("sync", "with TS5066:        "),
    ("observer", "with the observer:  "),
];

fn velocities(summary: &Summary) -> Option<String> {
    let without = worst(summary, "bypass", None)?;
    let bare = without.velocity_ripple_ratio?;
    let mut text = format!(
        "without correction: the velocity jumps by up to {} %",
        significant(100.0 * bare, 3)
    );
    match without.last.far.beats {
        0 => {}
        1 => text.push_str(", with one beat"),
        beats => {
            let _ = write!(text, ", with {beats} beats");
        }
    }
    let master = Some(without.master.as_str());
    let mut any = false;
    for (mode, name) in CORRECTIONS {
        let Some(with) = worst(summary, mode, master) else {
            continue;
        };
        any = true;
        match with.velocity_ripple_ratio {
            None => {
                let _ = write!(text, "\n{name}not synchronised within the run");
            }
            Some(all) => {
                // The lock-in is a transient of the start: what remains is the ripple once settled.
                let cured = with.velocity_ripple_settled_ratio.unwrap_or(all);
                let _ = write!(text, "\n{name}by up to {} %", significant(100.0 * cured, 3));
                if cured > 0.0 && bare > cured {
                    let _ = write!(text, ", about {} times smaller", roughly(bare / cured));
                }
                if all > cured {
                    let _ = write!(text, "; {} % while locking in", significant(100.0 * all, 3));
                }
            }
        }
    }
    any.then_some(text)
}

/// Formats a factor with two significant digits, the rest zeros.
fn roughly(factor: f64) -> String {
    let rounded: f64 = format!("{factor:.1e}").parse().unwrap_or(factor);
    significant(rounded, 2)
}

/// Returns the receiver of a mode (and of a master) whose velocity is the roughest; one that was never judged, if there is any,
/// is worse than all.
fn worst<'a>(
    summary: &'a Summary,
    mode: &str,
    master: Option<&str>,
) -> Option<&'a ReceiverSummary> {
    // Otherwise a receiver that never got in sync would hide behind one that did.
    let ripple = |r: &ReceiverSummary| r.velocity_ripple_ratio.unwrap_or(f64::INFINITY);
    summary
        .receivers
        .values()
        .filter(|receiver| receiver.mode == mode)
        .filter(|receiver| master.is_none_or(|master| receiver.master == master))
        .max_by(|a, b| ripple(a).total_cmp(&ripple(b)))
}

/// Returns the figures shown, in the order of interest: a label and a value per receiver.
pub(crate) fn rows(receivers: &[(&str, &ReceiverSummary)]) -> Vec<(String, Vec<String>)> {
    let unit = units::common(receivers.iter().map(|(_, receiver)| &receiver.unit));
    let row = |figure: &Figure| {
        let values = receivers.iter().map(|(_, r)| (figure.text)(r)).collect();
        (in_unit(figure.label, &unit), values)
    };
    // The purpose of a scenario with cuts comes right after the kind of correction.
    let (mode, others) = FIGURES.split_at(1);
    let mut rows: Vec<_> = mode.iter().map(row).collect();
    rows.extend(cuts::rows(receivers));
    rows.extend(others.iter().map(row));
    rows.extend(signal_rows(receivers, &unit));
    // A figure that no receiver has would only be in the way.
    rows.retain(|(_, values)| values.iter().any(|value| value != NOTHING));
    rows
}

/// Returns the last values of the signals whose declaration has a label.
fn signal_rows(receivers: &[(&str, &ReceiverSummary)], unit: &Unit) -> Vec<(String, Vec<String>)> {
    let mut rows: Vec<(String, Vec<String>)> = Vec::new();
    for (n, (_, receiver)) in receivers.iter().enumerate() {
        let values = receiver.last.values();
        let labelled = values.filter_map(|(signal, value)| Some((signal, signal.label?, value)));
        for (row, (signal, label, value)) in labelled.enumerate() {
            if n == 0 {
                let of = unit.in_place_of_u(signal.unit);
                let label = match of.as_str() {
                    "" => label.to_owned(),
                    of => format!("{label}, {of}"),
                };
                rows.push((label, Vec::new()));
            }
            // Every receiver has the signals of one declaration, in its order.
            rows[row].1.push(shown(&value));
        }
    }
    rows
}

/// Formats a value for people: three digits of a number, all of a count.
fn shown(value: &Value) -> String {
    match value {
        Value::Null => NOTHING.to_owned(),
        Value::Number(n) if n.is_f64() => optional(n.as_f64(), 1.0),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// Returns a label, with the unit that the `u` after its comma stands for.
fn in_unit(label: &str, unit: &Unit) -> String {
    match label.rsplit_once(", ") {
        Some((name, of)) => format!("{name}, {}", unit.in_place_of_u(of)),
        None => label.to_owned(),
    }
}

/// Text in place of a missing value.
const NOTHING: &str = "–";

/// Figure of a receiver, as tables show it.
struct Figure {
    /// Name and unit.
    label: &'static str,
    /// The value as text; a dash where there is none.
    text: fn(&ReceiverSummary) -> String,
}

const FIGURES: [Figure; 17] = [
    Figure {
        label: "correction",
        text: |r| correction(r.mode).to_owned(),
    },
    Figure {
        label: "velocity ripple max, u/s",
        text: |r| optional(r.velocity_ripple_max, 1.0),
    },
    Figure {
        label: "… of master velocity, %",
        text: |r| optional(r.velocity_ripple_ratio, 100.0),
    },
    Figure {
        label: "velocity ripple rms, u/s",
        text: |r| optional(r.velocity_ripple_rms, 1.0),
    },
    Figure {
        label: "… once settled max, u/s",
        text: |r| optional(r.velocity_ripple_settled_max, 1.0),
    },
    Figure {
        label: "… while locking in max, u/s",
        text: |r| optional(r.velocity_ripple_lock_in_max, 1.0),
    },
    Figure {
        label: "time error max, µs",
        text: |r| optional(r.corrected_time_error_max_us, 1.0),
    },
    Figure {
        label: "time error rms, µs",
        text: |r| optional(r.corrected_time_error_rms_us, 1.0),
    },
    Figure {
        label: "… once settled rms, µs",
        text: |r| optional(r.corrected_time_error_settled_rms_us, 1.0),
    },
    Figure {
        label: "… while locking in max, µs",
        text: |r| optional(r.corrected_time_error_lock_in_max_us, 1.0),
    },
    Figure {
        label: "far axis off its master max, u",
        text: |r| optional(r.far_position_error_max, 1.0),
    },
    Figure {
        label: "lag, ms",
        text: |r| optional(r.lag_us, 1e-3),
    },
    Figure {
        label: "off the master max, µs of travel",
        text: |r| optional(r.lag_error_max_us, 1.0),
    },
    Figure {
        label: "drift true, ppm",
        text: |r| optional(r.drift_ppm_true, 1.0),
    },
    Figure {
        label: "time to sync, s",
        text: |r| optional(r.time_to_sync_s, 1.0),
    },
    Figure {
        label: "cycles that its sender skipped",
        text: |r| match r.skipped_by_sender {
            0 => NOTHING.to_owned(),
            skipped => skipped.to_string(),
        },
    },
    Figure {
        label: "errors",
        text: |r| match &r.last_error {
            Some(last) => format!("{} ({last})", r.errors),
            None => r.errors.to_string(),
        },
    },
];

/// Figures of a phase of the run: its name, and a label and a value per receiver.
pub(crate) type Phase = (&'static str, Vec<(String, Vec<String>)>);

/// Returns the figures of the settled time, and those of locking in, apart; without those that no receiver has.
pub(crate) fn phases(receivers: &[(&str, &ReceiverSummary)]) -> Vec<Phase> {
    let unit = units::common(receivers.iter().map(|(_, receiver)| &receiver.unit));
    let of = |figures: &[Figure]| {
        let rows = figures.iter().map(|figure| {
            let values = receivers.iter().map(|(_, r)| (figure.text)(r));
            (in_unit(figure.label, &unit), values.collect::<Vec<_>>())
        });
        let known = |(_, values): &(String, Vec<String>)| values.iter().any(|v| v != NOTHING);
        rows.filter(known).collect::<Vec<_>>()
    };
    let all = [("settled", of(&SETTLED)), ("locking in", of(&LOCKING_IN))];
    let all = all.into_iter().filter(|(_, rows): &Phase| !rows.is_empty());
    all.collect()
}

/// Reports whether [`phases`] has the figure of this label, too.
pub(crate) fn is_of_a_phase(label: &str) -> bool {
    label.starts_with("… once settled") || label.starts_with("… while locking in")
}

const SETTLED: [Figure; 4] = [
    Figure {
        label: "velocity ripple max, u/s",
        text: |r| optional(r.velocity_ripple_settled_max, 1.0),
    },
    Figure {
        label: "velocity ripple rms, u/s",
        text: |r| optional(r.velocity_ripple_settled_rms, 1.0),
    },
    Figure {
        label: "time error max, µs",
        text: |r| optional(r.corrected_time_error_settled_max_us, 1.0),
    },
    Figure {
        label: "time error rms, µs",
        text: |r| optional(r.corrected_time_error_settled_rms_us, 1.0),
    },
];

const LOCKING_IN: [Figure; 3] = [
    Figure {
        label: "velocity ripple max, u/s",
        text: |r| optional(r.velocity_ripple_lock_in_max, 1.0),
    },
    Figure {
        label: "time error max, µs",
        text: |r| optional(r.corrected_time_error_lock_in_max_us, 1.0),
    },
    Figure {
        label: "time to sync, s",
        text: |r| optional(r.time_to_sync_s, 1.0),
    },
];

/// Returns a mode in words.
pub(crate) fn correction(mode: &str) -> &str {
    match mode {
        "bypass" => "none",
        "pt1" => "PT1 filter",
        "time" => "time mode",
        "sync" => "sync mode",
        "observer" => "observer",
        "virtual" => "none needed",
        other => other,
    }
}

/// Returns names and figures, receivers without correction first: the uncured before the cured.
pub(crate) fn in_order(summary: &Summary) -> Vec<(&str, &ReceiverSummary)> {
    let mut receivers: Vec<_> = summary
        .receivers
        .iter()
        .map(|(name, figures)| (name.as_str(), figures))
        .collect();
    receivers.sort_by_key(|(_, figures)| rank(figures.mode));
    receivers
}

/// Ranks of modes, which are the numbers of their colours, too.
pub(crate) const MODES: usize = 4;

/// Returns the rank of a mode by the amount that it corrects.
pub(crate) fn rank(mode: &str) -> u8 {
    match mode {
        "bypass" => 0,
        "pt1" => 1,
        "time" => 2,
        _ => 3,
    }
}

/// Formats a value of the summary as text.
pub(crate) fn value(value: &Value) -> String {
    match value {
        Value::Null => "null".to_owned(),
        Value::Number(n) if n.is_f64() => n.as_f64().map_or_else(
            || n.to_string(),
            // Enough digits that a value just beyond its bound does not look like the bound.
            |n| without_trailing_zeros(significant(n, 6)),
        ),
        other => other.to_string(),
    }
}

fn optional(value: Option<f64>, factor: f64) -> String {
    value.filter(|value| value.is_finite()).map_or_else(
        || NOTHING.to_owned(),
        |value| significant(value * factor, 3),
    )
}

fn without_trailing_zeros(number: String) -> String {
    // Zeros of a whole number and of an exponent count.
    if !number.contains('.') || number.contains('e') {
        return number;
    }
    let short = number.trim_end_matches('0').trim_end_matches('.');
    short.to_owned()
}

#[cfg(test)]
mod tests;
