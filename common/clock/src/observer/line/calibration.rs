//! Calibration of the line's uncertainty by its own predictions.
//!
//! A filter that knows its noise and the clock misses its own predictions as its variances say: the innovations of some
//! seconds, summed up, scatter by `P(t|t − h) − P(t|t)` (the consistency test of Y. Bar-Shalom, X. R. Li and T.
//! Kirubarajan, Estimation with Applications to Tracking and Navigation, 5.4). Where delays are correlated, or the drift
//! changes as no random walk does, it misses by more. So the line is compared with its predictions, and its latest misses
//! are the least that its standard deviation can be.

use super::filter::Estimate;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the calibration.
    CalibrationTuning {
        /// Interval of looks at the line, s.
        look_interval: f64 = 0.25,
        /// A miss is to be within this number of standard deviations the next time.
        // It is the largest of a few, and the next one may be larger (observer_table, 12 seeds from 8 000 000, share within 3σ with 3 here: sine
        // 99.80, arrivals on 50 µs 99.46, walk of 1 ppm 99.58 %; with 2.5: 99.91, 99.68, 99.65 %).
        miss_sigmas: f64 = 2.5,
        /// A miss is forgotten with this time constant, s.
        // Disturbances that return every twenty seconds are not forgotten in between (13 seeds, a servo that sets back every ten seconds: 98.8 (96.6)
        // % with 30 s, 99.0 (97.1) % with 60 and an edge that is held at what it said; AR(1) 40 µs/5 s, stamped, the worst seed: 93.4 and 99.9 %).
        memory: f64 = 60.0,
        /// … and for longer where more predictions are missed than this part.
        // The factor is the part missed over this one, and `longest_times` at most.
        missed_part: f64 = 0.01,
        /// Greatest factor on `memory`.
        // Four minutes.
        longest_times: f64 = 4.0,
        /// The edge is no surer than this multiple of its latest uncertainty, once it is known for `known_after`.
        // Whether a calm spell is one of the path or the end of its troubles shows only afterwards (not held, 1 and 1.2, 13 seeds: the servo 98.3
        // (94.8), 99.0 (97.1) and 99.8 (98.6) %; AR(1) 40 µs/5 s, stamped, the worst seed 87.4, 99.9 and 100 %).
        held: f64 = 1.2,
        /// Age of a line, s, from which its edge is known.
        // As long as the choice takes to know both lines.
        known_after: f64 = 12.0,
        /// At first a miss is forgotten within this part of the time since the line began, which was still being found.
        early_part: f64 = 0.25,
        /// Comparisons that the share is over.
        // With three horizons four times a second, 80 s of them.
        share_looks: f64 = 960.0,
    }
}

/// … and the numbers of looks before with whose predictions it is compared: of a second to some seconds, none of which
/// is a multiple of the others, as a disturbance in step with a horizon does not show in it.
const HORIZONS: [usize; 3] = [4, 10, 22];
const KEPT: usize = HORIZONS[2];
/// Standard deviations within which the share counts predictions.
const COVERED: f64 = 3.0;

/// The line at one look.
#[derive(Clone, Copy, Debug)]
struct Look {
    time: f64,
    estimate: Estimate,
    /// Standard deviation of the line then, s.
    sigma: f64,
}

/// Compares the line with its own predictions.
#[derive(Clone, Debug)]
pub(in crate::observer) struct Calibration {
    looks: [Option<Look>; KEPT],
    next: usize,
    latest: f64,
    /// Time when the line began, s.
    began: Option<f64>,
    /// The least that the standard deviation can be, s.
    least: f64,
    within: f64,
    compared: f64,
}

impl Calibration {
    pub(in crate::observer) const fn new() -> Self {
        Self {
            looks: [None; KEPT],
            next: 0,
            latest: f64::NEG_INFINITY,
            began: None,
            least: 0.0,
            within: 0.0,
            compared: 0.0,
        }
    }

    /// Returns the standard deviation of the line, raised to its misses, s.
    pub(in crate::observer) fn of(&self, sigma: f64) -> f64 {
        sigma.max(self.least)
    }

    /// Share of the predictions that the line was within three standard deviations of; none before there were any.
    pub(in crate::observer) fn share(&self) -> Option<f64> {
        (self.compared > 0.0).then_some(self.within)
    }

    /// Remembers a bias of the line that measurements show, s².
    pub(in crate::observer) fn remember(&mut self, bias_variance: f64) {
        self.least = self.least.max(libm::sqrt(bias_variance));
    }

    /// Holds the uncertainty `sigma` of the lower edge.
    pub(in crate::observer) fn hold(&mut self, sigma: f64) {
        let is_known = (self.began).is_some_and(|began| self.latest - began > TUNING.known_after);
        if is_known {
            self.least = self.least.max(TUNING.held * sigma);
        }
    }

    /// Time constant of a miss, s, for a line of this age, s.
    fn remembered(&self, age: f64) -> f64 {
        // A clock that misses its predictions again and again is disturbed at longer intervals than `memory` covers.
        let missed = self.share().map_or(0.0, |share| 1.0 - share);
        let times = (missed / TUNING.missed_part).clamp(1.0, TUNING.longest_times);
        (TUNING.early_part * age).clamp(TUNING.look_interval, times * TUNING.memory)
    }

    /// Follows a jump of the clock or of the path, not of the line.
    pub(in crate::observer) fn shift(&mut self, by: f64) {
        for look in self.looks.iter_mut().flatten() {
            look.estimate.offset += by;
        }
    }

    /// Begins again with another line, of which nothing was predicted.
    pub(in crate::observer) fn begin_again(&mut self) {
        self.looks = [None; KEPT];
        self.began = None;
    }

    /// Looks at the line of deviation `sigma` at `time`, where its drift gains the variance `walk` per second.
    pub(in crate::observer) fn look(
        &mut self,
        time: f64,
        estimate: &Estimate,
        walk: f64,
        sigma: f64,
    ) {
        if time - self.latest < TUNING.look_interval {
            return;
        }
        let age = time - *self.began.get_or_insert(time);
        // The first look has no one before it, and the time since is infinite.
        let passed = (time - self.latest).min(TUNING.memory);
        self.latest = time;
        // Before the comparisons, whose misses are of now and count in full.
        self.least *= libm::exp(-passed / self.remembered(age));
        for horizon in HORIZONS {
            let before = self.looks[(self.next + KEPT - horizon) % KEPT];
            if let Some(before) = before {
                self.compare(time, estimate, walk, &before);
            }
        }
        // Raised, as it was reported: predictions are to be within what was said, not within the filter's own.
        let sigma = self.of(sigma);
        self.looks[self.next] = Some(Look {
            time,
            estimate: *estimate,
            sigma,
        });
        self.next = (self.next + 1) % KEPT;
    }

    fn compare(&mut self, time: f64, now: &Estimate, walk: f64, before: &Look) {
        let passed = time - before.time;
        let then = &before.estimate;
        let miss = libm::fabs(now.offset - then.offset - then.drift * passed);
        // A ratio, so that the raised deviation grows as the filter's does.
        let grown = then.offset_variance_after(passed, walk) / then.offset_variance;
        let predicted = before.sigma * libm::sqrt(grown);
        self.compared = (self.compared + 1.0).min(TUNING.share_looks);
        let is_within = f64::from(u8::from(miss <= COVERED * predicted));
        self.within += (is_within - self.within) / self.compared;
        // The part of the miss that the line is uncertain by before time passes.
        let least = miss / (TUNING.miss_sigmas * libm::sqrt(grown));
        self.least = self.least.max(least);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line as it is estimated to a microsecond, and off by `off`.
    fn line(off: f64) -> Estimate {
        Estimate {
            offset: off,
            drift: 0.0,
            offset_variance: 1e-12,
            covariance: 0.0,
            drift_variance: 1e-16,
        }
    }

    /// Looks at a line for a number of seconds.
    fn looked_at(seconds: u32, off: impl Fn(f64) -> f64) -> Calibration {
        let mut calibration = Calibration::new();
        for n in 0..4 * seconds {
            let time = TUNING.look_interval * f64::from(n);
            calibration.look(time, &line(off(time)), 1e-18, 1e-6);
        }
        calibration
    }

    #[test]
    fn a_line_that_keeps_to_what_it_says_is_left_alone() {
        let calibration = looked_at(60, |time| 0.5e-6 * libm::sin(time));
        assert_eq!(calibration.of(1e-6), 1e-6);
        assert_eq!(calibration.share(), Some(1.0));
        assert_eq!(Calibration::new().share(), None);
    }

    #[test]
    fn what_it_missed_by_is_remembered_and_forgotten() {
        let wanders = |time: f64| 6e-6 * libm::sin(time);
        let mut calibration = looked_at(300, wanders);
        let sigma = calibration.of(1e-6);
        assert!((3e-6..6e-6).contains(&sigma), "{sigma}");
        // The first misses were not expected; once they are, they are within what is said.
        let share = calibration.share().unwrap();
        assert!((0.8..1.0).contains(&share), "{share}");
        // Half a minute of calm does not make up for them.
        let mut calm = |from: u32, to: u32| {
            for n in 4 * from..4 * to {
                calibration.look(TUNING.look_interval * f64::from(n), &line(0.0), 1e-18, 1e-6);
            }
            calibration.of(1e-6)
        };
        assert!(calm(300, 330) > 0.5 * sigma);
        assert_eq!(calm(330, 900), 1e-6);
    }

    #[test]
    fn an_edge_that_becomes_sure_is_sure_only_later() {
        let mut calibration = Calibration::new();
        let mut look = |time: f64, sigma: f64| {
            calibration.look(time, &line(0.0), 1e-18, sigma);
            calibration.hold(sigma);
            calibration.of(sigma)
        };
        // As long as it is being found, it is as sure as it says.
        assert_eq!(look(0.0, 100e-6), 100e-6);
        assert_eq!(look(5.0, 5e-6), 5e-6);
        assert_eq!(look(13.0, 5e-6), TUNING.held * 5e-6);
        let soon = look(20.0, 1e-6);
        assert!((1.3e-6..6e-6).contains(&soon), "{soon}");
        for n in 0..40 {
            let _ = look(40.0 + 10.0 * f64::from(n), 1e-6);
        }
        assert_eq!(look(500.0, 1e-6), TUNING.held * 1e-6);
    }

    #[test]
    fn a_jump_of_the_clock_or_the_path_is_no_miss() {
        let mut calibration = Calibration::new();
        for n in 0..100 {
            let jumped = if n < 50 { 0.0 } else { 1e-3 };
            if n == 50 {
                calibration.shift(1e-3);
            }
            calibration.look(
                TUNING.look_interval * f64::from(n),
                &line(jumped),
                1e-18,
                1e-6,
            );
        }
        calibration.begin_again();
        calibration.look(25.0, &line(0.0), 1e-18, 1e-6);
        assert_eq!(
            (calibration.of(1e-6), calibration.share()),
            (1e-6, Some(1.0))
        );
    }

    /// Part of a miss that is left a minute later, in a line that has missed this part of its predictions.
    fn left_after_a_minute(missed: f64) -> f64 {
        let mut calibration = Calibration {
            latest: 3_600.0,
            began: Some(0.0),
            least: 1e-6,
            within: 1.0 - missed,
            compared: 1.0,
            ..Calibration::new()
        };
        calibration.look(3_660.0, &line(0.0), 1e-18, 0.0);
        calibration.of(0.0) * 1e6
    }

    #[test]
    fn a_line_that_misses_more_remembers_it_for_longer() {
        for (missed, left) in [
            (0.0, 0.36..0.38),
            (0.01, 0.36..0.38),
            (0.02, 0.57..0.65),
            (0.3, 0.74..0.80),
        ] {
            let after = left_after_a_minute(missed);
            assert!(left.contains(&after), "{missed}: {after}");
        }
    }

    #[test]
    fn the_share_is_of_the_last_two_minutes() {
        let mut calibration = looked_at(120, |time| 6e-6 * libm::sin(time * time));
        let mut missed_after_calm = |from: u32, to: u32| {
            for n in 4 * from..4 * to {
                calibration.look(TUNING.look_interval * f64::from(n), &line(0.0), 1e-18, 1e-3);
            }
            1.0 - calibration.share().unwrap()
        };
        let before = missed_after_calm(120, 140);
        let after = missed_after_calm(140, 220);
        assert!((0.32..0.42).contains(&(after / before)), "{after} {before}");
    }
}
