//! `scale.svg`: cost of a cycle over the size, on logarithmic axes.

use std::path::Path;

use anyhow::{Context, anyhow};
use coaxle_report::plotting::{colour, rgb};
use plotters::prelude::*;

use super::cost::Cost;
use super::size::SizeSeries;

const SIZE: (u32, u32) = (860, 560);
const FONT: &str = "sans-serif";

/// Error of the drawing library.
type DrawError = Box<dyn std::error::Error>;

/// Draws the costs of all series.
///
/// # Errors
/// Names the file that cannot be written.
pub(super) fn write(path: &Path, costs: &[Cost]) -> anyhow::Result<()> {
    let drawn = drawn(costs);
    let drawn = drawn.map_err(|error| anyhow!("cannot draw {}: {error}", path.display()))?;
    std::fs::write(path, drawn).with_context(|| format!("cannot write {}", path.display()))
}

fn drawn(costs: &[Cost]) -> Result<String, DrawError> {
    let mut text = String::new();
    let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let most = costs.iter().map(|cost| cost.size.count).max().unwrap_or(1) as f64;
    let ends = || costs.iter().map(Cost::cycle_us);
    let (low, high) = (
        ends().fold(f64::INFINITY, f64::min),
        ends().fold(0.0, f64::max),
    );
    let mut builder = ChartBuilder::on(&root);
    builder
        .caption("Processor time of a cycle of all nodes", (FONT, 22))
        .margin(16);
    builder.x_label_area_size(48).y_label_area_size(84);
    let (x, y) = (
        (0.8..1.3 * most).log_scale(),
        (0.7 * low..1.5 * high).log_scale(),
    );
    let mut chart = builder.build_cartesian_2d(x, y)?;
    let mut mesh = chart.configure_mesh();
    mesh.x_desc("how many there are").y_desc("µs");
    mesh.max_light_lines(0)
        .bold_line_style(RGBColor(225, 225, 225));
    mesh.axis_desc_style((FONT, 16)).label_style((FONT, 14));
    mesh.draw()?;
    for (n, series) in SizeSeries::ALL.into_iter().enumerate() {
        let (red, green, blue) = rgb(&colour(n));
        let pen = RGBColor(red, green, blue);
        let of = costs.iter().filter(|cost| cost.size.series == series);
        let places: Vec<_> = of
            .map(|cost| (cost.size.count as f64, cost.cycle_us()))
            .collect();
        let line = LineSeries::new(places.clone(), pen.stroke_width(2));
        chart
            .draw_series(line)?
            .label(series_text(series))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], pen.stroke_width(3)));
        chart.draw_series(
            places
                .into_iter()
                .map(|place| Circle::new(place, 4, pen.filled())),
        )?;
    }
    let mut legend = chart.configure_series_labels();
    legend.position(SeriesLabelPosition::UpperLeft).margin(12);
    legend
        .background_style(WHITE)
        .label_font((FONT, 14))
        .draw()?;
    root.present()?;
    drop(chart);
    drop(root);
    Ok(text)
}

const fn series_text(series: SizeSeries) -> &'static str {
    match series {
        SizeSeries::Receivers => "receivers of one sender",
        SizeSeries::Senders => "senders of one receiver",
        SizeSeries::Axes => "axes and slaves",
    }
}
