//! The possible accelerations of a cycle.

/// A range of accelerations, in units of the closed forms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    low: f64,
    high: f64,
}

impl Range {
    pub(super) fn around(middle: f64, reach: f64) -> Self {
        Self {
            low: middle - reach,
            high: middle + reach,
        }
    }

    pub(super) const fn high(self) -> f64 {
        self.high
    }

    /// The nearest value to a number. (`clamp` panics if the bounds are not numbers.)
    pub(super) fn nearest(self, to: f64) -> f64 {
        to.max(self.low).min(self.high)
    }

    /// The part between two others; at least its end nearest to them.
    pub(super) fn within(self, low: f64, high: f64) -> Self {
        Self {
            // Each bound stays in the range: beyond the limits the jerk still holds, and leads back towards them.
            low: self.nearest(low),
            high: self.nearest(high),
        }
    }

    /// The part up to a number that lies in it.
    pub(super) const fn up_to(self, high: f64) -> Self {
        Self { high, ..self }
    }

    /// The range mirrored at zero.
    pub(super) fn mirrored(self) -> Self {
        Self {
            low: -self.high,
            high: -self.low,
        }
    }
}
