//! A file that survives the end of the process and a power failure.

use std::fs::File;
use std::io::{self, Write};

/// A file whose flushed data are on the disk, so that they survive the end of the process and a
/// power failure.
#[derive(Debug)]
pub struct SyncedFile(pub File);

impl Write for SyncedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        // `sync_data` instead of `sync_all`: times of change in the inode are not worth a second write.
        match self.0.sync_data() {
            // A target that is no file, such as a pipe, has no disk.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
            other => other,
        }
    }
}
