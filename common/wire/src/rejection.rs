//! Reasons for refused frames, and their counters.

use serde::ser::{Serialize, SerializeMap, Serializer};

/// Reason for a refused frame. A frame has one reason: the first that applies, in the order below.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum Rejection {
    /// First byte other than [`FORMAT_VERSION`](crate::frame::FORMAT_VERSION), and for axes other than
    /// [`PRESENTED_VERSION`](crate::frame::PRESENTED_VERSION).
    #[error("the frame has another format version")]
    WrongVersion,
    /// End of the frame before the end of its fields.
    #[error("the frame ends before its fields do")]
    Truncated,
    /// Check sum that does not fit the bytes and the key.
    #[error("the frame's check sum does not fit its bytes and its key")]
    WrongChecksum,
    /// Right check sum over bytes that are no frame: an overlong number, an unknown option tag, too many
    /// axes.
    #[error("the frame's check sum is right, but its bytes are no frame")]
    Malformed,
    /// Bytes left over behind the last field.
    #[error("bytes are left over behind the frame's last field")]
    TrailingBytes,
    /// Cycle time outside 100 µs…100 ms.
    #[error("the frame's cycle time is outside 100 µs to 100 ms")]
    CycleTimeOutOfRange,
    /// Presentation delay above 4 s.
    #[error("the frame is to be shown more than 4 s after its cycle")]
    PresentAfterOutOfRange,
    /// Frame of another publisher under the sender's key.
    #[error("the frame comes from another node than the key belongs to")]
    ForeignSender,
    /// No axis in it that the receiver follows.
    #[error("none of the axes that are followed is in the frame")]
    AxisMissing,
    /// A kinematic value in each followed axis that is NaN, infinite, or larger than any axis is.
    #[error("each followed axis has a kinematic value that is no number between -1e15 and 1e15")]
    Implausible,
}

impl Rejection {
    /// Reasons in the order of the checks.
    pub const ALL: [Self; 10] = [
        Self::WrongVersion,
        Self::Truncated,
        Self::WrongChecksum,
        Self::Malformed,
        Self::TrailingBytes,
        Self::CycleTimeOutOfRange,
        Self::PresentAfterOutOfRange,
        Self::ForeignSender,
        Self::AxisMissing,
        Self::Implausible,
    ];

    /// Returns the name of the reason in status and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::WrongVersion => "wrong-version",
            Self::Truncated => "truncated",
            Self::WrongChecksum => "wrong-checksum",
            Self::Malformed => "malformed",
            Self::TrailingBytes => "trailing-bytes",
            Self::CycleTimeOutOfRange => "cycle-time-out-of-range",
            Self::PresentAfterOutOfRange => "present-after-out-of-range",
            Self::ForeignSender => "foreign-sender",
            Self::AxisMissing => "axis-missing",
            Self::Implausible => "implausible",
        }
    }
}

/// Number of frames refused for each reason. Serialised as a map from the reason's name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RejectionCounters([u64; Rejection::ALL.len()]);

impl RejectionCounters {
    /// Counts one refused frame.
    pub fn count(&mut self, reason: Rejection) {
        let counter = &mut self.0[reason as usize];
        *counter = counter.saturating_add(1);
    }

    /// Returns the number of frames refused for this reason.
    #[must_use]
    pub const fn of(&self, reason: Rejection) -> u64 {
        self.0[reason as usize]
    }

    /// Returns the number of frames refused for any reason.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.0.iter().copied().fold(0, u64::saturating_add)
    }

    /// Returns every reason's name and count, those that never came up included.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, u64)> {
        Rejection::ALL
            .into_iter()
            .map(|reason| (reason.name(), self.of(reason)))
    }
}

impl Serialize for RejectionCounters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, count) in self.iter() {
            map.serialize_entry(name, &count)?;
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reason_has_a_counter_and_a_name_of_its_own() {
        for (place, reason) in Rejection::ALL.into_iter().enumerate() {
            assert_eq!(reason as usize, place);
            let same_name = Rejection::ALL.iter().filter(|r| r.name() == reason.name());
            assert_eq!(same_name.count(), 1);
        }
    }

    #[test]
    fn counters_count_by_reason() {
        let mut counters = RejectionCounters::default();
        counters.count(Rejection::Implausible);
        counters.count(Rejection::Implausible);
        counters.count(Rejection::WrongVersion);
        assert_eq!(counters.of(Rejection::Implausible), 2);
        assert_eq!(counters.of(Rejection::AxisMissing), 0);
        assert_eq!(counters.total(), 3);
    }

    #[test]
    fn counters_are_written_as_a_map_of_all_reasons() {
        let mut counters = RejectionCounters::default();
        counters.count(Rejection::ForeignSender);
        let table = toml::Table::try_from(counters).unwrap();
        assert_eq!(table.len(), Rejection::ALL.len());
        assert_eq!(table["foreign-sender"].as_integer(), Some(1));
        assert_eq!(table["truncated"].as_integer(), Some(0));
    }
}
