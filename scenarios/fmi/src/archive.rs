//! A zip archive of files as they are, with the same bytes for the same files.

use std::io;

/// Files to be packed, in the order in which they are added.
#[derive(Debug, Default)]
pub(crate) struct Archive {
    bytes: Vec<u8>,
    /// Entries of the directory at the end.
    directory: Vec<u8>,
    files: u16,
}

/// The least version of a reader that the archive needs: 2.0.
const VERSION: u16 = 20;
/// Names are UTF-8.
const UTF_8: u16 = 0x0800;
/// The first day of January 1980, the origin of dates in archives: a date of today would be other bytes each day.
const DATE: u16 = 0x0021;

impl Archive {
    /// Adds a file.
    ///
    /// # Errors
    /// More than 4 GB in all, or more than 65 535 files, which the format does not hold.
    pub(crate) fn add(&mut self, name: &str, content: &[u8]) -> io::Result<()> {
        let at = size(self.bytes.len())?;
        let common = common_header(name, content)?;
        self.bytes.extend(b"PK\x03\x04");
        self.bytes.extend(&common);
        self.bytes.extend(name.as_bytes());
        self.bytes.extend(content);
        self.directory.extend(b"PK\x01\x02");
        self.directory.extend(VERSION.to_le_bytes());
        self.directory.extend(&common);
        // Neither comment, disk number, nor attributes.
        self.directory.extend([0; 10]);
        self.directory.extend(at.to_le_bytes());
        self.directory.extend(name.as_bytes());
        self.files = self.files.checked_add(1).ok_or_else(too_large)?;
        Ok(())
    }

    /// Returns the bytes of the archive.
    ///
    /// # Errors
    /// As [`add`](Self::add).
    pub(crate) fn finish(mut self) -> io::Result<Vec<u8>> {
        let (at, length) = (size(self.bytes.len())?, size(self.directory.len())?);
        self.bytes.extend(&self.directory);
        self.bytes.extend(b"PK\x05\x06\0\0\0\0");
        // On this disk, and in all.
        self.bytes.extend(self.files.to_le_bytes());
        self.bytes.extend(self.files.to_le_bytes());
        self.bytes.extend(length.to_le_bytes());
        self.bytes.extend(at.to_le_bytes());
        self.bytes.extend([0; 2]);
        Ok(self.bytes)
    }
}

/// The part that the header of a file and its entry in the directory have in common.
fn common_header(name: &str, content: &[u8]) -> io::Result<Vec<u8>> {
    let name = u16::try_from(name.len()).map_err(|_| too_large())?;
    let length = size(content.len())?;
    let mut header = Vec::new();
    // Stored as it is, at midnight.
    for short in [VERSION, UTF_8, 0, 0, DATE] {
        header.extend(short.to_le_bytes());
    }
    for long in [crc32fast::hash(content), length, length] {
        header.extend(long.to_le_bytes());
    }
    header.extend(name.to_le_bytes());
    // No extra field.
    header.extend([0; 2]);
    Ok(header)
}

fn size(length: usize) -> io::Result<u32> {
    u32::try_from(length).map_err(|_| too_large())
}

fn too_large() -> io::Error {
    io::Error::other("a unit of more than 4 GB, expected less")
}
