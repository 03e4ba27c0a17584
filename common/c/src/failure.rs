//! Errors as a code and a sentence.

use core::ffi::c_char;
use core::fmt::{self, Write as _};

use coaxle_clock::time_sync::WrongParameter;

/// Success.
pub const COAXLE_OK: i32 = 0;
/// A pointer is null where one is needed.
pub const COAXLE_NULL: i32 = -1;
/// A pointer is not aligned as its type requires.
pub const COAXLE_MISALIGNED: i32 = -2;
/// A handle is not of the expected kind, or has been freed.
pub const COAXLE_NO_HANDLE: i32 = -3;
/// A handle is in use by another thread. Only a debug build notices.
pub const COAXLE_IN_USE: i32 = -4;
/// A `struct_size` is smaller than the first version of its struct, or larger than this library's with bytes that it does not know.
pub const COAXLE_STRUCT_SIZE: i32 = -5;
/// A value is out of its range, or no number.
pub const COAXLE_RANGE: i32 = -6;
/// A text is not UTF-8, or not what it should be.
pub const COAXLE_TEXT: i32 = -7;
/// A buffer is too small.
pub const COAXLE_CAPACITY: i32 = -8;
/// A message was rejected: damaged, foreign, or of another version.
pub const COAXLE_REJECTED: i32 = -9;
/// A fault of the library itself. The handle is not usable any more.
pub const COAXLE_PANIC: i32 = -10;
/// There is nothing of the kind: an axis, a slave, a job.
pub const COAXLE_NOT_THERE: i32 = -11;

/// An error on its way to the caller.
#[derive(Clone, Debug)]
pub(crate) struct Failure {
    pub(crate) code: i32,
    pub(crate) sentence: Sentence,
}

impl Failure {
    /// Writes the sentence in place: failing allocates nothing.
    pub(crate) fn new(code: i32, sentence: impl fmt::Display) -> Self {
        let mut written = Sentence::EMPTY;
        // A sentence that is too long is cut off.
        let _ = write!(written, "{sentence}");
        Self {
            code,
            sentence: written,
        }
    }

    /// An error with a code of the NC.
    pub(crate) fn of_nc(code: u32, sentence: impl fmt::Display) -> Self {
        Self::new(i32::try_from(code).unwrap_or(i32::MAX), sentence)
    }

    /// A value that is out of its range.
    pub(crate) fn range(
        field: &str,
        received: impl fmt::Display,
        expected: impl fmt::Display,
    ) -> Self {
        let sentence = format_args!("{field}: received {received}, expected {expected}");
        Self::new(COAXLE_RANGE, sentence)
    }
}

/// A parameter that a block of TS5066, or of ours beside them, refuses.
pub(crate) fn wrong_parameter(wrong: WrongParameter) -> Failure {
    Failure::of_nc(wrong.error().code().into(), wrong)
}

/// A sentence in place, ended by a 0.
#[derive(Clone, Debug)]
pub(crate) struct Sentence {
    bytes: [u8; Sentence::SIZE],
    length: usize,
}

impl Sentence {
    const SIZE: usize = 512;
    pub(crate) const EMPTY: Self = Self {
        bytes: [0; Self::SIZE],
        length: 0,
    };

    pub(crate) const fn as_ptr(&self) -> *const c_char {
        self.bytes.as_ptr().cast()
    }
}

impl fmt::Write for Sentence {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let room = Self::SIZE - 1 - self.length;
        let mut taken = text.len().min(room);
        while !text.is_char_boundary(taken) {
            taken -= 1;
        }
        self.bytes[self.length..self.length + taken].copy_from_slice(&text.as_bytes()[..taken]);
        self.length += taken;
        Ok(())
    }
}
