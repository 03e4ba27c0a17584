//! The rows of slaves that cut.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::{CORRECTIONS, NOTHING, optional, roughly};
use crate::number::significant;
use crate::summary::{CutsSummary, ReceiverSummary, Summary};

/// How far off the lengths of the pieces are, a line per way of correction. None where the scenario
/// cuts nothing without correction to compare with.
pub(super) fn conclusion(summary: &Summary) -> Option<String> {
    let of_mode = |mode| summary.receivers.values().filter(move |r| r.mode == mode);
    let bare = worst_length(of_mode("bypass"))?;
    let mut text = format!(
        "without correction: pieces are off by up to {} µm",
        significant(bare, 3)
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
                let _ = write!(text, "\n{name}by up to {} µm", significant(worst, 3));
                if worst > 0.0 && bare > worst {
                    let _ = write!(text, ", about {} times less", roughly(bare / worst));
                }
            }
        }
    }
    Some(text)
}

/// The largest error of a length among these receivers; none if nothing was cut twice.
fn worst_length<'a>(receivers: impl Iterator<Item = &'a ReceiverSummary>) -> Option<f64> {
    let slaves = receivers.flat_map(|receiver| receiver.slaves.values());
    let errors = slaves.filter_map(|slave| slave.cuts.cut_length_error_max_um);
    errors.reduce(f64::max)
}

/// A label and a value per receiver, for every slave that cuts; none where no slave does.
pub(super) fn rows(receivers: &[(&str, &ReceiverSummary)]) -> Vec<(String, Vec<String>)> {
    let slaves = cutting(receivers);
    let mut rows = Vec::new();
    for slave in &slaves {
        for (label, text) in FIGURES {
            let label = match slaves.len() {
                1 => label.to_owned(),
                _ => format!("{slave}: {label}"),
            };
            let value = |receiver: &ReceiverSummary| match receiver.slaves.get(*slave) {
                Some(figures) => text(&figures.cuts),
                None => NOTHING.to_owned(),
            };
            rows.push((label, receivers.iter().map(|(_, r)| value(r)).collect()));
        }
    }
    rows
}

/// The names of the slaves that cut, of all receivers.
fn cutting<'a>(receivers: &[(&str, &'a ReceiverSummary)]) -> BTreeSet<&'a str> {
    receivers
        .iter()
        .flat_map(|(_, receiver)| &receiver.slaves)
        .filter(|(_, slave)| slave.cuts.cuts > 0)
        .map(|(name, _)| name.as_str())
        .collect()
}

type Figure = (&'static str, fn(&CutsSummary) -> String);

/// µm, if the master's unit is mm.
const FIGURES: [Figure; 5] = [
    ("cuts", |c| c.cuts.to_string()),
    ("cut off its mark max, µm", |c| {
        optional(c.cut_position_error_max_um, 1.0)
    }),
    ("cut off its mark rms, µm", |c| {
        optional(c.cut_position_error_rms_um, 1.0)
    }),
    ("length error max, µm", |c| {
        optional(c.cut_length_error_max_um, 1.0)
    }),
    ("length error rms, µm", |c| {
        optional(c.cut_length_error_rms_um, 1.0)
    }),
];
