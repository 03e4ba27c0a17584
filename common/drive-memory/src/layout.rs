//! The layout of the memory that a node and a drive process share, as documented in `docs/DRIVE.md`.
//!
//! All fields are words of 8 bytes in the byte order of the machine, so that each is read and written at once.

/// The first eight bytes, `COAXLEDR`.
pub const MAGIC: u64 = u64::from_ne_bytes(*b"COAXLEDR");
/// The version of the layout.
pub const VERSION: u64 = 1;
/// Bytes of the file.
// 48 words: a header and a name of 16, set values of 16, actual values of 16; blocks begin at 128 and 256.
// Begins of blocks lie on lines of the processor's cache (64 bytes): the two writers never share one.
pub const SIZE: usize = 384;
/// Words of the file.
pub const WORDS: usize = SIZE / 8;

/// Bytes of the name.
pub const NAME_BYTES: usize = 64;

/// A field, by the index of its word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field(pub(super) usize);

impl Field {
    /// Offset of its first byte in the file.
    #[must_use]
    pub const fn offset(self) -> usize {
        self.0 * 8
    }
}

macro_rules! fields {
    ($($(#[$doc:meta])+ $name:ident = $offset:literal $kind:literal;)*) => {
        $($(#[$doc])+ pub const $name: Field = Field($offset / 8);)*

        /// Every field: its name, its offset in bytes, its kind.
        pub const FIELDS: &[(&str, usize, &str)] = &[$((stringify!($name), $offset, $kind)),*];
    };
}

fields! {
    /// [`MAGIC`].
    MAGIC_FIELD = 0 "u64";
    /// [`VERSION`].
    VERSION_FIELD = 8 "u64";
    /// [`SIZE`].
    SIZE_FIELD = 16 "u64";
    /// Run number of the node, not 0; 0: the node has ended.
    RUN = 24 "u64";
    /// Axis id of the slave.
    SLAVE_ID = 32 "u64";
    /// Nominal cycle time, ns.
    CYCLE_TIME = 40 "u64";
    /// Process id of the node.
    NODE_PID = 48 "u64";
    /// Bytes of the name.
    NAME_LENGTH = 56 "u64";
    /// The name of the slave, UTF-8, filled up with zeros.
    NAME = 64 "64 bytes";

    /// Odd while the set values are being written.
    SET_SEQUENCE = 128 "u64";
    /// Incremented in each cycle.
    SET_COUNTER = 136 "u64";
    /// The ideal start of the cycle, ns of `CLOCK_MONOTONIC`.
    SET_IDEAL_START = 144 "i64";
    /// Set position, u.
    SET_POSITION = 152 "f64";
    /// Set velocity, u/s.
    SET_VELOCITY = 160 "f64";
    /// Set acceleration, u/s².
    SET_ACCELERATION = 168 "f64";
    /// 1: switch power on and follow; 0: no power.
    SET_ENABLE = 176 "u64";
    /// A changed number means: acknowledge errors.
    SET_RESETS = 184 "u64";
    /// State of the drive as seen by the node: 0 off, 1 switching on, 2 following, 3 tripped.
    SET_STATE = 192 "u64";

    /// Odd while the actual values are being written.
    ACTUAL_SEQUENCE = 256 "u64";
    /// Run of the node that the process is attached to; 0: not attached.
    ACTUAL_RUN = 264 "u64";
    /// Changes as long as the process lives.
    ACTUAL_HEARTBEAT = 272 "u64";
    /// The counter of the set values that the process has read.
    ACTUAL_COUNTER = 280 "u64";
    /// The resets that it has carried out, as in the set values.
    ACTUAL_RESETS = 288 "u64";
    /// State of the drive: 0 off, 1 following, 2 error.
    ACTUAL_STATE = 296 "u64";
    /// Error code of the drive, 0 without an error; the lower 32 bits.
    ACTUAL_ERROR = 304 "u64";
    /// Actual position, u.
    ACTUAL_POSITION = 312 "f64";
    /// Actual velocity, u/s.
    ACTUAL_VELOCITY = 320 "f64";
    /// Process id of the drive process.
    ACTUAL_PID = 328 "u64";
}
