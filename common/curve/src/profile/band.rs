//! Limits by direction, where [`Limits`](super::Limits) has them for speeding up and slowing down.

/// Limits of a motion relative to a moving line: seen from the line, speeding up and slowing down are
/// different than for the axis, but up and down are the same.
///
/// `lowest` is below `highest`, u/s; `up` bounds positive accelerations and `down` the magnitude of
/// negative ones, u/s²; `jerk` is in u/s³. The last three are above zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// The least velocity, u/s.
    pub lowest: f64,
    /// The greatest velocity, u/s.
    pub highest: f64,
    /// The greatest acceleration, u/s².
    pub up: f64,
    /// The greatest acceleration in the negative direction, as a magnitude, u/s².
    pub down: f64,
    /// The greatest jerk, u/s³.
    pub jerk: f64,
}

impl Band {
    /// Returns the limits mirrored.
    pub(super) fn mirrored(&self) -> Self {
        Self {
            lowest: -self.highest,
            highest: -self.lowest,
            up: self.down,
            down: self.up,
            jerk: self.jerk,
        }
    }
}
