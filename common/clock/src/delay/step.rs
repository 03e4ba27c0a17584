//! Attribution of a step of the line to the path or to the sender's clock.
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

use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the attribution of a step.
    StepTuning {
        /// Asymmetry is learnt from steps of at least this much, s.
        // Smaller ones come and go with correlated delays.
        smallest_asymmetry: f64 = 50e-6,
        /// Growth of a path in a second that no path in use reaches, s.
        plain: f64 = 0.5e-3,
        /// A way changed as a row of the table says if it is off by at most this share of the step.
        fits: f64 = 0.25,
        /// The median of n ways is known well enough if this number of its standard deviations is at most `fits`.
        // 1.25·σ/√n each (a median's of a normal variable, whose quartiles are 1.35·σ apart), of those after the step and of about as many before.
        certain: f64 = 3.0,
    }
}

/// Exchanges before the step, and after it, that attribute it, …
pub(super) const TELLING: usize = 8;
/// … and their number where the jitter is too wide to show by how much the ways differ now: then the window is measured again.
const MOST: usize = 16;
const OF_QUARTILES: f64 = 1.25 / 1.35 * core::f64::consts::SQRT_2;

/// A step that is not attributed yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// Fall of the line, s.
    size: f64,
    /// The ways before, s.
    before: Ways,
    /// Movement of the ways before the step already, s.
    moving: f64,
    after: [Ways; MOST],
    len: usize,
}

/// Ways of a request and its response, measured against a line, s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ways {
    pub(super) there: f64,
    pub(super) back: f64,
}

impl Ways {
    /// Greater of the differences of either way, s.
    fn differ_from(&self, other: &Self) -> f64 {
        let there = libm::fabs(self.there - other.there);
        there.max(libm::fabs(self.back - other.back))
    }

    /// Median ways of a few.
    fn middle_of(few: &[Self]) -> Self {
        let mut ways = [[0.0; MOST]; 2];
        for (n, way) in few.iter().enumerate() {
            [ways[0][n], ways[1][n]] = [way.there, way.back];
        }
        let [there, back] = &mut ways;
        Self {
            there: median(&mut there[..few.len()]),
            back: median(&mut back[..few.len()]),
        }
    }

    /// Delay by these ways, s.
    pub(super) const fn delay(&self) -> f64 {
        0.5 * (self.there - self.back)
    }
}

/// Cause of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cause {
    /// The sender's clock stood still for this time, or leapt, s.
    Sender(f64),
    /// The way of the messages. Half of the difference of the ways there and back, which is what exchanges measure,
    /// is now off by this much more than before, s.
    Path { asymmetry: f64 },
}

impl Step {
    /// Makes a step of the line, which fell by `size`. The ways are what they usually were, and what the newest were.
    pub(super) fn new(size: f64, before: Ways, newest: Ways) -> Self {
        Self {
            size,
            before,
            moving: newest.differ_from(&before),
            after: [Ways::default(); MOST],
            len: 0,
        }
    }

    /// Adds a further fall by `size` before the cause was clear: both are taken together.
    pub(super) fn again(&self, size: f64) -> Self {
        Self {
            size: self.size + size,
            // Ways between both steps are of neither line, so whether they moved is unknown.
            moving: f64::INFINITY,
            len: 0,
            ..*self
        }
    }

    /// Takes the exchange of a request that left since. Returns the cause of the step, once that is clear.
    pub(super) fn take(&mut self, exchange: Ways) -> Option<Cause> {
        self.after[self.len] = exchange;
        self.len += 1;
        // At eight and at sixteen. Looking after each exchange would pass some row of the table by chance.
        if self.len < TELLING || !self.len.is_power_of_two() {
            return None;
        }
        let (there, of_there) = self.middle(|ways| ways.there);
        let (back, of_back) = self.middle(|ways| ways.back);
        let is_known = TUNING.certain * of_there.max(of_back) < TUNING.fits * libm::fabs(self.size);
        let is_certain = is_known && self.is_steady(self.newly_moving());
        let cause = self.cause(Ways { there, back }, is_certain);
        let cannot_tell = !self.is_steady(self.moving);
        let is_sender = matches!(cause, Cause::Sender(_));
        // More exchanges help where the jitter is wide, and not where the path itself moves.
        let is_told = is_certain || cannot_tell || is_sender || self.len == MOST;
        is_told.then_some(cause)
    }

    /// True if it was a step, and no path that grows or swings by as much meanwhile.
    fn is_steady(&self, moving: f64) -> bool {
        let size = libm::fabs(self.size);
        size >= TUNING.plain || moving < TUNING.fits * size
    }

    /// Movement of the ways before the step, or since.
    fn newly_moving(&self) -> f64 {
        let (older, newer) = self.after[..self.len].split_at(self.len / 2);
        let [older, newer] = [older, newer].map(Ways::middle_of);
        newer.differ_from(&older).max(self.moving)
    }

    /// Median of the ways since the step, and its standard deviation, s.
    fn middle(&self, way: impl Fn(&Ways) -> f64) -> (f64, f64) {
        let mut ways = [0.0; MOST];
        for (place, taken) in ways.iter_mut().zip(&self.after[..self.len]) {
            *place = way(taken);
        }
        let ways = &mut ways[..self.len];
        let n = ways.len();
        let mut at = |place: usize| *ways.select_nth_unstable_by(place, f64::total_cmp).1;
        let [lower, middle, upper] = [n / 4, (n - 1) / 2, n - 1 - n / 4].map(&mut at);
        // By the quartiles, as one way in eight is late by milliseconds.
        let sigma = OF_QUARTILES * (upper - lower) / libm::sqrt(n as f64);
        (middle, sigma)
    }

    fn cause(&self, after: Ways, is_certain: bool) -> Cause {
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
        let fits =
            libm::fabs(there - row.0) < TUNING.fits && libm::fabs(back - row.1) < TUNING.fits;
        let asymmetry = if fits && is_certain && libm::fabs(size) >= TUNING.smallest_asymmetry {
            // The delay was raised by the whole step. Exchanges now show half of the difference of the ways, (row.0 − row.1)/2 of
            // it.
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

    /// Cause of a step by eight exchanges, from the changes of the ways against the line that fell.
    fn cause(step: f64, there: f64, back: f64) -> Option<Cause> {
        let before = Ways {
            there: 3e-3,
            back: -1e-3,
        };
        let mut pending = Step::new(step, before, before);
        let (mut cause, mut taken) = (None, 0);
        while cause.is_none() {
            // One in eight is late.
            let late = if taken % 8 == 0 { 20e-3 } else { 1e-5 };
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

    /// Cause of a step where ways are up to `jitter` late, and the number of exchanges needed.
    fn cause_in_jitter(step: f64, there: f64, back: f64, jitter: f64) -> (Cause, usize) {
        let mut pending = Step::new(step, Ways::default(), Ways::default());
        for taken in 1_u32..=16 {
            let late = |seed: u32| {
                let part = f64::from((taken + seed).wrapping_mul(2_654_435_761) >> 16) / 65_536.0;
                jitter * (part - 0.5)
            };
            let exchange = Ways {
                there: there + late(0),
                back: back + late(77),
            };
            if let Some(cause) = pending.take(exchange) {
                return (cause, taken as usize);
            }
        }
        panic!("it is never told");
    }

    #[test]
    fn the_smaller_a_step_beside_the_jitter_the_more_exchanges_tell() {
        let s = 400e-6;
        let path = Cause::Path { asymmetry: 0.5 * s };
        assert_eq!(cause_in_jitter(s, s, 0.0, 40e-6), (path, 8));
        assert_eq!(cause_in_jitter(s, s, 0.0, 200e-6), (path, 16));
        // Jitter would say as much of a small one.
        let path = Cause::Path { asymmetry: 0.0 };
        assert_eq!(cause_in_jitter(s, s, 0.0, 400e-6), (path, 16));
        // Correlated delays do this.
        assert_eq!(cause_in_jitter(4e-5, 4e-5, 0.0, 1e-6), (path, 8));
    }

    #[test]
    fn each_row_of_the_table_is_told_from_the_others() {
        for s in [0.4e-3, -0.4e-3, 5e-3, -5e-3, 50e-3, -50e-3] {
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
            // Something else happened to the responses at that time.
            let path = Some(Cause::Path { asymmetry: 0.0 });
            assert_eq!(cause(s, s, 0.4 * s), path);
        }
    }

    #[test]
    fn two_steps_before_anything_is_clear_are_one() {
        let before = Ways::default();
        let mut step = Step::new(5e-3, before, before);
        assert_eq!(step.take(before), None);
        let mut step = step.again(7e-3);
        let causes = [(); TELLING].map(|()| step.take(before));
        let (last, others) = causes.split_last().unwrap();
        assert!(others.iter().all(Option::is_none), "they begin anew");
        assert_eq!(*last, Some(Cause::Sender(5e-3 + 7e-3)));
    }

    #[test]
    fn asymmetry_is_learnt_from_steps_that_correlated_delays_do_not_make() {
        let learnt = |s: f64| cause_in_jitter(s, s, 0.0, 1e-6).0;
        assert_eq!(learnt(40e-6), Cause::Path { asymmetry: 0.0 });
        assert_eq!(learnt(60e-6), Cause::Path { asymmetry: 30e-6 });
    }

    #[test]
    fn where_ways_move_only_a_step_beyond_any_growth_is_one() {
        // A path that had grown by 0.3 ms in the last second.
        let moving = Ways {
            there: 0.3e-3,
            back: 0.3e-3,
        };
        for (s, asymmetry) in [(0.45e-3, 0.0), (0.55e-3, 0.275e-3)] {
            let mut step = Step::new(s, Ways::default(), moving);
            let exchange = Ways {
                there: s,
                back: 0.0,
            };
            let cause = (0..TELLING).find_map(|_| step.take(exchange));
            assert_eq!(cause, Some(Cause::Path { asymmetry }), "{s}");
        }
    }
}
