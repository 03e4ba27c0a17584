//! Figures as files: SVG and PDF, of vectors, as wide as a column of a paper, or SVG as large as a screen shows it.

mod curves;
mod frame;
mod legend;
mod maps;
mod panels;
mod pdf;
mod picture;
mod plant;
mod svg;

use std::path::Path;

use anyhow::Context;
use coaxle_topology::PlantAnalysis;

use self::panels::Paper;
use self::svg::SvgUnit;
use crate::figure::{Figure, Maps};

/// Width of a column of a paper, mm.
pub const COLUMN_MM: f64 = 85.0;

/// Pixels per point of a picture for a screen.
// Seven points of text become fourteen pixels, about what a browser has.
const PIXELS: f64 = 2.0;

/// Writes each figure that is not empty as `NAME.svg` and `NAME.pdf`, `width_mm` wide.
///
/// # Errors
/// Names the folder that cannot be made, or the file that cannot be written.
pub(crate) fn write(folder: &Path, figures: &[Figure], width_mm: f64) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    // A page says why a figure is empty. A file with axes alone would only be taken for a result.
    for figure in figures.iter().filter(|figure| !figure.is_empty()) {
        let [svg, pdf] = files_of(figure, width_mm);
        for (ending, bytes) in [("svg", svg), ("pdf", pdf)] {
            let path = folder.join(format!("{}.{ending}", figure.id));
            std::fs::write(&path, bytes)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
    }
    Ok(())
}

/// Returns the figure as SVG and as PDF.
fn files_of(figure: &Figure, width_mm: f64) -> [Vec<u8>; 2] {
    let picture = panels::picture(figure, &Paper::column(width_mm));
    let svg = svg::drawn(&picture, SvgUnit::Millimetres);
    [svg.into_bytes(), pdf::drawn(&picture)]
}

/// Returns a figure as SVG for a screen.
#[must_use]
pub fn svg(figure: &Figure) -> String {
    let picture = panels::picture(figure, &Paper::screen(figure));
    svg::drawn(&picture, SvgUnit::Pixels(PIXELS))
}

/// Returns maps as SVG for a screen.
#[must_use]
pub fn svg_of_maps(maps: &Maps) -> String {
    svg::drawn(&maps::picture(maps), SvgUnit::Pixels(PIXELS))
}

/// Width of a laptop's screen, pixels.
const SCREEN: f64 = 1366.0;

/// Returns all nodes of a plant as SVG for a screen.
#[must_use]
pub fn svg_of_plant(plant: &PlantAnalysis) -> String {
    let picture = plant::picture(plant);
    // A plant of many layers is drawn smaller.
    let each = f64::min(PIXELS, SCREEN / picture.width);
    svg::drawn(&picture, SvgUnit::Pixels(each))
}

#[cfg(test)]
mod tests;
