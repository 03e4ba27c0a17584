//! Presentation delay of a frame: the time after its generation at which its values are shown.

use core::num::NonZeroU32;

use coaxle_clock::Span;

/// Time between the generation instant of a frame and the instant at which every node shows its values: 1 ns to 4 s.
///
/// A network without one has none in its frames, and every node shows the newest values moved to now.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PresentAfter(NonZeroU32);

impl PresentAfter {
    /// The longest one.
    // A field of 32 bits ends at 4.29 s.
    pub const LONGEST: Span = Span::from_secs(4);

    /// Creates one; none for a time of 0 or less, or beyond [`Self::LONGEST`].
    #[must_use]
    pub fn new(span: Span) -> Option<Self> {
        if span > Self::LONGEST {
            return None;
        }
        let nanos = u32::try_from(span.as_nanos()).ok()?;
        NonZeroU32::new(nanos).map(Self)
    }

    /// Returns the time.
    #[must_use]
    pub const fn span(self) -> Span {
        Span::from_nanos(self.0.get() as i64)
    }

    /// Returns the field of a frame.
    #[must_use]
    pub const fn nanos(self) -> u32 {
        self.0.get()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nanosecond_to_four_seconds_are_delays() {
        let of = |nanos| PresentAfter::new(Span::from_nanos(nanos)).map(PresentAfter::nanos);
        assert_eq!(of(1), Some(1));
        assert_eq!(of(4_000_000_000), Some(4_000_000_000));
        for nanos in [i64::MIN, -1, 0, 4_000_000_001, 1 << 32, i64::MAX] {
            assert_eq!(of(nanos), None, "{nanos}");
        }
    }
}
