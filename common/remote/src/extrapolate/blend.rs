//! The difference that a change of mode leaves, and how it goes.

use super::SetValues;

/// A difference of position that fades to nothing in a straight line.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Blend {
    /// At its beginning, u.
    difference: f64,
    /// Its length, s.
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

    /// A time later, s.
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
        self.difference * (self.left / self.length)
    }

    /// A mode's values, with the rest on top.
    pub(super) fn over(&self, aim: SetValues) -> SetValues {
        if self.is_over() {
            return aim;
        }
        SetValues {
            position: aim.position + self.rest(),
            velocity: aim.velocity - self.difference / self.length,
        }
    }
}
