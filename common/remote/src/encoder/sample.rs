//! A reading of a counter.

/// A count, and the sampling cycles since the previous one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderSample {
    pub(super) raw: u64,
    pub(super) cycles: u32,
}

impl EncoderSample {
    /// Creates the sample of the next sampling cycle. Bits beyond the width of the counter are
    /// ignored; a signed count is passed as its two's complement, `count as u64`.
    #[must_use]
    pub const fn next(raw: u64) -> Self {
        Self { raw, cycles: 1 }
    }

    /// Creates a sample from the position of an axis that an encoder measures, which is a multiple
    /// of its increment: a count of 64 bits. None if it is not finite, or too large for such a
    /// count. Both in u.
    #[must_use]
    pub fn next_position(position: f64, increment: f64) -> Option<Self> {
        const MOST: f64 = (1_u64 << 63) as f64;
        // A position is a multiple of the increment but for rounding: `floor` would make 2.9999999 to 2.
        let count = libm::round(position / increment);
        // False for NaN and infinities as well, which an `as` would saturate silently.
        (-MOST..MOST)
            .contains(&count)
            .then_some(Self::next(count as i64 as u64))
    }

    /// Places it this number of sampling cycles after the last sample: the difference of their
    /// cycle indices. One of 0 cycles is the last one again and is ignored.
    #[must_use]
    pub const fn after(self, cycles: u32) -> Self {
        Self { cycles, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_position_is_the_count_it_is_a_multiple_by() {
        for (count, increment) in [
            (0_i64, 0.1),
            (-7, 0.1),
            (123_456_789_012, 0.001),
            (-5, 1e-9),
        ] {
            let sample = EncoderSample::next_position(count as f64 * increment, increment);
            assert_eq!(sample, Some(EncoderSample::next(count as u64)));
        }
        for position in [f64::NAN, f64::INFINITY, 1e30, -1e30] {
            assert_eq!(EncoderSample::next_position(position, 0.001), None);
        }
    }
}
