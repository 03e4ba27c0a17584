//! A common time with injected faults.

use coaxle_clock::Span;
use coaxle_wire::beacon::CommonStamp;

use super::random::Random;
use crate::config::CommonTimeFaults;

/// Faults of the common time that a node reads.
#[derive(Clone, Debug)]
pub struct FaultyCommonTime {
    faults: CommonTimeFaults,
    random: Random,
}

impl FaultyCommonTime {
    /// Makes the faults, with noise drawn from `seed`.
    #[must_use]
    pub fn new(faults: &CommonTimeFaults, seed: u64) -> Self {
        Self {
            faults: faults.clone(),
            random: Random::new(seed),
        }
    }

    /// Applies the faults to a reading, `since` the start; none while the time is lost.
    pub fn applied(&mut self, since: Span, reading: CommonStamp) -> Option<CommonStamp> {
        let mut stamp = reading;
        let mut is_lost = false;
        let mut off = Span::ZERO;
        for change in &self.faults.changes {
            let passed = since - change.at_s.span();
            if passed < Span::ZERO {
                continue;
            }
            off += change.offset_us.span()
                + Span::from_secs_f64(passed.as_secs_f64() * change.drift_ppm.get() * 1e-6);
            is_lost = change.lost.unwrap_or(is_lost);
            if let Some(grandmaster) = change.grandmaster {
                stamp.grandmaster = grandmaster.number();
            }
        }
        // Drawn in any case, so that a change leaves the noise as it was.
        let noise = self.faults.noise_us.get() * self.random.normal();
        off += Span::from_micros_f64(noise);
        stamp.time_ns = stamp.time_ns.saturating_add(off.as_nanos());
        (!is_lost).then_some(stamp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse;

    #[test]
    fn leaps_add_up_a_free_run_grows_and_what_is_lost_comes_back() {
        let faults: CommonTimeFaults = parse(
            "test",
            "changes = [{ at-s = 10, offset-us = 20 }, { at-s = 20, drift-ppm = 0.5 }, { at-s = 30, lost = true },
            { at-s = 40, lost = false, grandmaster = '0000000000000002', offset-us = -5 }]",
        )
        .unwrap();
        let mut common = FaultyCommonTime::new(&faults, 1);
        let reading = CommonStamp {
            time_ns: 1_000,
            grandmaster: 1,
            ..CommonStamp::default()
        };
        let mut at = |seconds| {
            let stamp = common.applied(Span::from_secs(seconds), reading);
            stamp.map(|stamp| (stamp.time_ns - 1_000, stamp.grandmaster))
        };
        assert_eq!(at(9), Some((0, 1)));
        assert_eq!(at(10), Some((20_000, 1)));
        assert_eq!(at(24), Some((22_000, 1)));
        assert_eq!(at(35), None);
        assert_eq!(at(40), Some((25_000, 2)));
    }
}
