//! A file that is edited, and its text when it was last read or written.

use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use coaxle_node::text_file;

/// A file that may not be there yet.
pub(super) struct EditedFile {
    path: PathBuf,
    /// Absent as long as the file is.
    known: Option<String>,
    most: u64,
}

impl EditedFile {
    /// Reads the file, if there is one.
    ///
    /// # Errors
    /// The file exists and cannot be read.
    pub(super) fn open(path: &Path, most: u64) -> anyhow::Result<Self> {
        // A dangling link counts as there: reading it fails now, and not a save much later.
        let is_there = fs::symlink_metadata(path).is_ok();
        let known = is_there.then(|| text_file::read(path, most)).transpose()?;
        Ok(Self {
            path: path.to_owned(),
            known,
            most,
        })
    }

    pub(super) fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// The text as it was last read or written.
    pub(super) fn known(&self) -> Option<&str> {
        self.known.as_deref()
    }

    /// Writes a text, unless another program has written the file meanwhile.
    ///
    /// # Errors
    /// The reason why it is not written.
    pub(super) fn save(&mut self, text: &str) -> Result<(), String> {
        let name = self.name();
        // The next start would refuse to read it.
        if text.len() as u64 > self.most {
            let (received, most) = (text.len(), self.most);
            return Err(format!(
                "{name}: received {received} bytes, expected at most {most}"
            ));
        }
        match &self.known {
            None => self.create(text)?,
            Some(known) => {
                let now = text_file::read(&self.path, self.most);
                // The content decides, as times of files change by copying and differ in resolution.
                if now.map_err(|error| error.to_string())? != *known {
                    return Err(format!(
                        "{name}: somebody else has changed it since it was read; take a copy of your text and begin anew"
                    ));
                }
                self.replace(text)
                    .map_err(|error| format!("{name}: cannot be written: {error}"))?;
            }
        }
        // Only after a success: a failed save leaves the text unsaved.
        self.known = Some(text.to_owned());
        Ok(())
    }

    fn create(&self, text: &str) -> Result<(), String> {
        let name = self.name();
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&self.path);
        let written = file.and_then(|mut file| file.write_all(text.as_bytes()));
        written.map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => {
                format!(
                    "{name}: somebody else has made one of that name meanwhile; it stays as it is"
                )
            }
            _ => format!("{name}: cannot be written: {error}"),
        })
    }

    /// Replaces the file as a whole: half a text is another file.
    fn replace(&self, text: &str) -> std::io::Result<()> {
        // Through a link: renaming onto the link itself would replace the link.
        let path = fs::canonicalize(&self.path)?;
        let (mut file, new) = create_beside(&path)?;
        let written = (file.write_all(text.as_bytes()))
            // Renaming replaces the file together with its permissions.
            .and_then(|()| file.set_permissions(fs::metadata(&path)?.permissions()))
            // Before the rename: after a power cut the name could lead to an empty file.
            .and_then(|()| file.sync_all())
            .and_then(|()| fs::rename(&new, &path));
        if written.is_err() {
            // Otherwise the next attempt would find it there and fail.
            let _ = fs::remove_file(&new);
        }
        written
    }
}

/// Creates a file beside this one, as a rename does not cross file systems.
fn create_beside(path: &Path) -> std::io::Result<(File, PathBuf)> {
    // Counted up: a program that was killed between creation and rename left its file, and another designer may be about to rename its own.
    for number in 1_u64.. {
        let mut new = path.as_os_str().to_owned();
        new.push(format!(".{number}.new"));
        match File::create_new(&new) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            created => return created.map(|file| (file, new.into())),
        }
    }
    // Unreachable in practice: the numbers end after 1.8e19 files.
    Err(ErrorKind::AlreadyExists.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_a_killed_program_left_does_not_prevent_saving() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.toml");
        fs::write(&path, "a").unwrap();
        let left = ["x.toml.new", "x.toml.1.new", "x.toml.2.new"];
        for name in left {
            fs::write(folder.path().join(name), "left").unwrap();
        }
        let mut file = EditedFile::open(&path, 100).unwrap();
        file.save("b").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "b");
        // Those of others stay as they are, and its own is gone.
        for name in left {
            let text = fs::read_to_string(folder.path().join(name)).unwrap();
            assert_eq!(text, "left");
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    }
}
