//! A file that outlives the process, and the power.

use std::fs::File;
use std::io::{self, Write};

/// A file of which all that was flushed is on the disk, so that neither the end of the process nor that of the power takes
/// it.
#[derive(Debug)]
pub struct SyncedFile(pub File);

impl Write for SyncedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        match self.0.sync_data() {
            // What is no file, such as a pipe, has no disk.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
            other => other,
        }
    }
}
