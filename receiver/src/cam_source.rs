//! Sources of the cam plates in a config.

use std::path::{Path, PathBuf};

use coaxle_files::cam::{CamFile, CamFileError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Source of a cam plate: a cam file, or its contents written here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum CamSource {
    /// The file.
    File(PathBuf),
    /// Contents of a cam file.
    Here(#[schemars(with = "CamFile")] toml::Table),
}

impl CamSource {
    /// Resolves the relative paths of its files from `folder`, for example the config's own.
    pub(crate) fn relative_to(&mut self, folder: &Path) {
        match self {
            Self::File(file) => *file = folder.join(&*file),
            Self::Here(table) => CamFile::resolve_files(table, folder),
        }
    }

    /// Reads the cam file or its contents.
    ///
    /// # Errors
    /// [`CamFileError`], as for a separate file.
    pub(crate) fn read(&self) -> Result<CamFile, CamFileError> {
        match self {
            Self::File(file) => CamFile::load(file),
            Self::Here(table) => CamFile::from_table("here", Path::new(""), table.clone()),
        }
    }
}
