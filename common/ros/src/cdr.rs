//! CDR of ROS 2: plain, each value aligned to its own size, relative to the end of the four bytes of the
//! header.

/// Error of bytes that are not a message of the expected type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CdrError {
    /// A header other than CDR's.
    #[error(
        "the header: received {received:02x?}, expected [00, 01, ..] or [00, 00, ..]: plain CDR, low or high bytes first"
    )]
    Header {
        /// First bytes, four at most.
        received: Vec<u8>,
    },
    /// A message that ends too soon.
    #[error("{field}: received {received} bytes, expected {expected}")]
    Truncated {
        /// Path of the field.
        field: String,
        /// Number of bytes left.
        received: usize,
        /// Number of bytes needed.
        expected: usize,
    },
    /// A text that is not valid.
    #[error("{field}: received bytes that are no text, expected UTF-8 that ends in a zero")]
    NotText {
        /// Path of the field.
        field: String,
    },
    /// Bytes after the last field.
    #[error("received {received} bytes behind the last field, expected at most 3")]
    Trailing {
        /// Number of bytes.
        received: usize,
    },
}

impl CdrError {
    /// Returns the error with the field inside an outer one.
    pub(crate) fn within(mut self, outer: &str) -> Self {
        // The other errors concern the message as a whole and have no field.
        if let Self::Truncated { field, .. } | Self::NotText { field } = &mut self {
            *field = format!("{outer}.{field}");
        }
        self
    }
}

/// Header of every message: low bytes first, no options.
const LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];
/// Greatest padding: a writer may fill up to a multiple of four bytes.
const MOST_PADDING: usize = 3;

/// Writes a message.
pub(crate) struct CdrWriter(Vec<u8>);

impl CdrWriter {
    pub(crate) fn new() -> Self {
        Self(LITTLE_ENDIAN.to_vec())
    }

    pub(crate) fn finish(self) -> Vec<u8> {
        self.0
    }

    pub(crate) fn u32(&mut self, value: u32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    pub(crate) fn i32(&mut self, value: i32) {
        self.u32(value.cast_unsigned());
    }

    pub(crate) fn f64s(&mut self, values: &[f64]) {
        self.length(values.len());
        for value in values {
            // Inside the loop: an empty sequence has no padding behind its length.
            self.align(8);
            self.0.extend(value.to_le_bytes());
        }
    }

    pub(crate) fn text(&mut self, text: &str) {
        // The zero at the end counts.
        self.length(text.len() + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    pub(crate) fn texts(&mut self, texts: &[String]) {
        self.length(texts.len());
        for text in texts {
            self.text(text);
        }
    }

    /// Writes the length of a sequence.
    pub(crate) fn length(&mut self, length: usize) {
        // No message of ours has four thousand million of anything.
        self.u32(u32::try_from(length).unwrap_or(u32::MAX));
    }

    fn align(&mut self, size: usize) {
        let content = self.0.len() - LITTLE_ENDIAN.len();
        let padding = content.next_multiple_of(size) - content;
        self.0.extend(std::iter::repeat_n(0, padding));
    }
}

/// Reads a message. Never allocates more than the message received.
pub(crate) struct CdrReader<'a> {
    rest: &'a [u8],
    read: usize,
    low_first: bool,
}

impl<'a> CdrReader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Result<Self, CdrError> {
        let low_first = match bytes {
            // Representations 0 and 1 are plain CDR; the two bytes behind are options, which readers
            // ignore.
            [0, order @ (0 | 1), _, _, ..] => *order == 1,
            other => {
                let received = other.iter().copied().take(4).collect();
                return Err(CdrError::Header { received });
            }
        };
        Ok(Self {
            rest: &bytes[LITTLE_ENDIAN.len()..],
            read: 0,
            low_first,
        })
    }

    /// Ends reading; the rest may only be padding.
    pub(crate) fn finish(self) -> Result<(), CdrError> {
        match self.rest.len() {
            // More is a field that this version of the type does not have.
            received if received > MOST_PADDING => Err(CdrError::Trailing { received }),
            _ => Ok(()),
        }
    }

    pub(crate) fn u32(&mut self, field: &str) -> Result<u32, CdrError> {
        let bytes = self.aligned(field)?;
        Ok(match self.low_first {
            true => u32::from_le_bytes(bytes),
            false => u32::from_be_bytes(bytes),
        })
    }

    pub(crate) fn i32(&mut self, field: &str) -> Result<i32, CdrError> {
        self.u32(field).map(u32::cast_signed)
    }

    pub(crate) fn f64s(&mut self, field: &str) -> Result<Vec<f64>, CdrError> {
        let length = self.length(field, 8)?;
        (0..length).map(|_| self.f64(field)).collect()
    }

    pub(crate) fn text(&mut self, field: &str) -> Result<String, CdrError> {
        let length = self.length(field, 1)?;
        let not_text = || CdrError::NotText {
            field: field.to_owned(),
        };
        let text = match self.take(length, field)? {
            // A length of 0 leaves no room for the zero: an empty text, not a malformed one.
            [] => &[],
            [text @ .., 0] => text,
            _ => return Err(not_text()),
        };
        let text = std::str::from_utf8(text).map_err(|_| not_text())?;
        Ok(text.to_owned())
    }

    pub(crate) fn texts(&mut self, field: &str) -> Result<Vec<String>, CdrError> {
        let length = self.length(field, 4)?;
        (0..length).map(|_| self.text(field)).collect()
    }

    /// Reads the length of a sequence with elements of at least `least` bytes.
    pub(crate) fn length(&mut self, field: &str, least: usize) -> Result<usize, CdrError> {
        let length = self.u32(field)? as usize;
        // A forged length of four thousand million must fail here, and not allocate.
        let expected = length.saturating_mul(least);
        self.has(expected, field).map(|()| length)
    }

    fn f64(&mut self, field: &str) -> Result<f64, CdrError> {
        let bytes = self.aligned(field)?;
        Ok(match self.low_first {
            true => f64::from_le_bytes(bytes),
            false => f64::from_be_bytes(bytes),
        })
    }

    fn aligned<const N: usize>(&mut self, field: &str) -> Result<[u8; N], CdrError> {
        // Relative to the end of the header, as in the writer, and not to the address of the buffer.
        let padding = self.read.next_multiple_of(N) - self.read;
        self.take(padding, field)?;
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N, field)?);
        Ok(bytes)
    }

    fn take(&mut self, length: usize, field: &str) -> Result<&'a [u8], CdrError> {
        self.has(length, field)?;
        let (taken, rest) = self.rest.split_at(length);
        self.rest = rest;
        self.read += length;
        Ok(taken)
    }

    fn has(&self, expected: usize, field: &str) -> Result<(), CdrError> {
        let received = self.rest.len();
        if expected <= received {
            return Ok(());
        }
        Err(CdrError::Truncated {
            field: field.to_owned(),
            received,
            expected,
        })
    }
}
