//! The archive of a unit, `.fmu`.

use std::io::{Cursor, Write as _};

use anyhow::Context;
use tempfile::TempDir;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::description::description;
use crate::resources::Resources;

/// Name of the library of all units.
pub const LIBRARY: &str = "libcoaxle_fmu.so";
/// Folder of libraries for this kind of PC in a unit.
pub const PLATFORM: &str = if cfg!(target_arch = "aarch64") {
    "aarch64-linux"
} else {
    "x86_64-linux"
};

/// A unit to be written.
#[derive(Debug)]
pub struct UnitPackage {
    bytes: Vec<u8>,
}

impl UnitPackage {
    /// A unit of resources that have been read from files in `folder`, with its library.
    ///
    /// # Errors
    /// Resources that are no unit: names the file, the field, the value received and the one expected. A unit of more than 4 GB.
    pub fn new(resources: &Resources, library: &[u8]) -> anyhow::Result<Self> {
        // In a folder with nothing else: a file that is named and not packed is missing now, and not with the user of the unit.
        let folder = unpacked(resources)?;
        let model = resources.model(folder.path());
        let model = model.context("the unit, with the packed files alone (--with packs more)")?;
        let (kind, token) = (resources.kind(), resources.token());
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let mut add = |name: &str, content: &[u8]| -> anyhow::Result<()> {
            // Stored as it is, with a date of its own: the same files are the same unit, to the byte.
            archive.start_file(name, SimpleFileOptions::default())?;
            Ok(archive.write_all(content)?)
        };
        let xml = description(&*model, kind, &token);
        add("modelDescription.xml", xml.as_bytes())?;
        let path = format!("binaries/{PLATFORM}/{}.so", kind.identifier());
        add(&path, library)?;
        for (name, text) in resources.all() {
            add(&format!("resources/{name}"), text.as_bytes())?;
        }
        let bytes = archive.finish()?.into_inner();
        Ok(Self { bytes })
    }

    /// Returns the bytes of the archive.
    #[must_use]
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

/// The files of a unit in a folder of their own, which ends with the handle.
fn unpacked(resources: &Resources) -> anyhow::Result<TempDir> {
    let folder = TempDir::new().context("cannot make a folder for the files of the unit")?;
    for (name, text) in resources.all() {
        let path = folder.path().join(name);
        let parent = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        let written = parent.and_then(|()| std::fs::write(&path, text));
        written.with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(folder)
}
