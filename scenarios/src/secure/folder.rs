//! The folders of a secure network: the authority's, and one for each node and operator.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

use anyhow::Context;
use coaxle_host::credentials::{AUTHORITY_FILE, CERTIFICATE_FILE, KEY_FILE, PROFILE_FILE};

use super::authority::{Authority, Issued};

/// The authority's folder.
pub const AUTHORITY_FOLDER: &str = "authority";
/// The authority's key in it.
pub const AUTHORITY_KEY_FILE: &str = "ca.key";

/// For the owner alone, and for everybody.
const SECRET: u32 = 0o600;
const PUBLIC: u32 = 0o644;

/// Writes the authority's folder under `out`.
///
/// # Errors
/// Names the file that cannot be written.
pub fn write_authority(out: &Path, authority: &Authority) -> anyhow::Result<()> {
    let folder = out.join(AUTHORITY_FOLDER);
    make(&folder)?;
    write(
        &folder.join(AUTHORITY_FILE),
        authority.certificate(),
        PUBLIC,
    )?;
    write(&folder.join(AUTHORITY_KEY_FILE), &authority.key(), SECRET)
}

/// Reads the authority of the folder under `out`.
///
/// # Errors
/// Names the file that cannot be read, or what is wrong with it.
pub(super) fn read_authority(out: &Path) -> anyhow::Result<Authority> {
    let folder = out.join(AUTHORITY_FOLDER);
    let read = |file: &str| {
        let path = folder.join(file);
        let text = fs::read_to_string(&path);
        text.with_context(|| {
            format!(
                "{} cannot be read, expected what `coaxle secure init` wrote",
                path.display()
            )
        })
    };
    let (certificate, key) = (read(AUTHORITY_FILE)?, read(AUTHORITY_KEY_FILE)?);
    Authority::read(&certificate, &key).with_context(|| folder.display().to_string())
}

/// Writes the folder of a node or an operator: what it needs, and nothing of anybody else.
///
/// # Errors
/// Names the file that cannot be written.
pub fn write_role(
    folder: &Path,
    authority: &Authority,
    issued: &Issued,
    profile: &str,
) -> anyhow::Result<()> {
    make(folder)?;
    write(
        &folder.join(AUTHORITY_FILE),
        authority.certificate(),
        PUBLIC,
    )?;
    write(&folder.join(CERTIFICATE_FILE), &issued.certificate, PUBLIC)?;
    write(&folder.join(KEY_FILE), &issued.key, SECRET)?;
    write(&folder.join(PROFILE_FILE), profile, PUBLIC)
}

fn make(folder: &Path) -> anyhow::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true).mode(0o700);
    let made = builder.create(folder);
    made.with_context(|| format!("cannot make the folder {}", folder.display()))
}

/// Takes the place of an older file at once: a node that starts meanwhile reads the one or the other.
fn write(file: &Path, text: &str, mode: u32) -> anyhow::Result<()> {
    let new = file.with_extension("new");
    let written = (|| {
        let mut options = OpenOptions::new();
        let mut out = options
            .write(true)
            .create(true)
            .truncate(true)
            .mode(mode)
            .open(&new)?;
        // A file of that name that was there keeps its own mode otherwise.
        out.set_permissions(fs::Permissions::from_mode(mode))?;
        out.write_all(text.as_bytes())?;
        out.sync_all()?;
        fs::rename(&new, file)
    })();
    written.with_context(|| format!("cannot write {}", file.display()))
}
