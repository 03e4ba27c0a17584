//! The archive of a unit, `.fmu`.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use anyhow::Context;

use crate::archive::Archive;
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
    archive: Archive,
}

impl UnitPackage {
    /// A unit of resources that have been read from files in `folder`, with its library.
    ///
    /// # Errors
    /// Resources that are no unit: names the file, the field, the value received and the one expected.
    pub fn new(resources: &Resources, library: &[u8]) -> anyhow::Result<Self> {
        // In a folder with nothing else: a file that is named and not packed is missing now, and not with the user of the unit.
        let folder = ScratchFolder::with(resources)?;
        let model = resources.model(&folder.0);
        let model = model.context("the unit, with the packed files alone (--with packs more)")?;
        let (kind, token) = (resources.kind(), resources.token());
        let mut archive = Archive::default();
        let xml = description(&*model, kind, &token);
        archive.add("modelDescription.xml", xml.as_bytes())?;
        let path = format!("binaries/{PLATFORM}/{}.so", kind.identifier());
        archive.add(&path, library)?;
        for (name, text) in resources.all() {
            archive.add(&format!("resources/{name}"), text.as_bytes())?;
        }
        Ok(Self { archive })
    }

    /// Returns the bytes of the archive.
    ///
    /// # Errors
    /// More than 4 GB.
    pub fn into_bytes(self) -> io::Result<Vec<u8>> {
        self.archive.finish()
    }
}

/// A folder of its own for the files of a unit, which ends with it.
struct ScratchFolder(PathBuf);

impl ScratchFolder {
    fn with(resources: &Resources) -> anyhow::Result<Self> {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("coaxle-unit-{}-{number}", std::process::id());
        let folder = Self(std::env::temp_dir().join(name));
        for (name, text) in resources.all() {
            let path = folder.0.join(name);
            write(&path, &text).with_context(|| format!("cannot write {}", path.display()))?;
        }
        Ok(folder)
    }
}

impl Drop for ScratchFolder {
    fn drop(&mut self) {
        // A folder that stays does no harm.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn write(path: &Path, text: &str) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(path, text)
}
