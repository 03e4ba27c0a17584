//! The file, created or taken over by one node, opened by one drive process only.
//!
//! Node and drive process hold a lock each, which the system releases when they end, even by a crash.

use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::path::Path;

use coaxle_os::{Os, SharedLock, System};

use super::error::{Reason, SharedMemoryError};
use super::layout::{
    ACTUAL_PID, MAGIC, MAGIC_FIELD, NODE_PID, SIZE, SIZE_FIELD, VERSION, VERSION_FIELD,
};

/// Rights of a file that is taken over: read and write for its user and group, those with which it is created.
const MOST_RIGHTS: u32 = 0o660;

/// Creates the file of a node, or takes over the one left by an earlier node.
pub(super) fn create(path: &Path) -> Result<File, SharedMemoryError> {
    created(path).map_err(|reason| wrong(path, reason))
}

/// Opens the file of a running node, for a drive process.
pub(super) fn open(path: &Path) -> Result<File, SharedMemoryError> {
    opened(path).map_err(|reason| wrong(path, reason))
}

/// Removes the file if it is still this one.
pub(super) fn remove(path: &Path, file: &File) {
    if Os::is_at(path, file) {
        let _ = std::fs::remove_file(path);
    }
}

fn created(path: &Path) -> Result<File, Reason> {
    let file = open_file(path, true)?;
    if !Os::lock_shared_file(&file, SharedLock::Node).map_err(system("locked"))? {
        let pid = word(&file, NODE_PID.offset());
        return Err(Reason::UsedByNode { pid });
    }
    // A node that ended meanwhile has removed it, so a new one can be created.
    if !Os::is_at(path, &file) {
        return created(path);
    }
    check_mode(&file)?;
    match length(&file)? {
        // Without reserved space, a write to the mapping would end the process.
        0 => Os::reserve(&file, SIZE as u64).map_err(system("made"))?,
        length => check(&file, length)?,
    }
    Ok(file)
}

/// A file writable by others could hold any data about the drive, and one that they may read can be locked by them.
fn check_mode(file: &File) -> Result<(), Reason> {
    let received = Os::mode_of(file).map_err(system("looked at"))?;
    // `flock` asks for no right to write: any process that may open the file can hold the node's lock.
    if received & !MOST_RIGHTS == 0 {
        Ok(())
    } else {
        Err(Reason::Mode { received })
    }
}

fn opened(path: &Path) -> Result<File, Reason> {
    let file = match open_file(path, false) {
        Err(Reason::System { source, .. }) if source.kind() == ErrorKind::NotFound => {
            return Err(Reason::NoNode);
        }
        other => other?,
    };
    check(&file, length(&file)?)?;
    if Os::lock_shared_file(&file, SharedLock::DriveProcess).map_err(system("locked"))? {
        Ok(file)
    } else {
        let pid = word(&file, ACTUAL_PID.offset());
        Err(Reason::UsedByProcess { pid })
    }
}

fn open_file(path: &Path, make: bool) -> Result<File, Reason> {
    // The link itself is looked at: any user may put one into /dev/shm that leads to another file.
    let found = std::fs::symlink_metadata(path).ok();
    if let Some(received) = found.as_ref().and_then(Os::kind_of) {
        return Err(Reason::NoFile { received });
    }
    Os::open_shared_file(path, make).map_err(system("opened for reading and writing"))
}

/// Checks that the file is the memory of a drive, of this version.
fn check(file: &File, length: u64) -> Result<(), Reason> {
    // Version before length: files of another version differ in length as well, and the version says why.
    let magic = word(file, MAGIC_FIELD.offset());
    if magic != MAGIC {
        let bytes = magic.to_ne_bytes();
        let length = bytes
            // A file shorter than a word is quoted with its own bytes only.
            .len()
            .min(usize::try_from(length).unwrap_or(usize::MAX));
        let received = bytes[..length].escape_ascii().to_string();
        return Err(Reason::Magic { received });
    }
    let version = word(file, VERSION_FIELD.offset());
    if version != VERSION {
        return Err(Reason::Version {
            received: version,
            expected: VERSION,
        });
    }
    // Both lengths: that of the file, and the one its header claims. A shorter file would be mapped beyond its end.
    let said = word(file, SIZE_FIELD.offset());
    match [length, said].into_iter().find(|size| *size != SIZE as u64) {
        Some(received) => Err(Reason::Size {
            received,
            expected: SIZE as u64,
        }),
        None => Ok(()),
    }
}

fn length(file: &File) -> Result<u64, Reason> {
    Ok(file.metadata().map_err(system("looked at"))?.len())
}

/// Reads a word; 0 if the file is too short.
fn word(mut file: &File, offset: usize) -> u64 {
    use std::io::{Seek, SeekFrom};
    let mut bytes = [0; 8];
    let sought = file.seek(SeekFrom::Start(offset as u64));
    let _ = sought.and_then(|_| {
        let mut taken = 0;
        while taken < bytes.len() {
            // A read may return fewer bytes than asked for: the rest is read again.
            match file.read(&mut bytes[taken..])? {
                0 => break,
                more => taken += more,
            }
        }
        Ok(taken)
    });
    u64::from_ne_bytes(bytes)
}

fn system(what: &'static str) -> impl Fn(Error) -> Reason {
    move |source| Reason::System { what, source }
}

pub(super) fn wrong(path: &Path, reason: Reason) -> SharedMemoryError {
    SharedMemoryError {
        path: path.to_owned(),
        reason,
    }
}
