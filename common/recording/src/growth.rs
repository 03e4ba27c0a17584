//! Growth of a recording, estimated before much is written.

use std::fmt;

use crate::table::Table;

/// Bytes per cycle, and per signal, as measured (docs/RECORDING.md): receivers of 126 signals take 305
/// bytes a cycle with their inputs, senders of 10 take 73. Values that change more take more.
const CYCLE_BYTES: f64 = 53.0;
const SIGNAL_BYTES: f64 = 2.0;

/// Bytes per time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    bytes_per_s: f64,
}

impl Growth {
    /// Returns the growth expected of a table with this cycle.
    #[must_use]
    pub fn expected(table: &Table, cycle_s: f64) -> Self {
        let signals: usize = table.instances.iter().map(|of| of.signals.len()).sum();
        Self {
            // 53 + 2·126 = 305 bytes of the measured receiver, 53 + 2·10 = 73 of the sender.
            bytes_per_s: (CYCLE_BYTES + SIGNAL_BYTES * signals as f64) / cycle_s,
        }
    }

    /// Returns the growth of a file by this number of bytes in this number of seconds.
    #[must_use]
    pub fn measured(bytes: u64, seconds: f64) -> Self {
        Self {
            bytes_per_s: bytes as f64 / seconds,
        }
    }
}

impl fmt::Display for Growth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let per_hour = self.bytes_per_s * 3_600.0;
        // Below 0.95 GB, which would be shown as 0.9 or 1.0 GB, megabytes are the better unit.
        match per_hour < 0.95e9 {
            true => write!(f, "about {:.0} MB per hour", (per_hour * 1e-6).max(1.0)),
            false => write!(f, "about {:.1} GB per hour", per_hour * 1e-9),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::boiler;

    #[test]
    fn what_a_recording_takes_is_said_in_words() {
        // 11 signals.
        let expected = Growth::expected(&boiler(), 1e-3);
        assert_eq!(expected.to_string(), "about 270 MB per hour");
        let measured = Growth::measured(305_000, 1.0);
        assert_eq!(measured.to_string(), "about 1.1 GB per hour");
        assert_eq!(Growth::measured(0, 1.0).to_string(), "about 1 MB per hour");
    }
}
