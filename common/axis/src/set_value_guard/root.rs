//! Where a rising function passes through zero.

/// Enough for any function here: every third step halves the interval, and the others do better by far.
const MOST_STEPS: u32 = 36;

/// The fraction of the interval that the root is found within.
const PRECISION: f64 = 1e-11;

/// The largest argument from `low` to `high` at which a rising function is not above zero; `low` where
/// there is none.
///
/// Illinois (the false position that halves the value of an end which stays), with a bisection every third
/// step; the function is evaluated at most [`MOST_STEPS`] + 2 times.
#[inline]
pub(super) fn last_not_above(low: f64, high: f64, rising: impl Fn(f64) -> f64) -> f64 {
    let at_high = rising(high);
    if at_high <= 0.0 {
        return high;
    }
    let at_low = rising(low);
    if at_low < 0.0 {
        Bracket::new(low, high, at_low, at_high).narrowed(rising)
    } else {
        low
    }
}

/// The root lies between.
struct Bracket {
    low: f64,
    high: f64,
    /// The values there, or part of them.
    at_low: f64,
    at_high: f64,
    low_stayed: bool,
    high_stayed: bool,
}

impl Bracket {
    const fn new(low: f64, high: f64, at_low: f64, at_high: f64) -> Self {
        Self {
            low,
            high,
            at_low,
            at_high,
            low_stayed: false,
            high_stayed: false,
        }
    }

    fn narrowed(mut self, rising: impl Fn(f64) -> f64) -> f64 {
        let enough = PRECISION * (self.high - self.low);
        for step in 1..=MOST_STEPS {
            if self.high - self.low <= enough {
                break;
            }
            let at = self.next(step, enough);
            let value = rising(at);
            if value == 0.0 {
                return at;
            }
            self.replace(at, value);
        }
        self.low
    }

    fn next(&self, step: u32, enough: f64) -> f64 {
        let rise = self.at_high - self.at_low;
        if step.is_multiple_of(3) || !rise.is_finite() {
            return f64::midpoint(self.low, self.high);
        }
        let at = self.low - self.at_low / rise * (self.high - self.low);
        // A step past the root, so that its other end comes close too.
        at.max(self.low + 0.5 * enough)
            .min(self.high - 0.5 * enough)
    }

    fn replace(&mut self, at: f64, value: f64) {
        if value > 0.0 {
            (self.high, self.at_high) = (at, value);
            if self.low_stayed {
                self.at_low /= 2.0;
            }
            (self.low_stayed, self.high_stayed) = (true, false);
        } else {
            (self.low, self.at_low) = (at, value);
            if self.high_stayed {
                self.at_high /= 2.0;
            }
            (self.low_stayed, self.high_stayed) = (false, true);
        }
    }
}
