//! Reading a file named by a user: a regular one, of limited size.
//!
//! All files named to a node or the tool are read here, so that an endless device, a pipe without a
//! writer or a file of gigabytes neither takes all memory nor hangs.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use coaxle_wire::one_line;

use crate::guess::most_similar;

/// Greatest size of a config, a scenario or a saw file, bytes.
pub const MOST_CONFIG_BYTES: u64 = 1 << 20;

/// Greatest length of a line of a table, bytes.
pub const MOST_LINE_BYTES: usize = 4096;

/// A file that was not read, and the reason.
#[derive(Debug, thiserror::Error)]
#[error("{file}: cannot be read: {reason}{hint}")]
pub struct Unreadable {
    file: String,
    reason: Reason,
    /// Suggested name, or the missing folder.
    hint: String,
}

#[derive(Debug, thiserror::Error)]
enum Reason {
    #[error(transparent)]
    System(#[from] io::Error),
    #[error("received {received}, expected a file")]
    NoFile { received: &'static str },
    #[error("received {received} bytes, expected at most {most}")]
    TooLong { received: String, most: u64 },
    #[error("line {line}: received bytes that are no UTF-8, expected UTF-8 text")]
    NoText { line: usize },
    #[error(transparent)]
    LongLine(#[from] LongLine),
}

/// A line that is too long for a table.
#[derive(Debug, thiserror::Error)]
#[error(
    "line {line}: received more than {MOST_LINE_BYTES} bytes, expected at most that many in a line"
)]
struct LongLine {
    line: usize,
}

/// Remedy for a file that the system refuses, to be appended to its reason; empty where none is needed.
#[must_use]
pub fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "; expected one that this user may use"
        }
        // For a missing file to read, [`Unreadable`] has a more specific hint.
        io::ErrorKind::NotFound => "; is its folder there?",
        io::ErrorKind::AlreadyExists => "; expected a name that is not taken",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "; make room there, or name a place on another disk"
        }
        io::ErrorKind::AddrNotAvailable => "; expected an address of this PC",
        io::ErrorKind::AddrInUse => "; another program has that port: name another one",
        _ => "",
    }
}

/// Reads a text of at most `most` bytes.
///
/// # Errors
/// [`Unreadable`] if the file does not exist, is not regular, is longer, or is not UTF-8 text.
pub fn read(path: &Path, most: u64) -> Result<String, Unreadable> {
    let text = open_regular(path).and_then(|file| text_of(file, most));
    text.map_err(|reason| unreadable(path, reason))
}

/// Reads a table of at most `most` bytes, with lines of at most [`MOST_LINE_BYTES`].
///
/// # Errors
/// [`Unreadable`], as in [`read`], or with the number of the line.
pub fn read_table(path: &Path, most: u64) -> Result<String, Unreadable> {
    let text = read(path, most)?;
    // After reading: the bound of the file holds for the memory, that of lines for parsers.
    let long = (1..).zip(text.lines());
    // Without the end of the line.
    let long = long.filter(|(_, line)| line.len() > MOST_LINE_BYTES);
    match long.map(|(line, _)| line).next() {
        Some(line) => Err(unreadable(path, LongLine { line }.into())),
        None => Ok(text),
    }
}

/// Opens a file of at most `most` bytes, to read it bit by bit.
///
/// # Errors
/// [`Unreadable`] if the file does not exist, is not regular, or is longer.
pub fn open(path: &Path, most: u64) -> Result<File, Unreadable> {
    let opened = open_regular(path).and_then(|file| {
        check_length(&file, most)?;
        Ok(file)
    });
    opened.map_err(|reason| unreadable(path, reason))
}

/// Reader that fails when a line is longer than [`MOST_LINE_BYTES`]: a reader of a table row by row
/// keeps one row in memory.
#[derive(Debug)]
pub struct ShortLines<R> {
    inner: R,
    /// Number of the current line, from 1, and its length until now, bytes.
    line: usize,
    length: usize,
}

impl<R> ShortLines<R> {
    /// Starts at the beginning of a file.
    pub const fn new(inner: R) -> Self {
        Self {
            inner,
            line: 1,
            length: 0,
        }
    }
}

impl<R: Read> Read for ShortLines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        // Checked as the bytes pass: a reader row by row would collect a line without an end.
        let count = self.inner.read(buffer)?;
        for byte in &buffer[..count] {
            if *byte == b'\n' {
                self.line += 1;
                self.length = 0;
            } else {
                self.length += 1;
            }
            if self.length > MOST_LINE_BYTES {
                let line = self.line;
                return Err(io::Error::new(
                    io::ErrorKind::InvalidData,
                    LongLine { line },
                ));
            }
        }
        Ok(count)
    }
}

fn unreadable(path: &Path, reason: Reason) -> Unreadable {
    let file = one_line(&path.display().to_string());
    let hint = match &reason {
        Reason::System(error) if error.kind() == io::ErrorKind::NotFound => instead_of(path),
        Reason::System(error) => remedy(error).to_owned(),
        _ => String::new(),
    };
    Unreadable { file, reason, hint }
}

/// Greatest number of files in a folder that are compared.
const MOST_NEIGHBOURS: usize = 10_000;

/// Hint for a missing file: a neighbour with a similar name, or a missing folder.
fn instead_of(path: &Path) -> String {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let Ok(entries) = std::fs::read_dir(folder) else {
        return match folder.exists() {
            true => String::new(),
            false => one_line(&format!("; there is no folder {}", folder.display())),
        };
    };
    // A file of the same kind only: a CSV is not meant by a TOML.
    let ending = path.extension();
    // A folder of millions of files would take longer than the error is worth.
    let entries = entries.take(MOST_NEIGHBOURS).flatten();
    let names = entries.map(|entry| PathBuf::from(entry.file_name()));
    let names = names.filter(|name| name.extension() == ending);
    let mut stems: Vec<_> = names.map(|name| stem_of(&name)).collect();
    // The order of a folder is that of the file system.
    stems.sort();
    let Some(meant) = most_similar(&stem_of(path), stems.iter().map(String::as_str)) else {
        return String::new();
    };
    // With the path as it was given, so that it can be copied.
    let mut meant = path.with_file_name(meant);
    if let Some(ending) = ending {
        meant.as_mut_os_string().push(".");
        meant.as_mut_os_string().push(ending);
    }
    one_line(&format!("; did you mean {}?", meant.display()))
}

fn stem_of(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

fn open_regular(path: &Path) -> Result<File, Reason> {
    // Opening a pipe would wait for a writer.
    // The kind of the target: a link to a regular file is one.
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_file() {
        return Ok(File::open(path)?);
    }
    let received = if kind.is_dir() {
        "a folder"
    } else {
        "a device, pipe or socket"
    };
    Err(Reason::NoFile { received })
}

fn check_length(file: &File, most: u64) -> Result<(), Reason> {
    let length = file.metadata()?.len();
    if length <= most {
        return Ok(());
    }
    let received = length.to_string();
    Err(Reason::TooLong { received, most })
}

fn text_of(file: File, most: u64) -> Result<String, Reason> {
    check_length(&file, most)?;
    // Some system files have no length, and other files grow.
    let mut bytes = Vec::new();
    // A byte more than allowed, which shows that there is more.
    file.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let received = format!("more than {most}");
        return Err(Reason::TooLong { received, most });
    }
    String::from_utf8(bytes).map_err(|error| {
        // Up to the first wrong byte: its line is the one after these breaks.
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
        Reason::NoText { line }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(path: &Path, most: u64) -> String {
        read(path, most).unwrap_err().to_string()
    }

    #[test]
    fn a_text_of_the_most_bytes_is_read_and_a_longer_one_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.toml");
        std::fs::write(&path, "title = 'é'").unwrap();
        // `é` has two bytes.
        assert_eq!(read(&path, 12).unwrap(), "title = 'é'");
        assert_eq!(
            refusal(&path, 11),
            format!(
                "{}: cannot be read: received 12 bytes, expected at most 11",
                path.display()
            )
        );
    }

    #[test]
    fn a_file_that_does_not_say_its_length_is_bounded_all_the_same() {
        // A file of /proc says 0 bytes.
        assert_eq!(
            refusal(Path::new("/proc/self/status"), 10),
            "/proc/self/status: cannot be read: received more than 10 bytes, expected at most 10"
        );
    }

    #[test]
    fn what_is_no_regular_file_is_named_and_not_opened() {
        for (path, received) in [
            ("/", "a folder"),
            ("/dev/zero", "a device, pipe or socket"),
            ("/dev/null", "a device, pipe or socket"),
        ] {
            let expected = format!("{path}: cannot be read: received {received}, expected a file");
            assert_eq!(refusal(Path::new(path), 10), expected);
            let opened = open(Path::new(path), 10);
            assert_eq!(opened.unwrap_err().to_string(), expected);
        }
        let message = refusal(Path::new("no/such.toml"), 10);
        assert!(
            message.starts_with("no/such.toml: cannot be read: "),
            "{message}"
        );
    }

    #[test]
    fn a_file_that_is_not_there_is_told_with_its_neighbour_or_that_its_folder_is_not() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["conveyor.toml", "conveier.csv", "x.toml"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let message = refusal(&folder.path().join("conveier.toml"), 10);
        let meant = folder.path().join("conveyor.toml");
        let expected = format!("; did you mean {}?", meant.display());
        assert!(message.ends_with(&expected), "{message}");
        let message = refusal(&folder.path().join("press.toml"), 10);
        assert!(!message.contains(';'), "{message}");
        let message = refusal(Path::new("no/such.toml"), 10);
        assert!(message.ends_with("; there is no folder no"), "{message}");
    }

    #[test]
    fn a_line_without_end_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        // Just as long as allowed, and two more.
        let fits = format!("x;y\n{}\n", "1".repeat(MOST_LINE_BYTES));
        let long = format!("x;y\n1;{}\n", "1".repeat(MOST_LINE_BYTES));
        std::fs::write(&path, &fits).unwrap();
        assert_eq!(read_table(&path, 10_000).unwrap(), fits);
        std::fs::write(&path, &long).unwrap();
        let message = read_table(&path, 10_000).unwrap_err().to_string();
        assert!(
            message.contains("line 2: received more than 4096 bytes, expected"),
            "{message}"
        );

        let mut read = String::new();
        ShortLines::new(fits.as_bytes())
            .read_to_string(&mut read)
            .unwrap();
        assert_eq!(read, fits);
        let refused = ShortLines::new(long.as_bytes()).read_to_string(&mut read);
        let refused = refused.unwrap_err().to_string();
        assert!(message.ends_with(&refused), "{refused}");
    }

    #[test]
    fn bytes_that_are_no_text_are_named_by_their_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, b"x;y\n0;0\n1;\xb0\n").unwrap();
        let message = refusal(&path, 100);
        assert!(
            message.contains("line 3: received bytes that are no UTF-8"),
            "{message}"
        );
    }
}
