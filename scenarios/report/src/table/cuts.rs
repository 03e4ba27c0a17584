//! The rows of slaves that cut.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use coaxle_lab::number::significant;
use coaxle_lab::summary::{CutsSummary, ReceiverSummary, Summary};
use coaxle_lab::units::{self, Fine};

use super::{CORRECTIONS, NOTHING, optional, roughly};

/// Returns the greatest errors of the lengths of the pieces, a line per way of correction. None where the scenario cuts nothing
/// without correction to compare with.
pub(super) fn conclusion(summary: &Summary) -> Option<String> {
    let of_mode = |mode| summary.receivers.values().filter(move |r| r.mode == mode);
    // Lengths, not positions: a lag shifts all cuts alike, and the pieces stay right.
    let bare = worst_length(of_mode("bypass"))?;
    let cutting = summary.receivers.values().flat_map(cuts_of);
    let Fine { factor, unit } = units::fine(&units::common(cutting.map(|cuts| &cuts.cut_unit)));
    let shown = |error: f64| format!("{} {unit}", significant(factor * error, 3));
    let mut text = format!(
        "without correction: pieces are off by up to {}",
        shown(bare)
    );
    for (mode, name) in CORRECTIONS {
        if of_mode(mode).next().is_none() {
            continue;
        }
        match worst_length(of_mode(mode)) {
            None => {
                let _ = write!(text, "\n{name}nothing was cut twice within the run");
            }
            Some(worst) => {
                let _ = write!(text, "\n{name}by up to {}", shown(worst));
                if worst > 0.0 && bare > worst {
                    let _ = write!(text, ", about {} times less", roughly(bare / worst));
                }
            }
        }
    }
    Some(text)
}

/// Returns the largest error of a length among these receivers; none if nothing was cut twice.
fn worst_length<'a>(receivers: impl Iterator<Item = &'a ReceiverSummary>) -> Option<f64> {
    let errors = receivers
        .flat_map(cuts_of)
        .filter_map(|cuts| cuts.cut_length_error_max);
    errors.reduce(f64::max)
}

/// Returns the cuts of the slaves that cut.
fn cuts_of(receiver: &ReceiverSummary) -> impl Iterator<Item = &CutsSummary> {
    let cuts = receiver.slaves.values().map(|slave| &slave.cuts);
    cuts.filter(|cuts| cuts.cuts > 0)
}

/// Returns a label and a value per receiver, for every slave that cuts; none where no slave does.
pub(super) fn rows<'a>(receivers: &[(&str, &'a ReceiverSummary)]) -> Vec<(String, Vec<String>)> {
    let slaves = cutting(receivers);
    let mut rows = Vec::new();
    for slave in &slaves {
        let cuts = |receiver: &'a ReceiverSummary| Some(&receiver.slaves.get(*slave)?.cuts);
        let known = receivers.iter().filter_map(|(_, receiver)| cuts(receiver));
        let Fine { factor, unit } = units::fine(&units::common(known.map(|cuts| &cuts.cut_unit)));
        for (label, text) in FIGURES {
            let label = label.replace("{unit}", &unit);
            let label = match slaves.len() {
                1 => label,
                // A single one needs no name.
                _ => format!("{slave}: {label}"),
            };
            let value = |receiver| {
                cuts(receiver).map_or_else(|| NOTHING.to_owned(), |cuts| text(cuts, factor))
            };
            rows.push((label, receivers.iter().map(|(_, r)| value(r)).collect()));
        }
    }
    rows
}

/// Returns the names of the slaves that cut, of all receivers.
fn cutting<'a>(receivers: &[(&str, &'a ReceiverSummary)]) -> BTreeSet<&'a str> {
    receivers
        .iter()
        .flat_map(|(_, receiver)| &receiver.slaves)
        .filter(|(_, slave)| slave.cuts.cuts > 0)
        .map(|(name, _)| name.as_str())
        .collect()
}

/// Label, and the text of its value, given the number of small units to a unit of the master.
type Figure = (&'static str, fn(&CutsSummary, f64) -> String);

const FIGURES: [Figure; 5] = [
    ("cuts", |c, _| c.cuts.to_string()),
    ("cut off its mark max, {unit}", |c, factor| {
        optional(c.cut_position_error_max, factor)
    }),
    ("cut off its mark rms, {unit}", |c, factor| {
        optional(c.cut_position_error_rms, factor)
    }),
    ("length error max, {unit}", |c, factor| {
        optional(c.cut_length_error_max, factor)
    }),
    ("length error rms, {unit}", |c, factor| {
        optional(c.cut_length_error_rms, factor)
    }),
];
