//! A sweep with its report: a table for a terminal, `plot.svg` and `report.html`.

mod outcome;
mod page;
mod svg;
#[cfg(test)]
mod tests;

use coaxle_lab::sweep::shown::ShownRows;
use coaxle_lab::sweep::{Options, Prepared, SweepProgress, SweepResult};
use comfy_table::{Cell, CellAlignment, Table, presets};

pub use outcome::Outcome;

/// Runs whatever the folder does not have yet, and leaves the results of all there, with plot and report, which has the command
/// that repeats it. `on_progress` hears how far it is, as [`Prepared::run`] says.
///
/// # Errors
/// What [`Prepared::run`] fails with; a file that cannot be written.
pub fn run(
    sweep: &Prepared,
    options: &Options,
    command: &str,
    on_progress: &(dyn Fn(&SweepProgress) -> bool + Sync),
) -> anyhow::Result<Outcome> {
    let SweepResult {
        runs,
        points,
        tables,
        shown,
        plots,
        folder,
    } = sweep.run(options, on_progress)?;
    let plot = folder.file("plot.svg");
    let plot = svg::write(&plot, sweep.scenario(), &plots)?.then_some(plot);
    let outcome = Outcome {
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

/// The figures of most interest, as a table for a terminal.
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
