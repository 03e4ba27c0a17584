//! `scale.svg`: cost of a cycle over the size, on logarithmic axes.

use std::path::Path;

use anyhow::Context;
use coaxle_report::figure::{Across, Curve, Data, Figure, Look, Panel, Scale};
use coaxle_report::plotting::colour;
use coaxle_report::print;

use super::cost::Cost;
use super::size::SizeSeries;

const TITLE: &str = "Processor time of a cycle of all nodes";

/// Draws the costs of all series.
///
/// # Errors
/// Names the file that cannot be written.
pub(super) fn write(path: &Path, costs: &[Cost]) -> anyhow::Result<()> {
    let drawn = print::svg(&figure(costs));
    std::fs::write(path, drawn).with_context(|| format!("cannot write {}", path.display()))
}

fn figure(costs: &[Cost]) -> Figure {
    let curves = SizeSeries::ALL.into_iter().enumerate().map(|(n, series)| {
        let of = costs.iter().filter(|cost| cost.size.series == series);
        let places = of.map(|cost| (cost.size.count as f64, cost.cycle_us()));
        Curve {
            look: Look::Dots,
            ..Curve::new(
                series_text(series),
                &colour(n),
                Data::Points(places.collect()),
            )
        }
    });
    let panel = Panel {
        title: TITLE.to_owned(),
        unit: "µs".to_owned(),
        // Costs span two decades and sizes three.
        scale: Scale::Logarithmic,
        curves: curves.collect(),
        ..Panel::default()
    };
    Figure {
        id: "scale".to_owned(),
        title: TITLE.to_owned(),
        across: Across {
            scale: Scale::Logarithmic,
            is_padded: true,
            ..Across::of("how many there are", "")
        },
        panels: vec![panel],
        ..Figure::default()
    }
}

const fn series_text(series: SizeSeries) -> &'static str {
    match series {
        SizeSeries::Receivers => "receivers of one sender",
        SizeSeries::Senders => "senders of one receiver",
        SizeSeries::Axes => "axes and slaves",
    }
}
