//! The difference after a change of mode, and its decrease.

use super::SetValues;

/// A difference of position that fades to 0 in a straight line.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Blend {
    /// Initial difference, u.
    difference: f64,
    /// Length, s.
    length: f64,
    /// Seconds left.
    left: f64,
}

impl Blend {
    pub(super) fn starting(difference: f64, length: f64) -> Self {
        Self {
            difference,
            length,
            left: length,
        }
    }

    /// Advances by a time, s.
    pub(super) fn go_on(&mut self, passed: f64) {
        self.left -= passed;
    }

    pub(super) fn is_over(&self) -> bool {
        self.left <= 0.0
    }

    /// The part of the difference that is left, u.
    pub(super) fn rest(&self) -> f64 {
        if self.is_over() {
            return 0.0;
        }
        // Above 0 here: a blend of length 0 is over at once.
        self.difference * (self.left / self.length)
    }

    /// A mode's values, with the rest on top.
    pub(super) fn over(&self, aim: SetValues) -> SetValues {
        if self.is_over() {
            return aim;
        }
        SetValues {
            position: aim.position + self.rest(),
            // Slope of the straight line from the difference to 0: a coupling that uses velocities sees that of the
            // positions.
            velocity: aim.velocity - self.difference / self.length,
        }
    }
}
