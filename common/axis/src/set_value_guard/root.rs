//! Root of a rising function.

/// Number of steps for roots about as large as their interval: every third step halves that, and
/// the others converge far faster.
const USUAL_STEPS: u32 = 36;

/// Greatest number of steps. From [`USUAL_STEPS`] on every third one halves the interval in its
/// exponent, then in its digits: one step finds the sign, eight the exponent (from 1e-24 on, within
/// a factor of four), forty the digits.
const MOST_STEPS: u32 = USUAL_STEPS + 3 * (1 + 8 + 40);

/// Precision of a root, relative to its interval, and to its own size if that is less,
const PRECISION: f64 = 1e-11;
/// and the size that counts as zero: at limits of 1e15 and cycles of 10 ms that is 1e-15 u.
const NOTHING: f64 = 1e-24;

/// Two ends that differ by more than this factor are halved in their exponent.
const WIDE: f64 = 4.0;

/// The largest argument from `low` to `high` at which a rising function is not above zero; `low` if
/// there is none.
///
/// Illinois (the false position that halves the value of an end which stays), with a bisection every third
/// step; the function is evaluated at most [`MOST_STEPS`] + 2 times, usually a dozen.
#[inline]
pub(super) fn last_not_above(low: f64, high: f64, rising: impl Fn(f64) -> f64) -> f64 {
    // Ends first: on most of its way an axis uses its jerk fully, and one or two evaluations are enough.
    let at_high = rising(high);
    if at_high <= 0.0 {
        return high;
    }
    let at_low = rising(low);
    // Not for NaN: then the lower end is returned, as for a function above 0.
    if at_low < 0.0 {
        Bracket::new(low, high, at_low, at_high).narrowed(rising)
    } else {
        low
    }
}

/// Interval that contains the root.
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
        let interval = self.high - self.low;
        for step in 1..=MOST_STEPS {
            let size = self.low.abs().max(self.high.abs());
            let enough = (PRECISION * size.min(interval)).max(NOTHING);
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
        // The side not above 0, as promised: of a wall that is the side before it.
        self.low
    }

    fn next(&self, step: u32, enough: f64) -> f64 {
        let rise = self.at_high - self.at_low;
        // False position alone may creep towards a root where the function bends.
        if step.is_multiple_of(3) || !rise.is_finite() {
            return self.middle(step);
        }
        let at = self.low - self.at_low / rise * (self.high - self.low);
        // A step past the root, so that its other end approaches too.
        at.max(self.low + 0.5 * enough)
            .min(self.high - 0.5 * enough)
    }

    fn middle(&self, step: u32) -> f64 {
        let (low, high) = (self.low, self.high);
        if step <= USUAL_STEPS {
            return f64::midpoint(low, high);
        }
        // Ends of different signs have no common exponent to halve.
        if low < 0.0 && high > 0.0 {
            return 0.0;
        }
        let (least, most) = (low.abs().min(high.abs()), low.abs().max(high.abs()));
        if most > WIDE * least {
            // Geometric mean: halves the difference of the exponents. The floor keeps it from 0, which has none.
            libm::sqrt(least.max(NOTHING) * most).copysign(low + high)
        } else {
            f64::midpoint(low, high)
        }
    }

    fn replace(&mut self, at: f64, value: f64) {
        if value > 0.0 {
            (self.high, self.at_high) = (at, value);
            if self.low_stayed {
                self.at_low /= 2.0;
            }
            // Illinois: an end that stays twice loses half of its value, which draws the next step towards it.
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
