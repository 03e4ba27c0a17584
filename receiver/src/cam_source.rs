//! Where a cam plate of a config comes from.

use std::path::{Path, PathBuf};

use coaxle_node::cam_file::{CamFile, CamFileError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where a cam plate comes from: a cam file, or the same written here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum CamSource {
    /// The file.
    File(PathBuf),
    /// What it would hold.
    Here(#[schemars(with = "CamFile")] toml::Table),
}

impl CamSource {
    pub(crate) fn relative_to(&mut self, folder: &Path) {
        if let Self::File(file) = self {
            *file = folder.join(&*file);
        }
    }

    /// Reads it.
    ///
    /// # Errors
    /// [`CamFileError`], as of a file of its own.
    pub(crate) fn read(&self) -> Result<CamFile, CamFileError> {
        match self {
            Self::File(file) => CamFile::load(file),
            Self::Here(table) => CamFile::from_table("here", Path::new(""), table.clone()),
        }
    }
}
