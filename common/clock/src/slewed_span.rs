//! A duration that changes slowly: the time by which something is shown later.

use crate::Span;

/// A duration that is led to another along a quintic, at no more than 0.94 ‰ of the time: what is shown that much later moves by so much faster or
/// slower meanwhile.
///
/// ```
/// use coaxle_clock::{SlewedSpan, Span};
///
/// let mut delay = SlewedSpan::new(Span::from_millis(20));
/// delay.lead_by(Span::from_millis(1));
/// delay.advance(Span::from_secs(1));
/// assert_eq!(delay.now(), Span::from_micros(20_500));
/// delay.advance(Span::from_secs(1));
/// assert_eq!(delay.now(), Span::from_millis(21));
/// ```
#[derive(Clone, Debug, Default)]
pub struct SlewedSpan {
    now: Span,
    course: Option<SlewedChange>,
}

/// A change that is under way.
#[derive(Clone, Copy, Debug)]
struct SlewedChange {
    from: Span,
    change: Span,
    passed: Span,
    lasts: Span,
}

impl SlewedSpan {
    /// Duration of a change by the change: its greatest rate is 15/8 of their quotient, 0.94 ‰.
    // A step of the rate would be one of the velocity, which no limited axis follows. With a quintic the set values of an axis at
    // 1 m/s are accelerated by 2 mm/s² over a change by a millisecond.
    const SLOWNESS: i64 = 2_000;
    /// Greatest change at once, which takes 10 s: then the need is looked at again.
    pub const MOST_AT_ONCE: Span = Span::from_millis(5);

    /// Creates one with this duration.
    #[must_use]
    pub const fn new(now: Span) -> Self {
        Self { now, course: None }
    }

    /// The duration now.
    #[must_use]
    pub const fn now(&self) -> Span {
        self.now
    }

    /// Moves on by this time. Returns false if no change is under way.
    pub fn advance(&mut self, passed: Span) -> bool {
        let Some(course) = &mut self.course else {
            return false;
        };
        course.passed += passed;
        self.now = course.at();
        if course.passed >= course.lasts {
            self.course = None;
        }
        true
    }

    /// Takes this duration at once.
    pub fn set(&mut self, now: Span) {
        *self = Self::new(now);
    }

    /// Begins a change towards this duration, by no more than `most`.
    pub fn lead_to(&mut self, target: Span, most: Span) {
        self.lead_by((target - self.now).clamp(Span::ZERO - most, most));
    }

    /// Begins a change by this time.
    pub fn lead_by(&mut self, change: Span) {
        self.course = Some(SlewedChange {
            from: self.now,
            change,
            passed: Span::ZERO,
            lasts: change.abs() * Self::SLOWNESS,
        });
    }
}

impl SlewedChange {
    fn at(&self) -> Span {
        if self.passed >= self.lasts {
            return self.from + self.change;
        }
        let x = self.passed.as_secs_f64() / self.lasts.as_secs_f64();
        let share = x * x * x * (10.0 + x * (6.0 * x - 15.0));
        let part = self.change.as_nanos() as f64 * share;
        self.from + Span::from_nanos(part as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_slow_and_ends_where_it_should() {
        for change in [7, -7] {
            let mut delay = SlewedSpan::new(Span::from_millis(20));
            assert!(!delay.advance(Span::from_millis(1)));
            delay.lead_by(Span::from_millis(change));
            let mut before = delay.now();
            let mut cycles = 0;
            while delay.advance(Span::from_millis(1)) {
                let step = (delay.now() - before).abs();
                assert!(step <= Span::from_nanos(940), "{step}");
                before = delay.now();
                cycles += 1;
            }
            assert_eq!(delay.now(), Span::from_millis(20 + change));
            assert_eq!(cycles, 14_000);
        }
    }
}
