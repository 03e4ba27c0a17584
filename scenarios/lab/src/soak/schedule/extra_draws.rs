//! Occasional draws from random streams of their own: terms of drifts and delays, clocks that jump back, axes that are
//! shown later, and lags. A seed without them keeps its earlier schedule.

use coaxle_node::faults::{Random, seed_of};

use super::late_draws::without;
use super::{Draw as _, QUIET_FROM, before_followers};

/// End of the lines that were drawn last of all: without them a schedule is what it was before ([`before_lags`]).
const OF_LAGS: &str = "# a lag";

/// The schedule that its seed gave before lags and followers were drawn: seeds that failed earlier are kept as they failed.
#[must_use]
pub fn before_lags(schedule: &str) -> String {
    without(&before_followers(schedule), OF_LAGS)
}

/// The separate random stream.
pub(super) struct ExtraDraws {
    random: Random,
    /// That of the presentation, which came later.
    presentation: Random,
    /// That of the lags, which came after it.
    lags: Random,
    /// True once a sender shows its axes later.
    is_presented: bool,
    /// True once a virtual axis of a receiver is.
    is_virtual_presented: bool,
}

impl ExtraDraws {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            // Draws from the common stream would shift all later ones, and turn the known regressions into other schedules.
            random: Random::new(seed_of(seed, "apart")),
            presentation: Random::new(seed_of(seed, "presentation")),
            lags: Random::new(seed_of(seed, "lags")),
            is_presented: false,
            is_virtual_presented: false,
        }
    }

    /// Terms of a clock's drift: a little more than a quartz has that warms up.
    pub(super) fn drift_terms(&mut self) -> Option<String> {
        self.sum(0.25, 10.0, 30.0)
            .map(|sum| format!("drift-terms-ppm = {sum}"))
    }

    /// Terms of a link's delay.
    pub(super) fn delay_terms(&mut self) -> Option<String> {
        self.sum(0.25, 100.0, 50.0)
            .map(|sum| format!("delay-terms-us = {sum}"))
    }

    /// A step of a clock's reading back, during the faulty phase.
    pub(super) fn step_back(&mut self) -> Option<String> {
        self.random.chance(0.15).then(|| {
            let at = self.random.between(0.5, QUIET_FROM);
            // Up to 300 ms: within the silence that the blocks tolerate at 1 ms, and beyond it at 0.5 ms.
            let by = self.random.between(-300_000.0, -1.0);
            format!("{{ at-s = {at:.3}, phase-us = {by:.1} }}")
        })
    }

    /// Line of all axes of a sender with this cycle time, µs, that are shown later; mostly none.
    pub(super) fn present_after(&mut self, cycle: u64) -> String {
        let random = &mut self.presentation;
        if !random.chance(0.2) {
            return String::new();
        }
        // From too short for the way to longer than the bursts of loss: a cycle at least.
        self.is_presented = true;
        let millis = random.decades(0.5, 300.0).max(cycle as f64 * 1e-3);
        format!("present-after-ms = {millis:.3}\n")
    }

    /// Line of a receiver that shows its masters now, whatever their frames say; mostly none.
    pub(super) fn present(&mut self) -> &'static str {
        match self.is_presented && self.presentation.chance(0.2) {
            true => "present = 'now'\n",
            false => "",
        }
    }

    /// Line of a receiver whose slaves are held back by a part of the time by which its masters are shown later.
    pub(super) fn lag(&mut self) -> String {
        let lags = &mut self.lags;
        let is_presented = self.is_presented || self.is_virtual_presented;
        if !is_presented || lags.chance(0.4) {
            return String::new();
        }
        let lag = match lags.chance(0.4) {
            true => "'auto'".to_owned(),
            // As the times that are drawn: too short for the way, a part of it, or all of it.
            false => format!("{:.3}", lags.decades(0.5, 300.0)),
        };
        format!("lag-ms = {lag} {OF_LAGS}\n")
    }

    /// Line of a virtual axis of a receiver with this cycle time, µs, that is shown later; mostly none.
    pub(super) fn virtual_present_after(&mut self, cycle: u64) -> String {
        let lags = &mut self.lags;
        if !lags.chance(0.25) {
            return String::new();
        }
        self.is_virtual_presented = true;
        let cycle = cycle as f64 * 1e-3;
        // A cycle to the greatest number of cycles by which slaves are held back, as far as that is shorter.
        let millis = lags.decades(0.5, 300.0).clamp(cycle, 1_000.0 * cycle);
        format!("present-after-ms = {millis:.3} {OF_LAGS}\n")
    }

    /// Draws terms of at most this amount in a share of all cases, the slow ones with periods from this on.
    fn sum(&mut self, share: f64, most: f64, slow_s: f64) -> Option<String> {
        if !self.random.chance(share) {
            return None;
        }
        let count = self.random.whole(1, 3);
        let terms: Vec<_> = (0..count).map(|_| self.term(most, slow_s)).collect();
        Some(format!("[{}]", terms.join(", ")))
    }

    fn term(&mut self, most: f64, slow_s: f64) -> String {
        let amount = self.random.between(-most, most);
        // Slow: at most 10 ppm or 100 µs over half a minute or more.
        let period = self.random.between(slow_s, 4.0 * slow_s);
        let (share, at) = (self.random.uniform(), self.random.between(0.0, 30.0));
        match self.random.below(8) {
            0 => format!("{{ constant = {amount:.2} }}"),
            1 => wave("sine", amount, period, share),
            2 => wave("triangle", amount, period, share),
            3 => format!(
                "{{ pulse = {{ height = {amount:.2}, period-s = {period:.2}, duty = {share:.3} }} }}"
            ),
            4 => {
                format!("{{ step = {{ at-s = {at:.3}, by = {amount:.2}, over-s = {period:.2} }} }}")
            }
            5 => format!(
                "{{ uniform = {{ from = {:.2}, to = {amount:.2} }} }}",
                -amount
            ),
            // Tails of noise reach far beyond its mean.
            6 => format!("{{ exponential = {:.2} }}", amount.abs() / 10.0),
            _ => format!("{{ normal = {:.2} }}", amount.abs() / 10.0),
        }
    }
}

fn wave(kind: &str, amplitude: f64, period: f64, phase: f64) -> String {
    format!(
        "{{ {kind} = {{ amplitude = {amplitude:.2}, period-s = {period:.2}, phase = {phase:.3} }} }}"
    )
}
