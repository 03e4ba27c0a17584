//! Files: permissions and locks.

use std::fs::{DirBuilder, File, Metadata, OpenOptions, Permissions};
use std::io;
use std::os::unix::fs::{DirBuilderExt, FileTypeExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

use rustix::fs::{
    FallocateFlags, FlockOperation, OFlags, fallocate, fcntl_lock, flock, fstat, stat,
};
use rustix::io::Errno;

use crate::{HeldFolder, OtherPermissions, Readers, SharedLock};

pub(super) fn hold_folder(path: &Path) -> io::Result<Option<HeldFolder>> {
    let folder = File::open(path)?;
    match flock(&folder, FlockOperation::NonBlockingLockExclusive) {
        // Some network file systems have no locks: better without one than without results.
        Ok(()) | Err(Errno::NOTSUP | Errno::NOSYS) => Ok(Some(HeldFolder {
            _lock: Some(folder),
        })),
        Err(Errno::WOULDBLOCK) => Ok(None),
        Err(errno) => Err(errno.into()),
    }
}

pub(super) fn make_private_folder(path: &Path) -> io::Result<()> {
    DirBuilder::new().recursive(true).mode(0o700).create(path)
}

pub(super) fn create(path: &Path, readers: Readers) -> io::Result<File> {
    let mode = match readers {
        Readers::Owner => 0o600,
        Readers::All => 0o644,
    };
    let mut options = OpenOptions::new();
    options.write(true).create(true).truncate(true).mode(mode);
    let file = options.open(path)?;
    // An existing file of that name would keep its own mode.
    file.set_permissions(Permissions::from_mode(mode))?;
    Ok(file)
}

pub(super) fn permissions_of_others(path: &Path) -> Option<OtherPermissions> {
    let mode = path.metadata().ok()?.mode();
    Some(OtherPermissions {
        // Bits of group and others; 022 are their rights to write.
        access: mode & 0o077 != 0,
        write: mode & 0o022 != 0,
    })
}

/// Read and write for its user and group, nothing for others.
const SHARED_MODE: u32 = 0o660;

pub(super) fn open_shared(path: &Path, make: bool) -> io::Result<File> {
    // A link could lead the node to write into a file of somebody else's choice, and opening a pipe would wait for
    // its other end.
    let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(make);
    options.mode(SHARED_MODE).custom_flags(flags.bits() as i32);
    options.open(path)
}

pub(super) fn kind_of(metadata: &Metadata) -> Option<&'static str> {
    let kind = metadata.file_type();
    match () {
        () if kind.is_dir() => Some("a folder"),
        () if kind.is_symlink() => Some("a link"),
        () if kind.is_socket() => Some("a socket"),
        () if kind.is_fifo() => Some("a pipe"),
        () if !kind.is_file() => Some("a device"),
        () => None,
    }
}

/// Takes a `flock` for the node, a record lock (`lockf`) for the drive process: the two are independent,
/// and the system drops them when their process ends, however it does.
pub(super) fn lock(file: &File, lock: SharedLock) -> io::Result<bool> {
    let exclusive = FlockOperation::NonBlockingLockExclusive;
    let taken = match lock {
        SharedLock::Node => flock(file, exclusive),
        SharedLock::DriveProcess => fcntl_lock(file, exclusive),
    };
    match taken {
        Ok(()) => Ok(true),
        Err(Errno::WOULDBLOCK) => Ok(false),
        // POSIX leaves systems the choice between the two for record locks.
        Err(Errno::ACCESS) if lock == SharedLock::DriveProcess => Ok(false),
        Err(errno) => Err(errno.into()),
    }
}

pub(super) fn reserve(file: &File, bytes: u64) -> io::Result<()> {
    file.set_len(bytes)?;
    // A sparse file on a full disk fails at the first write to the mapped memory, with SIGBUS.
    match fallocate(file, FallocateFlags::empty(), 0, bytes) {
        Ok(()) | Err(Errno::OPNOTSUPP) => Ok(()),
        Err(errno) => Err(errno.into()),
    }
}

pub(super) fn mode_of(file: &File) -> io::Result<u32> {
    Ok(file.metadata()?.mode() & 0o777)
}

pub(super) fn is_at(path: &Path, file: &File) -> bool {
    let (Ok(own), Ok(there)) = (fstat(file), stat(path)) else {
        return false;
    };
    // Another file may have taken the path meanwhile; device and inode identify this one.
    (own.st_dev, own.st_ino) == (there.st_dev, there.st_ino)
}

pub(super) fn is_on_disk(file: &File) -> bool {
    // Numbers of statfs(2). These three have no disk behind them.
    const TMPFS: u64 = 0x0102_1994;
    const RAMFS: u64 = 0x8584_58f6;
    const HUGETLBFS: u64 = 0x9584_58f6;
    rustix::fs::fstatfs(file).is_ok_and(|system| {
        // Signed and of another width on some processors, which would extend the sign of RAMFS and HUGETLBFS.
        let kind = system.f_type as u64 & 0xffff_ffff;
        ![TMPFS, RAMFS, HUGETLBFS].contains(&kind)
    })
}
