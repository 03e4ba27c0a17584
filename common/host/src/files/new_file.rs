//! Creation of new files without overwriting existing recordings.

use std::fs::File;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Creates a file that does not exist yet. A device or a pipe holds no data that could be lost and
/// is opened as it is.
///
/// # Errors
/// [`ErrorKind::AlreadyExists`] if the file exists, or the system's error.
pub fn create_new(path: &Path) -> io::Result<File> {
    // The system's own exclusive creation: a check beforehand would leave a gap for another process.
    match File::create_new(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists && holds_nothing(path) => {
            // A device and a pipe exist before the run, and must be opened as they are.
            File::create(path)
        }
        created => created,
    }
}

/// Creates the file, or the next free one of its name: for `saw.mcap` this is `saw-2.mcap`,
/// `saw-3.mcap`, … Returns the file and its path.
///
/// # Errors
/// The system's error.
pub fn create_next(path: &Path) -> io::Result<(File, PathBuf)> {
    let mut next = path.to_owned();
    for number in 2_u64.. {
        match create_new(&next) {
            // A folder of that name exists too, but counting up would never say so: its error is reported.
            Err(error) if error.kind() == ErrorKind::AlreadyExists && next.is_file() => {
                // Counted from the asked path: counting from the last try would give saw-2-3.mcap.
                next = numbered(path, number);
            }
            created => return created.map(|file| (file, next)),
        }
    }
    // Unreachable in practice: the numbers end after 1.8e19 files.
    Err(ErrorKind::AlreadyExists.into())
}

fn numbered(path: &Path, number: u64) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number}"));
    if let Some(ending) = path.extension() {
        name.push(".");
        name.push(ending);
    }
    path.with_file_name(name)
}

fn holds_nothing(path: &Path) -> bool {
    path.metadata()
        .is_ok_and(|found| !found.is_file() && !found.is_dir())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_stays_and_the_next_one_has_a_number() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("saw.mcap");
        for name in ["saw.mcap", "saw-2.mcap", "saw-3.mcap"] {
            let (_, created) = create_next(&path).unwrap();
            assert_eq!(created, folder.path().join(name));
            std::fs::write(created, name).unwrap();
        }
        let first = std::fs::read_to_string(&path).unwrap();
        assert_eq!(first, "saw.mcap");
        let refused = create_new(&path).unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::AlreadyExists);
    }

    #[test]
    fn a_device_is_written_as_it_is_and_a_folder_is_none() {
        create_new(Path::new("/dev/null")).unwrap();
        let (_, created) = create_next(Path::new("/dev/null")).unwrap();
        assert_eq!(created, Path::new("/dev/null"));
        let folder = tempfile::tempdir().unwrap();
        create_next(folder.path()).unwrap_err();
    }
}
