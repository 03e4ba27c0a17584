//! A folder for results, which one run at a time writes to.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use coaxle_os::{HeldFolder, Os, System};

/// The folder, held until this is dropped.
#[derive(Debug)]
pub struct ResultsFolder {
    path: PathBuf,
    _held: HeldFolder,
}

impl ResultsFolder {
    /// Makes the folder if it is not there, and holds it.
    ///
    /// # Errors
    /// Names the folder that cannot be made, or that another run writes to.
    pub fn hold(path: &Path) -> anyhow::Result<Self> {
        let cannot = || format!("cannot make the folder {}", path.display());
        fs::create_dir_all(path).with_context(cannot)?;
        // Made before, as only a folder that is there can be held.
        let Some(held) = Os::hold_folder(path).with_context(cannot)? else {
            bail!(
                "received the folder {} for the results, which another run writes to; expected one of its own: --out DIR",
                path.display()
            )
        };
        Ok(Self {
            path: path.to_owned(),
            _held: held,
        })
    }

    /// A file in it.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_run_at_a_time_writes_to_a_folder() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("out/run");
        let first = ResultsFolder::hold(&path).unwrap();
        let refused = ResultsFolder::hold(&path).unwrap_err().to_string();
        assert!(
            refused.contains("another run") && refused.contains("out/run"),
            "{refused}"
        );
        drop(first);
        let second = ResultsFolder::hold(&path).unwrap();
        assert_eq!(second.file("a"), path.join("a"));
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let scratch = tempfile::tempdir().unwrap();
        let file = scratch.path().join("file");
        fs::write(&file, "").unwrap();
        let refused = format!("{:#}", ResultsFolder::hold(&file.join("x")).unwrap_err());
        assert!(refused.contains("file/x"), "{refused}");
    }
}
