//! Reasons to hold the slaves of a receiver back.

use coaxle_clock::Span;

use super::{Lag, MasterRef, ReceiverConfig};
use crate::hold_back::Spare;

impl ReceiverConfig {
    /// True if its slaves may be held back: otherwise nothing is kept for it.
    #[must_use]
    pub fn may_hold_back(&self) -> bool {
        let by_far = self.far.iter().any(|far| far.lag_ms != Lag::Full);
        let mut virtual_axes = self.virtual_axes.iter();
        by_far
            || virtual_axes.any(|axis| axis.present_after_ms.is_some())
            || self.longest_dead_time() > Span::ZERO
    }

    /// Longest dead time of a drive of its slaves, in whole cycles.
    pub(crate) fn longest_dead_time(&self) -> Span {
        let cycle = self.cycle_time_us.0.span();
        let slaves = self.slaves.iter();
        let longest = slaves.map(|slave| slave.dead_time_us.span()).max();
        let longest = longest.unwrap_or(Span::ZERO);
        // Rounded up: less would have to be predicted.
        cycle * -(Span::ZERO - longest).div_floor(cycle)
    }

    /// True for each far axis that leads a slave, or is published for others.
    #[must_use]
    pub fn far_axes_that_lead(&self) -> Vec<bool> {
        let published = self.published_far_axes();
        let leads = |axis| published.contains(&axis) || self.leads(MasterRef::Far(axis));
        (0..self.far_axes().count()).map(leads).collect()
    }

    /// Time that virtual axes with slaves leave, of that by which they are shown later.
    pub(crate) fn virtual_spare(&self) -> Spare {
        let axes = self.virtual_axes.iter().enumerate();
        let leading = axes.filter(|(n, _)| self.leads(MasterRef::Virtual(*n)));
        leading.fold(Spare::Absent, |spare, (_, axis)| {
            // Generated here and now: all of it is left.
            let delay = axis.present_after().map_or(Span::ZERO, |range| range.least);
            spare.and(Spare::Is(delay))
        })
    }

    fn leads(&self, master: MasterRef) -> bool {
        let mut slaves = 0..self.slaves.len();
        // A slave without valid masters is refused elsewhere.
        slaves.any(|n| self.masters_of(n).unwrap_or_default().contains(&master))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::test_config;

    fn config(rest: &str) -> ReceiverConfig {
        test_config::config(rest).expect("a config")
    }

    const SHAFT: &str = "[[virtual-axis]]\nid = 1\nname = 'shaft'\npresent-after-ms = 8\n\
                         program = { limits = { velocity = 360, acceleration = 720, jerk = 7200 } }\n";

    #[test]
    fn only_what_leads_has_a_say() {
        let far = "[[far]]\nnode = 'a'\naxes = ['1-3']\n";
        let slaves = "[[slave]]\nname = 'x'\nmaster = 'a.2'\n[[slave]]\nname = 'y'\nmaster = 'x'\n";
        let config_of = |head: &str| config(&format!("{head}{far}{slaves}"));
        assert!(!config_of("").may_hold_back());
        assert_eq!(config_of("").far_axes_that_lead(), [false, true, false]);
        let published = config_of("publish-far-axes = ['a.3']\n");
        assert_eq!(published.far_axes_that_lead(), [false, true, true]);
        assert!(config(&format!("{far}lag-ms = 'auto'")).may_hold_back());
    }

    #[test]
    fn a_dead_time_counts_in_whole_cycles() {
        let slave = "[[far]]\nnode = 'a'\n[[slave]]\nname = 'x'\n";
        let dead_time = |micros: f64| {
            let config = config(&format!("{slave}dead-time-us = {micros}"));
            (config.may_hold_back(), config.longest_dead_time())
        };
        assert_eq!(dead_time(0.0), (false, Span::ZERO));
        assert_eq!(dead_time(4_000.0), (true, Span::from_millis(4)));
        assert_eq!(dead_time(4_001.0), (true, Span::from_millis(5)));
    }

    #[test]
    fn a_virtual_axis_leaves_all_of_it() {
        let idle = config(SHAFT);
        assert!(idle.may_hold_back());
        assert_eq!(idle.virtual_spare(), Spare::Absent);
        let slave = "[[slave]]\nname = 'x'\nmaster = 'shaft'\n";
        let leading = config(&format!("{SHAFT}{slave}"));
        assert_eq!(leading.virtual_spare(), Spare::Is(Span::from_millis(8)));
        let now = SHAFT.replace("present-after-ms = 8\n", "");
        let both = format!(
            "{SHAFT}{}{slave}",
            now.replace("shaft", "other").replace("id = 1", "id = 2")
        );
        let both = config(&format!("{both}further-masters = ['other']"));
        assert_eq!(both.virtual_spare(), Spare::Is(Span::ZERO));
    }
}
