//! Figures of the slaves: set positions, and errors of the cuts.

use super::shown::ColouredCurves;
use crate::figure::{Across, Curve, Data, Figure, Look, Panel, Room};
use crate::plotting::colour;
use coaxle_lab::summary::{Cut, Summary};
use coaxle_lab::units;

/// Returns the error of every cut, by receiver.
pub(super) fn cuts(summary: &Summary, receivers: &[ColouredCurves<'_>]) -> Figure {
    let cuts = summary.receivers.values();
    let cuts = cuts.flat_map(|receiver| receiver.slaves.values().map(|slave| &slave.cuts));
    // A slave without cuts has no errors, and its unit must not take the micrometres from the others.
    let cutting = cuts.filter(|cuts| cuts.cuts > 0);
    let fine = units::fine(&units::common(cutting.map(|cuts| &cuts.cut_unit)));
    let panels = ERRORS.map(|(quantity, error)| {
        let curves = receivers.iter().flat_map(|receiver| {
            let figures = summary.receivers.get(&receiver.curves.name);
            let slaves = figures.into_iter().flat_map(|figures| &figures.slaves);
            slaves.filter_map(move |(_, slave)| {
                curve_of_cuts(receiver, &slave.cuts.cut_list, error, fine.factor)
            })
        });
        Panel {
            quantity: quantity.to_owned(),
            unit: fine.unit.clone(),
            height: 230,
            curves: curves.collect(),
            ..Panel::default()
        }
    });
    Figure {
        id: "cuts".to_owned(),
        title: "Every cut".to_owned(),
        caption:
            "Above: by how much each piece is longer than its marks are apart. Below: how far \
                  beyond its mark each cut is, a lag included."
                .to_owned(),
        across: Across::run(),
        panels: panels.into(),
        is_on_one_scale: false,
    }
}

type Error = fn(&Cut) -> Option<f64>;

const ERRORS: [(&str, Error); 2] = [
    ("piece too long", |cut| cut.length_error),
    ("off its mark", |cut| cut.position_error),
];

fn curve_of_cuts(
    receiver: &ColouredCurves<'_>,
    list: &[Cut],
    error: Error,
    factor: f64,
) -> Option<Curve> {
    let known = list
        .iter()
        .filter_map(|cut| Some((cut.t_s, factor * error(cut)?)));
    let known: Vec<_> = known.collect();
    (!known.is_empty()).then(|| Curve {
        look: Look::Dots,
        ..Curve::new(receiver.name(), &receiver.colour, Data::Points(known))
    })
}

/// Returns the set positions of all slaves, a panel per receiver.
pub(super) fn positions(receivers: &[ColouredCurves<'_>], room: Room) -> Figure {
    let panels = receivers.iter().map(|receiver| {
        let slaves = &receiver.curves.slaves;
        let curves = slaves.iter().enumerate().map(|(n, slave)| {
            // The first colour stands for receivers without correction.
            let data = Data::of(&slave.position, room, 0.0);
            Curve::new(&slave.name, &colour(n + 1), data)
        });
        Panel {
            title: receiver.title(),
            unit: units::common(slaves.iter().map(|slave| &slave.unit)).to_string(),
            height: 170,
            curves: curves.filter(|curve| !curve.data.is_empty()).collect(),
            ..Panel::default()
        }
    });
    Figure {
        id: "positions".to_owned(),
        title: "Where the slaves are".to_owned(),
        caption: "Set positions of all slaves of each receiver.".to_owned(),
        across: Across::run(),
        panels: panels.collect(),
        is_on_one_scale: false,
    }
}
