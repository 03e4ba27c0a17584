//! Limits by direction, where [`Limits`](super::Limits) has them by faster and slower.

/// What a motion keeps within that has to do with a moving line: from where the line is seen, speeding up
/// and slowing down are something else than for the axis, but up and down are the same.
///
/// `lowest` is below `highest`, u/s; `up` bounds positive accelerations and `down` the magnitude of
/// negative ones, u/s²; `jerk` is in u/s³. The last three are above zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// The lowest velocity, u/s.
    pub lowest: f64,
    /// The highest velocity, u/s.
    pub highest: f64,
    /// The largest acceleration, u/s².
    pub up: f64,
    /// The largest acceleration in the negative direction, as a magnitude, u/s².
    pub down: f64,
    /// The largest jerk, u/s³.
    pub jerk: f64,
}

impl Band {
    /// The same limits seen from the other side.
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
