//! The rows of slaves that cut.

use std::collections::BTreeSet;

use super::optional;
use crate::summary::{CutsSummary, ReceiverSummary};

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
                None => "–".to_owned(),
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
