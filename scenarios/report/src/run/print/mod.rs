//! Figures as files for papers: SVG and PDF, of vectors, as wide as a column of text.

mod layout;
mod pdf;
mod picture;
mod svg;

use std::path::Path;

use anyhow::Context;
use coaxle_lab::curves::Curves;
use coaxle_lab::summary::Summary;

use super::figure::Figure;
use super::figures;

/// How wide a column of a paper is, mm.
pub const COLUMN_MM: f64 = 85.0;

/// Writes each figure of a run that has anything in it as `NAME.svg` and `NAME.pdf`, so many millimetres wide.
///
/// # Errors
/// Names the folder that cannot be made, or the file that cannot be written.
pub(crate) fn write(
    folder: &Path,
    summary: &Summary,
    curves: &[Curves],
    width_mm: f64,
) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    for figure in figures::all(summary, curves)
        .iter()
        .filter(|figure| !figure.is_empty())
    {
        let [svg, pdf] = files_of(figure, width_mm);
        for (ending, bytes) in [("svg", svg), ("pdf", pdf)] {
            let path = folder.join(format!("{}.{ending}", figure.id));
            std::fs::write(&path, bytes)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
    }
    Ok(())
}

/// The figure as SVG and as PDF.
fn files_of(figure: &Figure, width_mm: f64) -> [Vec<u8>; 2] {
    let picture = layout::picture(figure, width_mm);
    [svg::drawn(&picture).into_bytes(), pdf::drawn(&picture)]
}

#[cfg(test)]
mod tests;
