//! The folders of a secure network: the authority's, and one for each node and operator.

use std::fs;
use std::io::Write;
use std::path::Path;

use anyhow::Context;
use coaxle_host::network::credentials::{
    AUTHORITY_FILE, Authority, CERTIFICATE_FILE, Issued, KEY_FILE, PROFILE_FILE, TIMING_KEY_FILE,
};
use coaxle_node::beacon::{BeaconSecret, SECRET_LEN};
use coaxle_os::exit::wrong_file;
use coaxle_os::{Os, Readers, System};

/// The authority's folder.
pub const AUTHORITY_FOLDER: &str = "authority";
/// The authority's key in it.
pub const AUTHORITY_KEY_FILE: &str = "ca.key";

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
        Readers::All,
    )?;
    write(
        &folder.join(AUTHORITY_KEY_FILE),
        &authority.key(),
        Readers::Owner,
    )
}

/// The secret that the beacons of all nodes are authenticated by, as its file has it: that of the authority's folder, which is
/// drawn if there is none as yet.
///
/// # Errors
/// Names the file that cannot be read or written, or the system gives no random bytes.
pub(super) fn timing_key(out: &Path) -> anyhow::Result<String> {
    let file = out.join(AUTHORITY_FOLDER).join(TIMING_KEY_FILE);
    // Kept by `renew`: nodes that are restarted one by one must understand the beacons of the others meanwhile.
    if file.exists() {
        let text = fs::read_to_string(&file);
        let text = text.with_context(|| format!("cannot read {}", file.display()))?;
        // Read here, so that a damaged file is noticed before it is copied to every node.
        BeaconSecret::from_hex(&text).with_context(|| file.display().to_string())?;
        return Ok(text);
    }
    let mut secret = [0; SECRET_LEN];
    // From the system: a generator with a seed could be repeated by an attacker.
    getrandom::fill(&mut secret).context("the system gives no random bytes")?;
    let digits: String = secret.iter().map(|byte| format!("{byte:02x}")).collect();
    let text = digits + "\n";
    write(&file, &text, Readers::Owner)?;
    Ok(text)
}

/// Writes that secret into the folder of a node.
///
/// # Errors
/// Names the file that cannot be written.
pub(super) fn write_timing_key(folder: &Path, key: &str) -> anyhow::Result<()> {
    write(&folder.join(TIMING_KEY_FILE), key, Readers::Owner)
}

/// Reads the authority of the folder under `out`.
///
/// # Errors
/// Names the file that cannot be read, or what is wrong with it.
pub(super) fn read_authority(out: &Path) -> anyhow::Result<Authority> {
    let folder = out.join(AUTHORITY_FOLDER);
    let read = |file: &str| {
        let path = folder.join(file);
        fs::read_to_string(&path).or_else(|why| {
            wrong_file(format!(
                "{} cannot be read ({why}), expected what `coaxle secure init` wrote",
                path.display()
            ))
        })
    };
    let (certificate, key) = (read(AUTHORITY_FILE)?, read(AUTHORITY_KEY_FILE)?);
    Authority::read(&certificate, &key)
        .or_else(|wrong| wrong_file(format!("{}: {wrong:#}", folder.display())))
}

/// Writes the folder of a node or an operator: its own files, and no one else's.
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
        Readers::All,
    )?;
    write(
        &folder.join(CERTIFICATE_FILE),
        &issued.certificate,
        Readers::All,
    )?;
    write(&folder.join(KEY_FILE), &issued.key, Readers::Owner)?;
    // Rights are no secret: only writing them must be denied to others.
    write(&folder.join(PROFILE_FILE), profile, Readers::All)
}

fn make(folder: &Path) -> anyhow::Result<()> {
    Os::make_private_folder(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))
}

/// Takes the place of an older file at once: a node that starts meanwhile reads the one or the other.
fn write(file: &Path, text: &str, readers: Readers) -> anyhow::Result<()> {
    // In the same folder, because a rename does not cross file systems.
    let new = file.with_extension("new");
    let written = (|| {
        // With its permissions from the start: a new key is not readable by others even for a moment.
        let mut out = Os::create_file(&new, readers)?;
        out.write_all(text.as_bytes())?;
        // Before the rename: after a power cut the name could lead to an empty key.
        out.sync_all()?;
        fs::rename(&new, file)
    })();
    written.with_context(|| format!("cannot write {}", file.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_host::network::credentials::{Credentials, CredentialsFault, Validity};
    use coaxle_node::keys::NodeName;
    use coaxle_os::machine;

    #[test]
    fn what_it_signs_is_believed_by_those_who_believe_it() {
        let now = machine::wall_clock();
        let year = Validity::days(now, 365);
        let (ours, theirs) = (Authority::new(year).unwrap(), Authority::new(year).unwrap());
        let again = Authority::read(ours.certificate(), &ours.key()).unwrap();
        let saw = NodeName::new("saw").unwrap();
        let scratch = tempfile::tempdir().unwrap();
        for (by, beside, expected) in [
            (&ours, &ours, Ok(())),
            (&again, &ours, Ok(())),
            (&theirs, &ours, Err(CredentialsFault::OtherAuthority)),
        ] {
            let hosts = ["10.0.0.1".to_owned(), "saw.local".to_owned()];
            let issued = by.issue(&saw, &hosts, year).unwrap();
            write_role(scratch.path(), beside, &issued, "{}").unwrap();
            let credentials = Credentials::open(scratch.path()).unwrap();
            assert_eq!(*credentials.name(), saw);
            assert_eq!(credentials.check(now), expected);
        }
        assert!(Authority::read("nothing", &ours.key()).is_err());
        let wrong = ours.issue(&saw, &["ä".to_owned()], year).err().unwrap();
        assert!(wrong.to_string().contains("\"ä\""), "{wrong}");
    }
}
