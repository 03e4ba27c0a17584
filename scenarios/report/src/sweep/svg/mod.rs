//! `plot.svg`: the plot as a picture for pages and papers.

mod curves;
mod maps;
mod scale;

use std::path::Path;

use anyhow::{Context, anyhow};
use coaxle_lab::sweep::plot::Plot;
use plotters::coord::Shift;
use plotters::prelude::*;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// What the drawing library fails with.
type DrawError = Box<dyn std::error::Error>;

const FONT: &str = "sans-serif";

/// Writes the first of the plots. False if there is none; then there is no file either.
///
/// # Errors
/// Names the file that cannot be written.
pub(super) fn write(path: &Path, name: &str, plots: &[Plot]) -> anyhow::Result<bool> {
    let cannot = || format!("cannot write {}", path.display());
    let Some(plot) = plots.first() else {
        return match std::fs::remove_file(path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(error).with_context(cannot)
            }
            _ => Ok(false),
        };
    };
    let drawn = drawn(name, plot);
    let drawn = drawn.map_err(|error| anyhow!("cannot draw {}: {error}", path.display()))?;
    std::fs::write(path, drawn).with_context(cannot)?;
    Ok(true)
}

fn drawn(name: &str, plot: &Plot) -> Result<String, DrawError> {
    let mut text = String::new();
    let size = match plot.up {
        None => curves::size(plot),
        Some(_) => maps::size(plot),
    };
    let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
    root.fill(&WHITE)?;
    match &plot.up {
        None => curves::draw(&root, name, plot)?,
        Some(up) => maps::draw(&root, name, plot, up)?,
    }
    root.present()?;
    drop(root);
    Ok(text)
}
