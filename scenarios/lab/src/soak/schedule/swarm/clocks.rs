//! Clocks of a swarm schedule.

use std::fmt::Write as _;

use super::super::QUIET_FROM;
use super::super::draw::Draw as _;
use super::SwarmSchedule;
use super::features::Feature;

/// Longest leap of a clock back, s, during which its node stands still, …
pub(super) const LEAP_BACK: f64 = 5.0;
/// … and ahead, by which its axes are farther on at once.
const LEAP_AHEAD: f64 = 10.0;

impl SwarmSchedule {
    /// A clock with this drift, ppm.
    pub(super) fn clock(&mut self, drift: f64) -> String {
        let [clock_faults, leaps, first_counts] =
            [Feature::ClockFaults, Feature::Leaps, Feature::FirstCounts]
                .map(|feature| self.features.has(feature));
        let base = &mut self.base;
        let mut clock = format!(
            "clock = {{ drift-ppm = {drift:.1}, start-phase-us = {}, jitter = {{ exponential-us = {} }}",
            base.random.whole(0, 900),
            base.random.whole(1, 60),
        );
        if first_counts && base.random.chance(0.7) {
            let wrap = *base.random.one_of(&[1_u64 << 31, 1 << 32]);
            // Within the first 6 s at 1 ms: while there are faults.
            let before = base.random.whole(0, 6_000);
            let _ = write!(clock, ", first-count = {}", wrap - before);
        }
        let mut steps = Vec::new();
        if clock_faults {
            if base.random.chance(0.3) {
                let walk = base.random.between(0.01, 1.0);
                let _ = write!(clock, ", random-walk-ppm = {walk:.2}");
            }
            if base.random.chance(0.6) {
                steps.push(base.clock_step());
            }
            steps.extend(base.extra_draws.step_back());
            if let Some(terms) = base.extra_draws.drift_terms() {
                let _ = write!(clock, ", {terms}");
            }
        }
        if leaps && base.random.chance(0.5) {
            let back = base.random.chance(0.5);
            let longest = if back { LEAP_BACK } else { LEAP_AHEAD };
            let leap = base.random.decades(0.01, longest) * if back { -1e6 } else { 1e6 };
            let at = base.moment(QUIET_FROM);
            steps.push(format!("{{ at-s = {at}, phase-us = {leap:.0} }}"));
        }
        if !steps.is_empty() {
            let _ = write!(clock, ", steps = [{}]", steps.join(", "));
        }
        clock + " }\n"
    }
}
