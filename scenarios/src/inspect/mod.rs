//! What commands share that look into a file: answers, names, numbers, tables and charts.

mod charts;
#[cfg(test)]
pub(crate) mod samples;
mod tables;
mod text;

use std::io::{self, Write};
use std::path::Path;

use anyhow::Context;

pub(crate) use charts::{Charts, Line, Sampled};
pub(crate) use tables::{cells, right, table};
pub(crate) use text::{QUANTITIES, name, shown};

/// Prints the answer that `run` writes and returns what it returns. A reader that has seen enough,
/// as `head` has, is no error.
///
/// # Errors
/// What `run` fails with; standard output that cannot be written.
pub(crate) fn print(
    run: impl FnOnce(&mut dyn Write) -> anyhow::Result<bool>,
) -> anyhow::Result<bool> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    let done = run(&mut out).and_then(|good| {
        out.flush()?;
        Ok(good)
    });
    match done {
        Err(error) if is_broken_pipe(&error) => Ok(true),
        done => done,
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<io::Error>()
        .is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// Writes a plot and says where it is.
///
/// # Errors
/// A page that cannot be written.
pub(crate) fn write_plot(path: &Path, page: &str, out: &mut dyn Write) -> anyhow::Result<()> {
    std::fs::write(path, page).with_context(|| format!("cannot write {}", path.display()))?;
    writeln!(out, "plot: {}", path.display())?;
    Ok(())
}
