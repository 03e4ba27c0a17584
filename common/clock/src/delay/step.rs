//! Whose a step of the line was: the path's, or the sender's clock's.
//!
//! Messages come later by `s` from one to the next. Either their way has become longer, or the sender's clock
//! stood still for as long. One-way messages look alike in both cases; exchanges do not. Against the line that
//! fell by `s` with them:
//!
//! ```text
//!                               way there    way back
//! the sender's clock stopped        0            0        the sender fell as the line did
//! all ways are longer by s         2·s           0
//! messages and responses are        s            0
//! messages alone are                s           −s
//! ```
//!
//! So where both ways are what they were, it was the sender.

/// So many exchanges before the step, and after it, tell whose it was.
pub(super) const TELLING: usize = 8;
/// Asymmetry is learnt from steps of at least this much, s: jitter is hardly half of a quarter of it.
const SMALLEST_ASYMMETRY: f64 = 0.5e-3;
/// A way changed as a row of the table says if it is off by at most this share of the step.
const FITS: f64 = 0.25;

/// A step that nobody has told yet whose it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// The line fell by so much, s.
    size: f64,
    /// The ways before, s.
    before: Ways,
    after: [Ways; TELLING],
    len: usize,
}

/// How long a request and its response were under way, measured against a line, s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ways {
    pub(super) there: f64,
    pub(super) back: f64,
}

impl Ways {
    /// The delay that they say, s.
    pub(super) const fn delay(&self) -> f64 {
        0.5 * (self.there - self.back)
    }
}

/// Whose it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cause {
    /// The sender's clock stood still for so long, or leapt, s.
    Sender(f64),
    /// The way of the messages. Half of the difference of the ways there and back, which is what exchanges
    /// measure, is now off by so much more than before, s.
    Path { asymmetry: f64 },
}

impl Step {
    /// The line fell by `size`.
    pub(super) fn new(size: f64, before: Ways) -> Self {
        Self {
            size,
            before,
            after: [Ways::default(); TELLING],
            len: 0,
        }
    }

    /// It fell again, by `size`, before it was clear why: both are taken together.
    pub(super) fn again(&self, size: f64) -> Self {
        Self::new(self.size + size, self.before)
    }

    /// Takes the exchange of a request that left since. Gives whose the step was, once that is clear.
    pub(super) fn take(&mut self, exchange: Ways) -> Option<Cause> {
        self.after[self.len] = exchange;
        self.len += 1;
        if self.len < TELLING {
            return None;
        }
        let mut there = self.after.map(|ways| ways.there);
        let mut back = self.after.map(|ways| ways.back);
        let after = Ways {
            there: median(&mut there),
            back: median(&mut back),
        };
        Some(self.cause(after))
    }

    fn cause(&self, after: Ways) -> Cause {
        let size = self.size;
        let there = (after.there - self.before.there) / size;
        let back = (after.back - self.before.back) / size;
        if libm::fabs(there) < 0.5 && libm::fabs(back) < 0.5 {
            return Cause::Sender(size);
        }
        // Requests take the longer way or not, and responses do or not.
        let row = (
            libm::round(there).clamp(1.0, 2.0),
            libm::round(back).clamp(-1.0, 0.0),
        );
        let fits = libm::fabs(there - row.0) < FITS && libm::fabs(back - row.1) < FITS;
        let asymmetry = if fits && libm::fabs(size) >= SMALLEST_ASYMMETRY {
            size * (1.0 - 0.5 * (row.0 - row.1))
        } else {
            0.0
        };
        Cause::Path { asymmetry }
    }
}

/// The middle one, or the lower of two; of at least one value.
pub(super) fn median(values: &mut [f64]) -> f64 {
    let middle = (values.len() - 1) / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What eight exchanges say of a step, by how much the ways changed against the line that fell.
    fn cause(step: f64, there: f64, back: f64) -> Option<Cause> {
        let before = Ways {
            there: 3e-3,
            back: -1e-3,
        };
        let mut pending = Step::new(step, before);
        let (mut cause, mut taken) = (None, 0);
        while cause.is_none() {
            // One in four is late.
            let late = if taken % 4 == 0 { 20e-3 } else { 1e-5 };
            let ways = Ways {
                there: before.there + there + late,
                back: before.back + back + late,
            };
            cause = pending.take(ways);
            taken += 1;
        }
        assert_eq!(taken, TELLING);
        cause
    }

    #[test]
    fn each_row_of_the_table_is_told_from_the_others() {
        for s in [5e-3, -5e-3, 50e-3, -50e-3] {
            assert_eq!(
                cause(s, 0.0, 0.0),
                Some(Cause::Sender(s)),
                "the sender's clock"
            );
            for (there, back, asymmetry) in [
                (2.0 * s, 0.0, 0.0),
                (s, 0.0, 0.5 * s),
                (s, -s, 0.0),
                (2.0 * s, -s, -0.5 * s),
            ] {
                let path = Some(Cause::Path { asymmetry });
                assert_eq!(cause(s, there, back), path, "{there} there, {back} back");
            }
            // Something else happened to the responses at the same time.
            let path = Some(Cause::Path { asymmetry: 0.0 });
            assert_eq!(cause(s, s, 0.4 * s), path);
        }
        // Jitter would say as much of a small one.
        let path = Some(Cause::Path { asymmetry: 0.0 });
        assert_eq!(cause(3e-4, 3e-4, 0.0), path);
    }

    #[test]
    fn two_steps_before_anything_is_clear_are_one() {
        let before = Ways::default();
        let mut step = Step::new(5e-3, before);
        assert_eq!(step.take(before), None);
        let mut step = step.again(7e-3);
        let causes = [(); TELLING].map(|()| step.take(before));
        let (last, others) = causes.split_last().unwrap();
        assert!(others.iter().all(Option::is_none), "they begin anew");
        assert_eq!(*last, Some(Cause::Sender(5e-3 + 7e-3)));
    }
}
