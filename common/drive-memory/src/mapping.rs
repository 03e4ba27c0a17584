//! A mapped file as words: the only place where memory changes behind the compiler's back.

use std::fs::File;
use std::sync::atomic::AtomicU64;

use memmap2::{MmapOptions, MmapRaw};

use super::layout::{SIZE, WORDS};

/// A mapped file, shared with other processes that map it.
#[derive(Debug)]
pub(super) struct Mapping(MmapRaw);

impl Mapping {
    /// Maps a file of [`SIZE`] bytes, and loads its page before the first cycle.
    pub(super) fn of(file: &File) -> std::io::Result<Self> {
        let map = MmapOptions::new().len(SIZE).populate().map_raw(file)?;
        // Without permission to lock, the page stays in memory as long as there is enough.
        let _ = map.lock();
        Ok(Self(map))
    }

    /// The words of the mapping. Any value written by another process is a valid number.
    #[expect(
        unsafe_code,
        reason = "memory that another process writes too has no other way in"
    )]
    pub(super) fn words(&self) -> &[AtomicU64; WORDS] {
        // SAFETY:
        // * The mapping has SIZE = 8 · WORDS bytes, begins at a page, so it is aligned, and lives as long as
        //   `self`, whose borrow the result has.
        // * Every bit pattern is an `AtomicU64`, and this process touches the mapping through atomics only:
        //   nothing else here ever sees the pointer. Other processes are no part of this program's memory
        //   model; what they write at any time is to the hardware what another thread's atomics would be, for
        //   the words are aligned.
        // * The mapping is shared and writable, so that atomics may write to it. A file that is
        //   shortened while it is mapped ends the process with SIGBUS, which is no undefined
        //   behaviour; its mode lets only its own user and group do so.
        unsafe { &*self.0.as_mut_ptr().cast::<[AtomicU64; WORDS]>() }
    }
}
