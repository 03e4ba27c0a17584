//! The folders of a secure network: the authority's, and one for each node and operator.

use std::fs;
use std::io::Write;
use std::path::Path;

use anyhow::Context;
use coaxle_host::network::credentials::{
    AUTHORITY_FILE, Authority, CERTIFICATE_FILE, Issued, KEY_FILE, OLD_TIMING_KEY_FILE,
    PROFILE_FILE, REVOKED_FILE, RevocationList, TIMING_KEYS_FILE,
};
use coaxle_node::beacon::{SECRET_LEN, TimingSecret};
use coaxle_os::exit::wrong_file;
use coaxle_os::{Os, Readers, System};

/// The authority's folder.
pub const AUTHORITY_FOLDER: &str = "authority";
/// The authority's key in it.
pub const AUTHORITY_KEY_FILE: &str = "ca.key";
/// The secret of the timing channels in it.
const TIMING_SECRET_FILE: &str = "timing.secret";

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

/// The secret from which the keys of all timing channels are derived: that of the authority's folder, which is drawn if
/// there is none as yet. It is in no other folder.
///
/// # Errors
/// Names the file that cannot be read or written, or the system gives no random bytes.
pub(super) fn timing_secret(out: &Path) -> anyhow::Result<TimingSecret> {
    let folder = out.join(AUTHORITY_FOLDER);
    let file = folder.join(TIMING_SECRET_FILE);
    // Kept by `renew`: nodes that are restarted one by one must understand the beacons of the others meanwhile.
    if file.exists() {
        let text = fs::read_to_string(&file);
        let text = text.with_context(|| format!("cannot read {}", file.display()))?;
        return TimingSecret::from_hex(&text).with_context(|| file.display().to_string());
    }
    let mut secret = [0; SECRET_LEN];
    // From the system: a generator with a seed could be repeated by an attacker.
    getrandom::fill(&mut secret).context("the system gives no random bytes")?;
    let secret = TimingSecret::new(secret);
    write(&file, &secret.to_hex(), Readers::Owner)?;
    // Every node had that one: keys derived from it would be no secret of two.
    remove_if_there(&folder.join(OLD_TIMING_KEY_FILE))?;
    Ok(secret)
}

/// Writes the keys of the timing channels of a node into its folder.
///
/// # Errors
/// Names the file that cannot be written or removed.
pub(super) fn write_timing_keys(folder: &Path, keys: &str) -> anyhow::Result<()> {
    write(&folder.join(TIMING_KEYS_FILE), keys, Readers::Owner)?;
    remove_if_there(&folder.join(OLD_TIMING_KEY_FILE))
}

fn remove_if_there(file: &Path) -> anyhow::Result<()> {
    match fs::remove_file(file) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("cannot remove {}", file.display()))
        }
        _ => Ok(()),
    }
}

/// The list of revoked certificates that the authority keeps; an empty one if nothing was revoked.
///
/// # Errors
/// Names the file that cannot be read, or is not a list of this authority.
pub(super) fn read_revoked(out: &Path) -> anyhow::Result<RevocationList> {
    let folder = out.join(AUTHORITY_FOLDER);
    let file = folder.join(REVOKED_FILE);
    if !file.exists() {
        return Ok(RevocationList::default());
    }
    let text = |file: &Path| {
        let text = fs::read_to_string(file);
        text.with_context(|| format!("cannot read {}", file.display()))
    };
    RevocationList::read_pem(&text(&file)?, &text(&folder.join(AUTHORITY_FILE))?)
        .or_else(|wrong| wrong_file(format!("{}: {wrong}", file.display())))
}

/// Writes the signed list into a folder, for its owner to copy.
///
/// # Errors
/// Names the file that cannot be written.
pub(super) fn write_revoked(folder: &Path, signed: &str) -> anyhow::Result<()> {
    write(&folder.join(REVOKED_FILE), signed, Readers::All)
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
