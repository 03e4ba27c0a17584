//! The presentation delay that a node would need, by the ages of its newest frames.

use coaxle_clock::Span;

/// Time after which the older half of the ages is forgotten: the figure is that of the last minute, or half of it.
const HALF: Span = Span::from_secs(30);
/// Time after which the figure can be relied on.
const LEAST: Span = Span::from_secs(1);
/// Part of the cycles for which the delay may be too short.
const TOO_SHORT: f64 = 1e-3;
/// Resolution of the ages: 16 steps to each doubling, 4.4 %.
const STEP_BITS: u32 = 4;
/// Ages from 16 µs …
const LEAST_BITS: u32 = 14;
/// … to 4.3 s, which no presentation delay exceeds.
const MOST_BITS: u32 = 32;
const BINS: usize = ((MOST_BITS - LEAST_BITS) << STEP_BITS) as usize;
/// Ages between two calculations of the figure: it changes slowly, and takes a walk through all bins.
const BETWEEN: u32 = 64;

/// Statistics of the age of a node's newest frame at each cycle: a presentation delay of that length lets the cycle
/// interpolate.
#[derive(Clone, Debug)]
pub struct NeededDelay {
    now: Ages,
    before: Ages,
    since: Span,
    until_next: u32,
    needed: Option<Span>,
}

#[derive(Clone, Debug)]
struct Ages {
    bins: [u32; BINS],
    all: u32,
}

impl Ages {
    const NONE: Self = Self {
        bins: [0; BINS],
        all: 0,
    };
}

impl Default for NeededDelay {
    fn default() -> Self {
        Self {
            now: Ages::NONE,
            before: Ages::NONE,
            since: Span::ZERO,
            until_next: 0,
            needed: None,
        }
    }
}

impl NeededDelay {
    /// Takes the age of the newest frame in a cycle, `passed` after the one before.
    pub fn take(&mut self, age: Span, passed: Span) {
        self.since += passed;
        if self.since >= HALF {
            core::mem::swap(&mut self.before, &mut self.now);
            self.now = Ages::NONE;
            self.since = Span::ZERO;
        }
        let bin = &mut self.now.bins[bin_of(age)];
        // Half a minute of cycles of 100 µs are 300 000.
        *bin = bin.saturating_add(1);
        self.now.all = self.now.all.saturating_add(1);
        if self.until_next == 0 {
            self.until_next = BETWEEN;
            self.needed = Some(self.quantile());
        }
        self.until_next -= 1;
    }

    /// Forgets all ages: those of another run say nothing about this one.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Returns the age that 99.9 % of the recent cycles did not exceed; none before the first one.
    #[must_use]
    pub const fn needed(&self) -> Option<Span> {
        self.needed
    }

    /// True after a second of ages: before, a rare one may be missing.
    #[must_use]
    pub const fn is_measured(&self) -> bool {
        self.before.all > 0 || self.since.as_nanos() >= LEAST.as_nanos()
    }

    fn quantile(&self) -> Span {
        let all = f64::from(self.now.all) + f64::from(self.before.all);
        let mut above = 0.0;
        for bin in (0..BINS).rev() {
            above += f64::from(self.now.bins[bin]) + f64::from(self.before.bins[bin]);
            if above > all * TOO_SHORT {
                return end_of(bin);
            }
        }
        Span::ZERO
    }
}

fn bin_of(age: Span) -> usize {
    let nanos = age.as_nanos().max(1 << LEAST_BITS).unsigned_abs();
    let bits = nanos.ilog2();
    if bits >= MOST_BITS {
        return BINS - 1;
    }
    // The bits behind the first one.
    let step = (nanos >> (bits - STEP_BITS)) & ((1 << STEP_BITS) - 1);
    (((bits - LEAST_BITS) << STEP_BITS) as u64 + step) as usize
}

/// The longest age in a bin.
fn end_of(bin: usize) -> Span {
    let (bits, step) = (
        LEAST_BITS + (bin as u32 >> STEP_BITS),
        bin as i64 & ((1 << STEP_BITS) - 1),
    );
    Span::from_nanos(((1 << STEP_BITS) + step + 1) << (bits - STEP_BITS))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: Span = Span::from_millis(1);

    #[test]
    fn every_age_lies_within_the_end_of_its_bin_and_less_than_seven_percent_below() {
        for nanos in (20_000..4_000_000_000_i64).step_by(777_777) {
            let end = end_of(bin_of(Span::from_nanos(nanos))).as_nanos();
            assert!(
                nanos <= end && end as f64 <= nanos as f64 * 1.07,
                "{nanos} {end}"
            );
        }
        assert_eq!(bin_of(Span::from_secs(100)), BINS - 1);
        assert_eq!(bin_of(Span::from_millis(-3)), 0);
    }

    #[test]
    fn it_is_what_nearly_all_cycles_need_and_rare_ones_do_not_count() {
        let mut needed = NeededDelay::default();
        assert_eq!(needed.needed(), None);
        assert!(!needed.is_measured());
        for cycle in 0..60_000 {
            // 20 ms for most, 25 for one in a hundred, 300 for one in two thousand.
            let millis = match cycle {
                n if n % 2_000 == 7 => 300,
                n if n % 100 == 3 => 25,
                _ => 20,
            };
            needed.take(Span::from_millis(millis), CYCLE);
        }
        assert!(needed.is_measured());
        let found = needed.needed().unwrap();
        assert!(
            found >= Span::from_millis(25) && found < Span::from_millis(27),
            "{found}"
        );
    }

    #[test]
    fn what_is_long_ago_does_not_count() {
        let mut needed = NeededDelay::default();
        for (millis, cycles) in [(200, 10_000), (5, 61_000)] {
            for _ in 0..cycles {
                needed.take(Span::from_millis(millis), CYCLE);
            }
        }
        assert!(needed.needed().unwrap() < Span::from_millis(6));
        needed.clear();
        assert!(needed.needed().is_none() && !needed.is_measured());
    }
}
