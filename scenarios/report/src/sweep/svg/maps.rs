//! A figure over two axes: a map for each receiver or slave, and each value of further axes.

use coaxle_lab::number::significant;
use coaxle_lab::sweep::plot::{Along, Panel, Plot};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::scale::Scale;
use super::{Area, DrawError, FONT};
use crate::plotting::short;

/// Cells of a map up to which each shows its number.
const MOST_NUMBERS: i32 = 150;

pub(super) fn size(plot: &Plot) -> (u32, u32) {
    let (columns, rows) = layout(plot);
    (560 * columns as u32, 60 + 440 * rows as u32)
}

/// Columns and rows of maps.
fn layout(plot: &Plot) -> (usize, usize) {
    let columns = plot.panels.len().clamp(1, 3);
    (columns, plot.panels.len().div_ceil(columns))
}

pub(super) fn draw(root: &Area<'_>, name: &str, plot: &Plot, up: &Along) -> Result<(), DrawError> {
    let colours = Colours::of(plot);
    let (columns, rows) = layout(plot);
    let title = title(name, plot);
    // As large as fits.
    let fits = 2.2 * f64::from(size(plot).0) / title.chars().count().max(1) as f64;
    let root = root.titled(&title, (FONT, fits.min(22.0)))?;
    let areas = root.split_evenly((rows, columns));
    for (area, panel) in areas.iter().zip(&plot.panels) {
        map(area, plot, up, panel, &colours)?;
    }
    Ok(())
}

/// The figure, and what its colours are between.
fn title(name: &str, plot: &Plot) -> String {
    let mut title = format!("{name}: {}", plot.heading);
    if let Some((low, high)) = plot.range() {
        let (low, high) = (short(low, 3), short(high, 3));
        title += &format!(", from {low} (dark) to {high} (bright)");
    }
    if plot.more > 0 {
        title += &format!("; {} more maps are left out", plot.more);
    }
    title
}

fn map(
    area: &Area<'_>,
    plot: &Plot,
    up: &Along,
    panel: &Panel,
    colours: &Colours,
) -> Result<(), DrawError> {
    let (width, height) = (plot.across.values.len() as i32, up.values.len() as i32);
    let mut builder = ChartBuilder::on(area);
    builder.caption(&panel.title, (FONT, 16)).margin(12);
    builder.x_label_area_size(44).y_label_area_size(84);
    let (x, y) = ((0..width - 1), (0..height - 1));
    let mut chart = builder.build_cartesian_2d(x.into_segmented(), y.into_segmented())?;
    let longest = plot.across.values.iter().map(|value| value.chars().count());
    let letters = longest.max().unwrap_or(0) + 2;
    let (x_every, y_every) = (every(width, LETTERS / letters), every(height, LINES));
    let x_label = |place: &_| word(&plot.across, place, x_every);
    let y_label = |place: &_| word(up, place, y_every);
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(plot.across.field.as_str())
        .y_desc(up.field.as_str());
    mesh.x_labels(width as usize).x_label_formatter(&x_label);
    mesh.y_labels(height as usize).y_label_formatter(&y_label);
    mesh.axis_desc_style((FONT, 14)).label_style((FONT, 13));
    mesh.disable_mesh().draw()?;
    let places = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
    for ((column, row), cell) in places.zip(&panel.cells) {
        let Some(cell) = cell else {
            continue;
        };
        let share = colours.share(cell.median);
        let corners = [(column, row), (column + 1, row + 1)];
        let corners = corners.map(|(x, y)| (SegmentValue::Exact(x), SegmentValue::Exact(y)));
        chart.draw_series([Rectangle::new(corners, bright(share).filled())])?;
        if width * height <= MOST_NUMBERS {
            let ink = if share < 0.5 { WHITE } else { BLACK };
            let style = TextStyle::from((FONT, 14)).color(&ink);
            let style = style.pos(Pos::new(HPos::Center, VPos::Center));
            let middle = (SegmentValue::CenterOf(column), SegmentValue::CenterOf(row));
            let number = significant(cell.median, 3);
            chart.draw_series([Text::new(number, middle, style)])?;
        }
    }
    Ok(())
}

/// Letters that fit below a map, and lines beside it.
const LETTERS: usize = 56;
const LINES: usize = 18;

/// The step from one word to the next, where only so many fit.
fn every(count: i32, fit: usize) -> usize {
    let count = usize::try_from(count).unwrap_or(0);
    count.div_ceil(fit.max(1)).max(1)
}

fn word(along: &Along, place: &SegmentValue<i32>, every: usize) -> String {
    let n = match place {
        SegmentValue::CenterOf(n) => usize::try_from(*n).ok(),
        _ => None,
    };
    let word = n
        .filter(|n| n % every == 0)
        .and_then(|n| along.values.get(n));
    word.cloned().unwrap_or_default()
}

/// Which share of the way from the least to the largest a value is.
struct Colours {
    scale: Scale,
    low: f64,
    high: f64,
}

impl Colours {
    fn of(plot: &Plot) -> Self {
        let cells = plot.panels.iter().flat_map(|panel| panel.cells.iter());
        let scale = Scale::of(cells.flatten().map(|cell| cell.median));
        let (low, high) = plot.range().unwrap_or_default();
        Self {
            scale,
            low: scale.place(low),
            high: scale.place(high),
        }
    }

    fn share(&self, value: f64) -> f64 {
        let share = (self.scale.place(value) - self.low) / (self.high - self.low);
        // All are the same.
        if share.is_finite() { share } else { 0.0 }
    }
}

/// Viridis at five places: dark is little, bright is much, with any colour vision and in print.
const VIRIDIS: [[f64; 3]; 5] = [
    [68.0, 1.0, 84.0],
    [59.0, 82.0, 139.0],
    [33.0, 145.0, 140.0],
    [94.0, 201.0, 98.0],
    [253.0, 231.0, 37.0],
];

fn bright(share: f64) -> RGBColor {
    let place = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let (below, above) = (VIRIDIS[place as usize], VIRIDIS[place.ceil() as usize]);
    let part = |n: usize| (below[n] + place.fract() * (above[n] - below[n])).round() as u8;
    RGBColor(part(0), part(1), part(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_words_only_those_that_fit_are_there() {
        assert_eq!(every(4, 18), 1);
        assert_eq!(every(100, 8), 13);
        assert_eq!(every(3, 0), 3);
        let axis: coaxle_lab::sweep::SweepAxis = "a=1,2,3".parse().unwrap();
        let along = Along::of(&axis);
        let words = [0, 1, 2, 3].map(|n| word(&along, &SegmentValue::CenterOf(n), 2));
        assert_eq!(words, ["1", "", "3", ""]);
    }

    #[test]
    fn colours_are_those_of_the_ends_at_the_ends() {
        assert_eq!(bright(0.0), RGBColor(68, 1, 84));
        assert_eq!(bright(0.5), RGBColor(33, 145, 140));
        assert_eq!(bright(1.0), RGBColor(253, 231, 37));
    }
}
