//! The file: made or taken over by one node, opened by one drive process, and by nobody else.
//!
//! A node holds a `flock` on it, a drive process a record lock (`lockf`): neither is in the way of the other,
//! and the system drops them when their process ends, however it does.

use std::fs::{File, OpenOptions};
use std::io::{Error, ErrorKind, Read};
use std::os::unix::fs::{FileTypeExt, MetadataExt, OpenOptionsExt};
use std::path::Path;

use rustix::fs::{
    FallocateFlags, FlockOperation, OFlags, fallocate, fcntl_lock, flock, fstat, stat,
};
use rustix::io::Errno;

use super::error::{Reason, SharedMemoryError};
use super::layout::{MAGIC, MAGIC_FIELD, NODE_PID, SIZE, SIZE_FIELD, VERSION, VERSION_FIELD};

/// Read and write for its user and group, nothing for others.
const MODE: u32 = 0o660;

/// The file of a node: a new one, or the one that a node before left behind.
pub(super) fn create(path: &Path) -> Result<File, SharedMemoryError> {
    created(path).map_err(|reason| wrong(path, reason))
}

/// The file of a running node, for a drive process.
pub(super) fn open(path: &Path) -> Result<File, SharedMemoryError> {
    opened(path).map_err(|reason| wrong(path, reason))
}

/// Removes the file if it is still this one.
pub(super) fn remove(path: &Path, file: &File) {
    if is_at(path, file) {
        let _ = std::fs::remove_file(path);
    }
}

/// Whether this file is the one that is found there.
fn is_at(path: &Path, file: &File) -> bool {
    let (Ok(own), Ok(there)) = (fstat(file), stat(path)) else {
        return false;
    };
    (own.st_dev, own.st_ino) == (there.st_dev, there.st_ino)
}

/// Whether the file is on a disk, where the system can hold up whoever writes to it.
pub(super) fn is_on_disk(file: &File) -> bool {
    const TMPFS: u64 = 0x0102_1994;
    const RAMFS: u64 = 0x8584_58f6;
    const HUGETLBFS: u64 = 0x9584_58f6;
    rustix::fs::fstatfs(file).is_ok_and(|system| {
        let kind = system.f_type as u64 & 0xffff_ffff;
        ![TMPFS, RAMFS, HUGETLBFS].contains(&kind)
    })
}

fn created(path: &Path) -> Result<File, Reason> {
    let file = open_with(path, OpenOptions::new().create(true).mode(MODE))?;
    match flock(&file, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => {}
        Err(Errno::WOULDBLOCK) => {
            let pid = word(&file, NODE_PID.offset());
            return Err(Reason::UsedByNode { pid });
        }
        Err(errno) => return Err(system("locked")(errno.into())),
    }
    // A node that ended meanwhile has removed it: then there is room for a new one.
    if !is_at(path, &file) {
        return created(path);
    }
    check_mode(&file)?;
    match length(&file)? {
        0 => make_room(&file)?,
        length => check(&file, length)?,
    }
    Ok(file)
}

/// Without the room, a write to the mapping would end the process.
fn make_room(file: &File) -> Result<(), Reason> {
    file.set_len(SIZE as u64).map_err(system("made"))?;
    match fallocate(file, FallocateFlags::empty(), 0, SIZE as u64) {
        Ok(()) | Err(Errno::OPNOTSUPP) => Ok(()),
        Err(errno) => Err(system("made")(errno.into())),
    }
}

/// What everybody may write to could say anything about the drive.
fn check_mode(file: &File) -> Result<(), Reason> {
    let received = file.metadata().map_err(system("looked at"))?.mode() & 0o777;
    if received & 0o002 == 0 {
        Ok(())
    } else {
        Err(Reason::Mode { received })
    }
}

fn opened(path: &Path) -> Result<File, Reason> {
    let file = match open_with(path, &mut OpenOptions::new()) {
        Err(Reason::System { source, .. }) if source.kind() == ErrorKind::NotFound => {
            return Err(Reason::NoNode);
        }
        other => other?,
    };
    check(&file, length(&file)?)?;
    match fcntl_lock(&file, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => Ok(file),
        Err(Errno::WOULDBLOCK | Errno::ACCESS) => {
            let pid = word(&file, super::layout::ACTUAL_PID.offset());
            Err(Reason::UsedByProcess { pid })
        }
        Err(errno) => Err(system("locked")(errno.into())),
    }
}

fn open_with(path: &Path, options: &mut OpenOptions) -> Result<File, Reason> {
    let is_no_file = match std::fs::symlink_metadata(path) {
        Ok(found) if found.is_dir() => Some("a folder"),
        Ok(found) if found.is_symlink() => Some("a link"),
        Ok(found) if found.file_type().is_socket() => Some("a socket"),
        Ok(found) if found.file_type().is_fifo() => Some("a pipe"),
        Ok(found) if !found.is_file() => Some("a device"),
        Ok(_) | Err(_) => None,
    };
    if let Some(received) = is_no_file {
        return Err(Reason::NoFile { received });
    }
    let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    (options.read(true).write(true))
        .custom_flags(flags.bits() as i32)
        .open(path)
        .map_err(system("opened for reading and writing"))
}

/// That it is the memory of a drive, of this version.
fn check(file: &File, length: u64) -> Result<(), Reason> {
    let magic = word(file, MAGIC_FIELD.offset());
    if magic != MAGIC {
        let bytes = magic.to_ne_bytes();
        let length = bytes
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
    Ok(file.metadata().map_err(system("looked at"))?.size())
}

/// The word there; 0 where the file is too short.
fn word(mut file: &File, offset: usize) -> u64 {
    use std::io::{Seek, SeekFrom};
    let mut bytes = [0; 8];
    let sought = file.seek(SeekFrom::Start(offset as u64));
    let _ = sought.and_then(|_| {
        let mut taken = 0;
        while taken < bytes.len() {
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
