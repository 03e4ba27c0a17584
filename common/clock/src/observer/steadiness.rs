//! How well a line predicts itself.
//!
//! Clocks run straight for seconds. A line that is not where it predicted some seconds ago followed
//! something else than a clock.

/// A line is looked at so often, s, …
const EVERY: f64 = 0.5;
/// … and compared with its prediction of so many looks before.
const AHEAD: usize = 8;
/// The usual miss is the one that two thirds of so many are not beyond, once there are enough.
const KEPT: usize = 32;
const ENOUGH: usize = 5;

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
        }
    }

    /// By how much it usually missed itself, s; none if there was too little to compare.
    pub(super) const fn usual_miss(&self) -> Option<f64> {
        self.usual
    }

    /// The line as it is at `time`. Says whether it was looked at, which is not always.
    pub(super) fn look(&mut self, time: f64, offset: f64, drift: f64) -> bool {
        if time - self.latest < EVERY {
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
        if self.seen < AHEAD {
            self.seen += 1;
            return true;
        }
        let miss = offset - before.offset - before.drift * (time - before.time);
        self.misses[self.count % KEPT] = libm::fabs(miss);
        self.count += 1;
        self.usual = self.measured();
        true
    }

    fn measured(&self) -> Option<f64> {
        let n = self.count.min(KEPT);
        let mut misses = self.misses;
        let place = 2 * n / 3;
        (n >= ENOUGH).then(|| *misses[..n].select_nth_unstable_by(place, f64::total_cmp).1)
    }

    /// The clock or the path jumped, not the line.
    pub(super) fn shift(&mut self, by: f64) {
        for look in &mut self.looks {
            look.offset += by;
        }
    }
}
