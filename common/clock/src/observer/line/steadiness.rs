//! Steadiness of a line: how well it predicts itself.
//!
//! Clocks run straight for seconds. A line that is not where it predicted some seconds ago followed
//! something else than a clock.

use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the comparison of a line with its own prediction.
    SteadinessTuning {
        /// Interval of looks at a line, s.
        // That of points on the edge.
        look_interval: f64 = 0.5,
        /// Misses from which there is a usual one.
        enough: usize = 5,
        /// Time for which a miss is remembered, s.
        // A calm spell proves nothing (with 60 s two seeds of 60 of AR(1) 40 µs/5 s leave the edge too early).
        memory: f64 = 200.0,
    }
}

/// … and the number of looks before whose prediction it is compared with.
const AHEAD: usize = 8;
/// Misses kept, two thirds of which are not beyond the usual one, once there are enough.
const KEPT: usize = 32;

#[derive(Clone, Copy, Debug, Default)]
struct Look {
    time: f64,
    offset: f64,
    drift: f64,
}

/// Compares a line with its own prediction.
#[derive(Clone, Debug)]
pub(super) struct Steadiness {
    looks: [Look; AHEAD],
    next: usize,
    seen: usize,
    latest: f64,
    /// The latest misses, s.
    misses: [f64; KEPT],
    count: usize,
    usual: Option<f64>,
    /// The largest usual miss, little by little forgotten, s.
    lasting: f64,
}

impl Steadiness {
    pub(super) const fn new() -> Self {
        Self {
            looks: [Look {
                time: 0.0,
                offset: 0.0,
                drift: 0.0,
            }; AHEAD],
            next: 0,
            seen: 0,
            latest: f64::NEG_INFINITY,
            misses: [0.0; KEPT],
            count: 0,
            usual: None,
            lasting: 0.0,
        }
    }

    /// Usual miss of the line, s; none if there was too little to compare.
    pub(super) const fn usual_miss(&self) -> Option<f64> {
        self.usual
    }

    /// Usual miss, in which a calm spell counts little.
    pub(super) fn lasting_miss(&self) -> Option<f64> {
        self.usual.map(|usual| usual.max(self.lasting))
    }

    /// Looks at the line as it is at `time`. Returns whether it did, which is not always.
    pub(super) fn look(&mut self, time: f64, offset: f64, drift: f64) -> bool {
        if time - self.latest < TUNING.look_interval {
            return false;
        }
        self.latest = time;
        let before = self.looks[self.next];
        self.looks[self.next] = Look {
            time,
            offset,
            drift,
        };
        self.next = (self.next + 1) % AHEAD;
        // The ring holds blanks until it was filled once.
        if self.seen < AHEAD {
            self.seen += 1;
            return true;
        }
        // Against the drift of then: a line that bent meanwhile followed something else than the clock.
        let miss = offset - before.offset - before.drift * (time - before.time);
        self.misses[self.count % KEPT] = libm::fabs(miss);
        self.count += 1;
        self.usual = self.measured();
        // Falls slowly and rises at once, so that a calm spell does not make up for a storm.
        self.lasting *= 1.0 - TUNING.look_interval / TUNING.memory;
        self.lasting = self.lasting.max(self.usual.unwrap_or(0.0));
        true
    }

    fn measured(&self) -> Option<f64> {
        let n = self.count.min(KEPT);
        let mut misses = self.misses;
        // A quantile and not a mean, as a single jump of the delay is a miss of its full height.
        let place = 2 * n / 3;
        (n >= TUNING.enough).then(|| *misses[..n].select_nth_unstable_by(place, f64::total_cmp).1)
    }

    /// Follows a jump of the clock or of the path, not of the line.
    pub(super) fn shift(&mut self, by: f64) {
        for look in &mut self.looks {
            look.offset += by;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks every half a second at a line that is `off` a straight one.
    fn miss(steadiness: &mut Steadiness, looks: u32, off: impl Fn(u32) -> f64) -> Option<f64> {
        for n in 0..looks {
            let time = TUNING.look_interval * f64::from(n);
            assert!(steadiness.look(time, 1e-3 + 2e-5 * time + off(n), 2e-5));
            // Not yet again.
            assert!(!steadiness.look(time + 0.9 * TUNING.look_interval, 1.0, 1.0));
        }
        steadiness.usual_miss()
    }

    #[test]
    fn a_straight_line_does_not_miss_itself() {
        let mut steadiness = Steadiness::new();
        let enough = (AHEAD + TUNING.enough) as u32;
        assert_eq!(miss(&mut steadiness, enough - 1, |_| 0.0), None);
        let usual = miss(&mut Steadiness::new(), enough, |_| 0.0).unwrap();
        assert!(usual < 1e-15, "{usual}");
    }

    #[test]
    fn what_a_line_wobbles_by_is_its_miss() {
        // A period of sixteen looks: after eight it is on the other side.
        let off = |n: u32| 5e-6 * libm::sin(core::f64::consts::TAU * f64::from(n) / 16.0);
        let usual = miss(&mut Steadiness::new(), 100, off).unwrap();
        assert!((5e-6..10e-6).contains(&usual), "{usual}");
    }

    #[test]
    fn a_calm_spell_does_not_make_up_for_a_miss() {
        let mut steadiness = Steadiness::new();
        let wobbling = |n: u32| if n % 16 < 8 { 5e-6 } else { -5e-6 };
        let stormy = miss(&mut steadiness, 60, wobbling).unwrap();
        for n in 60..120 {
            let _ = steadiness.look(TUNING.look_interval * f64::from(n), 0.0, 0.0);
        }
        assert!(steadiness.usual_miss().unwrap() < 1e-12);
        let lasting = steadiness.lasting_miss().unwrap();
        assert!((0.8 * stormy..stormy).contains(&lasting), "{lasting}");
        for n in 120..460 {
            let _ = steadiness.look(TUNING.look_interval * f64::from(n), 0.0, 0.0);
        }
        // Three minutes of calm do.
        let left = steadiness.lasting_miss().unwrap() / stormy;
        assert!((0.33..0.45).contains(&left), "{left}");
        for n in 460..4_000 {
            let _ = steadiness.look(TUNING.look_interval * f64::from(n), 0.0, 0.0);
        }
        assert!(steadiness.lasting_miss().unwrap() < 0.01 * stormy);
    }

    #[test]
    fn a_few_misses_are_not_usual() {
        let off = |n: u32| if n < 60 { 0.0 } else { 1e-3 };
        let usual = miss(&mut Steadiness::new(), 100, off).unwrap();
        assert!(usual < 1e-15, "{usual}");
    }

    #[test]
    fn a_jump_of_the_clock_is_no_miss() {
        let mut steadiness = Steadiness::new();
        let mut jumped = 0.0;
        for n in 0..100 {
            if n % 7 == 6 {
                jumped += 1e-3;
                steadiness.shift(1e-3);
            }
            let _ = steadiness.look(f64::from(n), jumped, 0.0);
        }
        assert!(steadiness.usual_miss().unwrap() < 1e-15);
    }
}
