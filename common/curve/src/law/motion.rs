//! Values of a law at one master position, and its extremes.

/// The slave at one master position: position and its first three derivatives with respect to the master.
///
/// Master and slave positions are in user units, derivatives in slave units per master unit, its
/// square and its cube.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Slave position.
    pub position: f64,
    /// First derivative: slave velocity at unit master velocity.
    pub velocity: f64,
    /// Second derivative: slave acceleration at unit master velocity.
    pub acceleration: f64,
    /// Third derivative: slave jerk at unit master velocity.
    pub jerk: f64,
}

/// End of a segment: master position, and the slave there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Knot {
    /// Master position.
    pub master: f64,
    /// The slave and its derivatives there.
    pub motion: Motion,
}

/// A value and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// Place on the master.
    pub master: f64,
    /// The value there.
    pub value: f64,
}

/// The minimum and the maximum of a quantity, each with one of its places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MinMax {
    /// Minimum.
    pub minimum: Extreme,
    /// Maximum.
    pub maximum: Extreme,
}

impl MinMax {
    /// Makes a range of a single value.
    #[must_use]
    pub const fn at(master: f64, value: f64) -> Self {
        let extreme = Extreme { master, value };
        Self {
            minimum: extreme,
            maximum: extreme,
        }
    }

    /// Returns the extremes of both; of equal values, those of `self`.
    #[must_use]
    pub fn joined(self, other: Self) -> Self {
        let lower = other.minimum.value < self.minimum.value;
        let higher = other.maximum.value > self.maximum.value;
        Self {
            minimum: if lower { other.minimum } else { self.minimum },
            maximum: if higher { other.maximum } else { self.maximum },
        }
    }

    /// Returns the extremes of `factor` times the quantity, their places mapped by `place`.
    pub(super) fn map(self, factor: f64, place: impl Fn(f64) -> f64) -> Self {
        let map = |extreme: Extreme| Extreme {
            master: place(extreme.master),
            value: factor * extreme.value,
        };
        let (minimum, maximum) = (map(self.minimum), map(self.maximum));
        // A negative factor makes the least value the greatest.
        if factor < 0.0 {
            return Self {
                minimum: maximum,
                maximum: minimum,
            };
        }
        Self { minimum, maximum }
    }

    /// Returns the larger of the two magnitudes.
    #[must_use]
    pub fn magnitude(&self) -> f64 {
        self.maximum.value.abs().max(self.minimum.value.abs())
    }
}

/// Minimum and maximum position, velocity, acceleration and jerk of a course.
///
/// Where a derivative jumps, its values on both sides count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// Extremes of the position.
    pub position: MinMax,
    /// Extremes of the first derivative.
    pub velocity: MinMax,
    /// Extremes of the second derivative.
    pub acceleration: MinMax,
    /// Extremes of the third derivative.
    pub jerk: MinMax,
}

impl Extremes {
    /// Returns the extremes of a course followed by another.
    #[must_use]
    pub fn joined(self, next: Self) -> Self {
        Self {
            position: self.position.joined(next.position),
            velocity: self.velocity.joined(next.velocity),
            acceleration: self.acceleration.joined(next.acceleration),
            jerk: self.jerk.joined(next.jerk),
        }
    }
}
