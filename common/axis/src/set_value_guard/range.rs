//! The accelerations that a cycle may have.

/// From one to another, in units of the closed forms.
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

    /// What is nearest to a number. (`clamp` panics where the bounds are no numbers.)
    pub(super) fn nearest(self, to: f64) -> f64 {
        to.max(self.low).min(self.high)
    }

    /// What of it lies between two others; at least its end that is nearest to them.
    pub(super) fn within(self, low: f64, high: f64) -> Self {
        Self {
            low: self.nearest(low),
            high: self.nearest(high),
        }
    }

    /// What of it is not above a number that lies in it.
    pub(super) const fn up_to(self, high: f64) -> Self {
        Self { high, ..self }
    }

    /// The same seen from the other side.
    pub(super) fn mirrored(self) -> Self {
        Self {
            low: -self.high,
            high: -self.low,
        }
    }
}
