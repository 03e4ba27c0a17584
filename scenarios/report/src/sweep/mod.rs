//! A sweep with its report: a table for a terminal, `plot.svg` and `report.html`.

mod drawn;
mod outcome;
mod page;
#[cfg(test)]
mod tests;

use std::path::Path;
use std::{fs, io};

use anyhow::Context;
use coaxle_lab::sweep::shown::ShownRows;
use coaxle_lab::sweep::{Options, Prepared, SweepProgress, SweepResult};
use comfy_table::{Cell, CellAlignment, Table, presets};

use self::drawn::{SweepDrawing, drawn};
use crate::figure::{Figure, Maps};
use crate::print;

pub use outcome::SweepOutcome;

/// Executes the runs that the folder does not have yet, and writes the results of all there, with the plot and the report,
/// which has the command that repeats it. `on_progress` receives the progress, as [`Prepared::run`] says.
///
/// # Errors
/// Errors of [`Prepared::run`]; a file that cannot be written.
pub fn run(
    sweep: &Prepared,
    options: &Options,
    command: &str,
    on_progress: &(dyn Fn(&SweepProgress) -> bool + Sync),
) -> anyhow::Result<SweepOutcome> {
    let SweepResult {
        runs,
        points,
        tables,
        shown,
        plots,
        folder,
    } = sweep.run(options, on_progress)?;
    let plots: Vec<_> = (plots.iter().enumerate())
        .map(|(n, plot)| drawn(n, plot))
        .collect();
    let plot = folder.file("plot.svg");
    let plot = write_plot(&plot, sweep.scenario(), plots.first())?.then_some(plot);
    let outcome = SweepOutcome {
        table: table(&shown),
        runs,
        points,
        tables,
        plot,
        report: folder.file("report.html"),
    };
    page::write(sweep, &shown, &plots, &outcome, command)?;
    Ok(outcome)
}

/// Writes the first of the plots with the name of its scenario. Returns false, and writes no file, if there is none.
fn write_plot(path: &Path, name: &str, plot: Option<&SweepDrawing>) -> anyhow::Result<bool> {
    let cannot = || format!("cannot write {}", path.display());
    let text = match plot {
        Some(SweepDrawing::Curves(figure)) => {
            let mut figure = figure.clone();
            let title = format!("{name}: {}", figure.title);
            for panel in &mut figure.panels {
                panel.title.clone_from(&title);
                panel.quantity.clone_from(&figure.title);
            }
            print::svg(&Figure { title, ..figure })
        }
        Some(SweepDrawing::Maps(maps)) => {
            let left_out = match maps.left_out {
                0 => String::new(),
                more => format!("; {more} more maps are left out"),
            };
            let title = format!("{name}: {}{left_out}", maps.title);
            print::svg_of_maps(&Maps {
                title,
                ..maps.clone()
            })
        }
        None => {
            // The plot of an earlier grid in this folder would be taken for that of the present one.
            return match fs::remove_file(path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    Err(error).with_context(cannot)
                }
                _ => Ok(false),
            };
        }
    };
    fs::write(path, text).with_context(cannot)?;
    Ok(true)
}

/// Returns the figures of most interest, as a table for a terminal.
fn table(shown: &ShownRows) -> String {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN);
    table.set_header(&shown.header);
    for row in &shown.rows {
        let cells = row.iter().enumerate().map(|(n, text)| {
            let alignment = if n < shown.words {
                CellAlignment::Left
            } else {
                CellAlignment::Right
            };
            Cell::new(text).set_alignment(alignment)
        });
        table.add_row(cells);
    }
    table.trim_fmt()
}
