//! Parts shared by commands that look into a file: answers, names, numbers, tables and charts.

mod charts;
mod tables;
mod text;

use std::io::{self, Read, Write};
use std::path::Path;

use anyhow::Context;
use coaxle_os::exit::wrong_argument;

pub use charts::{Charts, LevelLine, Sampled};
pub use tables::{cells, right, table};
pub use text::{QUANTITIES, name, shown, shown_to};

/// Prints the answer that `run` writes and returns what it returns. A reader that has seen enough,
/// as `head` has, is no error.
///
/// # Errors
/// Errors of `run`; standard output that cannot be written.
pub fn print(run: impl FnOnce(&mut dyn Write) -> anyhow::Result<bool>) -> anyhow::Result<bool> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    let done = run(&mut out).and_then(|good| {
        // A buffer that is dropped flushes too, but swallows the error of a full disk.
        out.flush()?;
        Ok(good)
    });
    match done {
        // Rust ignores SIGPIPE, so a reader that has left is an error of writing.
        Err(error) if is_broken_pipe(&error) => Ok(true),
        done => done,
    }
}

/// Prints a text and the end of its line.
///
/// # Errors
/// Standard output cannot be written.
pub fn print_text(text: &str) -> anyhow::Result<()> {
    let printed = print(|out| {
        writeln!(out, "{text}")?;
        Ok(true)
    });
    printed
        .map(|_| ())
        .context("cannot write to standard output")
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<io::Error>()
        .is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// Writes a plot and reports its path. Refuses to replace a file that is no page, such as the file that is drawn.
///
/// # Errors
/// A page that cannot be written, or would take the place of something else.
pub fn write_plot(path: &Path, page: &str, out: &mut dyn Write) -> anyhow::Result<()> {
    if is_something_else(path) {
        return wrong_argument(format!(
            "{}: received a file that is no page, expected one of before, or a name that is not taken",
            path.display()
        ));
    }
    std::fs::write(path, page).with_context(|| format!("cannot write {}", path.display()))?;
    writeln!(out, "plot: {}", path.display())?;
    Ok(())
}

/// Reports whether a file is there that is no page, and not empty.
fn is_something_else(path: &Path) -> bool {
    const PAGE: &[u8] = b"<!doctype html";
    let mut begin = [0; PAGE.len()];
    let Ok(mut file) = std::fs::File::open(path) else {
        return false;
    };
    // A path that cannot be read, such as a folder, cannot be written either; that error says more.
    match file.read(&mut begin) {
        Ok(0) | Err(_) => false,
        // A short file is compared as far as it goes.
        Ok(read) => !begin[..read].eq_ignore_ascii_case(&PAGE[..read]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plot_takes_the_place_of_a_plot_and_of_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plot.html");
        for _ in 0..2 {
            write_plot(&path, "<!DOCTYPE html>\n<html>", &mut Vec::new()).unwrap();
        }
        let cam = folder.path().join("cam.toml");
        std::fs::write(&cam, "title = 'a cam'").unwrap();
        let refused = write_plot(&cam, "<!DOCTYPE html>", &mut Vec::new());
        let refused = format!("{:#}", refused.unwrap_err());
        assert!(
            refused.contains("cam.toml") && refused.contains("no page"),
            "{refused}"
        );
        assert_eq!(std::fs::read_to_string(&cam).unwrap(), "title = 'a cam'");
    }
}
