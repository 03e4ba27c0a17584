//! A figure over one axis: a curve for each receiver or slave.

use coaxle_lab::sweep::plot::{Along, Plot};
use coaxle_lab::sweep::statistics::Statistics;
use plotters::chart::ChartContext;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::scale::Scale;
use super::{Area, DrawError, FONT};
use crate::plotting::{colour, rgb};

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Pixels of the chart, and of the names beside it.
const CHART: (u32, u32) = (860, 560);
const LETTER: u32 = 9;

pub(super) fn size(plot: &Plot) -> (u32, u32) {
    let titles = plot.panels.iter().map(|panel| panel.title.chars().count());
    let longest = titles.max().unwrap_or(0) as u32;
    (CHART.0 + 50 + LETTER * longest, CHART.1)
}

/// How places and figures are drawn.
#[derive(Clone, Copy)]
struct Scales {
    across: Scale,
    up: Scale,
}

pub(super) fn draw(root: &Area<'_>, name: &str, plot: &Plot) -> Result<(), DrawError> {
    let (area, names) = root.split_horizontally(CHART.0);
    let places = plot.across.places();
    let known = || plot.panels.iter().flat_map(|panel| panel.cells.iter());
    let ends = || known().flatten().flat_map(|cell| [cell.low, cell.high]);
    // Words lie one beside the other.
    let numbers = plot.across.numbers.iter().flatten().copied();
    let scales = Scales {
        across: Scale::of(numbers),
        up: Scale::of(ends()),
    };
    let x = scales.across.range(places.iter().copied(), 0.03);
    let y = scales.up.range(ends(), 0.08);
    let labels = match plot.across.numbers {
        Some(_) => scales.across.labels(&x),
        None => places.len(),
    };
    let labels = (labels, scales.up.labels(&y));
    let mut builder = ChartBuilder::on(&area);
    let caption = format!("{name}: {}", plot.heading);
    builder.caption(caption, (FONT, 22)).margin(16);
    builder.x_label_area_size(48).y_label_area_size(84);
    let mut chart = builder.build_cartesian_2d(x, y)?;
    mesh(&mut chart, plot, scales, labels)?;
    for (n, panel) in plot.panels.iter().enumerate() {
        curve(
            &mut chart,
            pen(n),
            scales,
            &stretches(&places, &panel.cells),
        )?;
        let y = 70 + 24 * n as i32;
        let line = [(0, y), (24, y)];
        names.draw(&PathElement::new(line, pen(n).stroke_width(3)))?;
        names.draw(&Text::new(panel.title.as_str(), (32, y - 7), (FONT, 14)))?;
    }
    Ok(())
}

fn mesh(
    chart: &mut Chart<'_, '_>,
    plot: &Plot,
    scales: Scales,
    labels: (usize, usize),
) -> Result<(), DrawError> {
    let along = &plot.across;
    let across = |place: &f64| match along.numbers {
        Some(_) => scales.across.label(*place),
        None => word_at(along, *place),
    };
    let up = |place: &f64| scales.up.label(*place);
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(along.field.as_str())
        .y_desc(plot.heading.as_str());
    mesh.x_labels(labels.0).x_label_formatter(&across);
    mesh.y_labels(labels.1).y_label_formatter(&up);
    mesh.max_light_lines(0)
        .bold_line_style(RGBColor(225, 225, 225));
    mesh.axis_desc_style((FONT, 16)).label_style((FONT, 14));
    mesh.draw()?;
    Ok(())
}

/// The medians, within a band from the 5 % to the 95 % quantile.
fn curve(
    chart: &mut Chart<'_, '_>,
    colour: RGBColor,
    scales: Scales,
    stretches: &[Vec<(f64, Statistics)>],
) -> Result<(), DrawError> {
    let at = |(place, cell): &(f64, Statistics), value: fn(&Statistics) -> f64| {
        (scales.across.place(*place), scales.up.place(value(cell)))
    };
    for stretch in stretches {
        let low = stretch.iter().map(|it| at(it, |cell| cell.low));
        let high = stretch.iter().rev().map(|it| at(it, |cell| cell.high));
        let band: Vec<_> = low.chain(high).collect();
        chart.draw_series([Polygon::new(band, colour.mix(0.2))])?;
        let medians = stretch.iter().map(|it| at(it, |cell| cell.median));
        chart.draw_series(LineSeries::new(medians.clone(), colour.stroke_width(2)))?;
        chart.draw_series(medians.map(|place| Circle::new(place, 4, colour.filled())))?;
    }
    Ok(())
}

/// The word that lies there; none between two.
fn word_at(along: &Along, place: f64) -> String {
    let is_at_one = (place - place.round()).abs() < 1e-6 && place > -0.5;
    let word = along.values.get(place.round().max(0.0) as usize);
    word.filter(|_| is_at_one).cloned().unwrap_or_default()
}

/// The cells that there are, in stretches without a gap.
fn stretches(places: &[f64], cells: &[Option<Statistics>]) -> Vec<Vec<(f64, Statistics)>> {
    let mut stretches = vec![Vec::new()];
    for (place, cell) in places.iter().zip(cells) {
        match (cell, stretches.last_mut()) {
            (Some(cell), Some(last)) => last.push((*place, *cell)),
            _ => stretches.push(Vec::new()),
        }
    }
    stretches.retain(|stretch| !stretch.is_empty());
    stretches
}

/// The n-th curve's, as reports have them.
fn pen(n: usize) -> RGBColor {
    let (red, green, blue) = rgb(&colour(n));
    RGBColor(red, green, blue)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_has_a_gap_where_nothing_is_known() {
        let cell = Statistics {
            known: 1,
            median: 1.0,
            low: 1.0,
            high: 1.0,
            worst: 1.0,
        };
        let cells = [Some(cell), None, Some(cell), Some(cell)];
        let stretches = stretches(&[1.0, 2.0, 3.0, 4.0], &cells);
        let lengths: Vec<_> = stretches.iter().map(Vec::len).collect();
        assert_eq!(lengths, [1, 2]);
    }
}
