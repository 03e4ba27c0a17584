//! Lag of the axes of a node that are shown later, and what it leaves for followers of the own node.

use coaxle_clock::{Seconds, Span};
use coaxle_remote::FilterMode;

use super::axis::Axis;
use super::{Candidate, FarNode, micros};
use crate::config::Lag;
use crate::hold_back::Spare;
use crate::signals::FarNodeSignals;

/// Hold-back of the slaves in a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldNow {
    pub(crate) by: Span,
    /// False before the first one is known: it would move the axes.
    pub(crate) is_decided: bool,
}

impl FarNode {
    /// Leaves this time to the drives of the slaves, of a full lag.
    pub(crate) fn with_dead_time(self, dead_time: Span) -> Self {
        Self { dead_time, ..self }
    }

    /// What its axes leave of the time by which they are shown later, of those that `count`.
    pub(crate) fn spare(&self, count: &[bool]) -> Spare {
        let node = self.followed();
        if node.news().header.is_none() {
            return Spare::Absent;
        }
        let is_now = !node.shows_by_clock();
        let mut measured = None;
        let axes = self.axes.iter().zip(count).filter(|(_, counts)| **counts);
        axes.fold(Spare::Absent, |spare, (axis, _)| {
            let own = match axis.delay().filter(|_| !is_now) {
                None if !axis.has_come() => Spare::Absent,
                // Shown now: so are its slaves.
                None => Spare::Is(Span::ZERO),
                Some(delay) => {
                    let measured = match self.lag {
                        Lag::Auto => *measured.get_or_insert_with(|| self.measured_lag()),
                        Lag::Full | Lag::Fixed(_) => None,
                    };
                    match self.lag.of(delay, measured, self.dead_time) {
                        Some(lag) => Spare::Is(delay - lag),
                        None => Spare::Pending,
                    }
                }
            };
            spare.and(own)
        })
    }

    /// Presentation delay with which its axes would find the frames that they need, and the drives of the slaves values that are known. None where the axes are
    /// shown now, and before it is known.
    pub(crate) fn wanted_delay(&self) -> Option<Span> {
        let is_later = self.followed().shows_by_clock() && self.axes.iter().any(Axis::may_be_later);
        let lag = match self.lag {
            _ if !is_later => return None,
            Lag::Fixed(lag) => lag.span(),
            Lag::Full | Lag::Auto => self.measured_lag()?,
        };
        Some(lag + self.dead_time)
    }

    /// Lag that the frames need, of the node that is followed and of those that may take over; none before it is known.
    fn measured_lag(&self) -> Option<Span> {
        if !self.followed().has_measured_delay() {
            return None;
        }
        let needed = (self.candidates.iter()).filter_map(Candidate::needed_delay);
        // A cycle and a quarter, for the rarest thousandth: over ways of 20 ± 10 ms with 5 % loss a sixteenth, the resolution of
        // the statistics, left cycles in which the axis was off by 57 µm (receiver/tests/pure/cascade.rs).
        needed
            .max()
            .map(|needed| needed + needed / 4 + self.cycle_time.span())
    }
}

impl Candidate {
    /// True if its axes are evaluated by its clock: in other modes they are shown as they come.
    fn shows_by_clock(&self) -> bool {
        let needs_none = matches!(self.clock.mode(), FilterMode::Bypass | FilterMode::Pt1);
        self.clock.is_enabled() && !needs_none
    }

    /// Delay that its frames need, with one cycle of each side: frames and cycles drift past each other. None before
    /// the first ages.
    pub(super) fn needed_delay(&self) -> Option<Span> {
        let cycles = self.news().header?.cycle_time.span() + self.cycle_time.span();
        Some(self.needed.needed()? + cycles)
    }

    /// True if that delay is known well enough to rely on it.
    pub(super) fn has_measured_delay(&self) -> bool {
        self.needed.is_measured()
    }

    /// Duration in its clock of a time of the own one.
    pub(super) fn in_its_clock(&self, own: Span) -> Seconds {
        if own == Span::ZERO {
            return Seconds::ZERO;
        }
        let by_observer = (self.clock.observation()).map(|observed| observed.observer.drift_ppm);
        let following = self.news().following.as_ref();
        let by_beats =
            following.map(|following| following.correction.time_sync.diagnostic.drift_ppm);
        let drift = by_observer.or(by_beats).unwrap_or(0.0);
        Seconds(own.as_secs_f64() * (1.0 + drift * 1e-6))
    }
}

/// Writes the lag of its axes, and how much longer it is than needed.
pub(super) fn show_lag(axes: &[Axis], signals: &mut FarNodeSignals) {
    signals.presentation_lag_us = micros(axes.iter().find_map(Axis::lag));
    let needed = signals.needed_present_after_us;
    signals.presentation_margin_us = signals
        .presentation_lag_us
        .zip(needed)
        .map(|(lag, needed)| lag - needed);
}
