//! Files that are written where none is yet.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::Path;

use anyhow::Context;
use coaxle_os::exit::wrong_argument;

/// Writes a file that is not there yet, or the text to standard output without one.
///
/// # Errors
/// Something has that name already, or it cannot be written.
pub(super) fn write(path: Option<&Path>, text: &str, out: &mut dyn Write) -> anyhow::Result<()> {
    let Some(path) = path else {
        return Ok(out.write_all(text.as_bytes())?);
    };
    let name = path.display();
    // `create_new` checks and creates in one step: no other program comes in between.
    match OpenOptions::new().write(true).create_new(true).open(path) {
        Ok(mut file) => file
            .write_all(text.as_bytes())
            .with_context(|| format!("cannot write {name}"))?,
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            return wrong_argument(format!(
                "{name}: received a file that is there already, expected a name that is not taken"
            ));
        }
        Err(error) => return Err(error).with_context(|| format!("cannot write {name}")),
    }
    Ok(writeln!(out, "written: {name}")?)
}
