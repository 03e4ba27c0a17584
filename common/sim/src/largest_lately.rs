//! The largest of the last values.

/// The largest value of the last stretch of time and the one before, each this long.
#[derive(Clone, Copy, Debug)]
pub struct LargestLately {
    length: f64,
    since: f64,
    now: f64,
    before: f64,
}

impl LargestLately {
    /// Remembers values for `length` to twice that, s.
    #[must_use]
    pub const fn over(length: f64) -> Self {
        Self {
            length,
            since: 0.0,
            now: 0.0,
            before: 0.0,
        }
    }

    /// Takes a value of at least 0, `passed` seconds after the one before.
    pub const fn push(&mut self, value: f64, passed: f64) {
        self.since += passed;
        // Two windows instead of a list: the maximum over one to two of them in constant memory.
        if self.since >= self.length {
            (self.before, self.now, self.since) = (self.now, 0.0, 0.0);
        }
        self.now = self.now.max(value);
    }

    /// Returns the largest one; 0 if there is none.
    #[must_use]
    pub const fn largest(&self) -> f64 {
        self.now.max(self.before)
    }
}
