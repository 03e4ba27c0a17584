//! Log events of the delay measurement.

use coaxle_clock::delay::DelayState;
use coaxle_clock::{Instant, Span};
use coaxle_os::Machine;

use super::{Level, Note};
use crate::signals::FarNodeSignals;

/// Time after which unanswered requests to a node with a known clock are worth a line: some ten
/// requests are sent every second, and a few responses suffice.
const PATIENCE: Span = Span::from_secs(6);

/// Log line on a measured delay, or a measurement that grew old.
pub(super) fn delay(before: &FarNodeSignals, now: &FarNodeSignals) -> Option<Note> {
    if before.delay_state == now.delay_state {
        return None;
    }
    // NaN in a line says that there is none. A 0 would be a delay.
    let value = now.delay_us.unwrap_or(f64::NAN);
    match now.delay_state? {
        DelayState::Measured => Some(Note::new(
            Level::Info,
            format!(
                "delay measured: {value:.1} µs, at most {:.1} µs off",
                now.delay_uncertainty_us.unwrap_or(f64::NAN)
            ),
        )),
        DelayState::Stale => Some(Note::new(
            Level::Warning,
            format!(
                "the master responds to no time requests any more; the delay stays {value:.1} µs"
            ),
        )),
        DelayState::Off | DelayState::Fixed | DelayState::Asking => None,
    }
}

/// Log line on a configured asymmetry that is impossible.
pub(super) fn denied(before: &FarNodeSignals, now: &FarNodeSignals) -> Option<Note> {
    let is_news = now.asymmetry_denied && !before.asymmetry_denied;
    is_news.then(|| {
        Note::new(
            Level::Warning,
            format!(
                "asymmetry: the ways to the master and back cannot differ by as much as it states: both together take less. The delay \
                 stays {:.1} µs, at most {:.1} µs off",
                now.delay_us.unwrap_or(f64::NAN),
                now.delay_uncertainty_us.unwrap_or(f64::NAN)
            ),
        )
    })
}

/// State of the time requests to a node.
#[derive(Debug, Default)]
pub(super) struct Asked {
    /// Time for which its clock was known. A receiver that is synced only at times waits longer,
    /// and reports it too.
    waited: Span,
    /// The last check, if its clock was known then.
    looked: Option<Instant<Machine>>,
    is_told: bool,
}

impl Asked {
    /// Log line, once, on a node that has never responded although its clock is known.
    pub(super) fn in_vain(&mut self, at: Instant<Machine>, now: &FarNodeSignals) -> Option<Note> {
        if now.delay_state != Some(DelayState::Asking) {
            // Any other state ends the wait: a later one has a line of its own.
            *self = Self::default();
            return None;
        }
        let looked = std::mem::replace(&mut self.looked, now.synced.then_some(at));
        if let (Some(looked), true) = (looked, now.synced) {
            // Only between two looks with a known clock. The time between an unknown and a known one does not count.
            self.waited += at - looked;
        }
        if self.is_told || self.waited < PATIENCE {
            return None;
        }
        self.is_told = true;
        Some(Note::new(
            Level::Warning,
            format!(
                "the master has responded to no time request ({} responses refused): its axes lag by the delay; \
                 in a secure network one of the two may have no rights at the other",
                now.responses_refused
            ),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_statement_that_cannot_be_is_a_warning_once() {
        let fine = FarNodeSignals::default();
        let denied_now = FarNodeSignals {
            asymmetry_denied: true,
            ..FarNodeSignals::default()
        };
        let note = denied(&fine, &denied_now).unwrap();
        assert_eq!(note.level, Level::Warning);
        assert!(denied(&denied_now, &denied_now).is_none());
        assert!(denied(&denied_now, &fine).is_none());
    }

    #[test]
    fn a_node_that_never_responds_is_told_of_once() {
        let mut asked = Asked::default();
        let mut signals = FarNodeSignals {
            synced: true,
            delay_state: Some(DelayState::Asking),
            ..FarNodeSignals::default()
        };
        let mut told_at = |signals: &FarNodeSignals, seconds: std::ops::Range<i64>| {
            let at = |second| Instant::EPOCH + Span::from_secs(second);
            let told = |second: &i64| asked.in_vain(at(*second), signals).is_some();
            seconds.filter(told).collect::<Vec<_>>()
        };
        assert_eq!(told_at(&signals, 0..20), [6]);
        signals.delay_state = Some(DelayState::Measured);
        assert!(told_at(&signals, 20..40).is_empty());
        signals.delay_state = Some(DelayState::Asking);
        assert_eq!(told_at(&signals, 40..60), [46]);
        signals.synced = false;
        assert!(told_at(&signals, 60..80).is_empty());
    }

    #[test]
    fn one_whose_clock_is_known_now_and_then_is_told_of_later() {
        let mut asked = Asked::default();
        let told_at = (0..40).filter(|second| {
            let signals = FarNodeSignals {
                synced: second % 4 != 0,
                delay_state: Some(DelayState::Asking),
                ..FarNodeSignals::default()
            };
            let at = Instant::EPOCH + Span::from_secs(*second);
            asked.in_vain(at, &signals).is_some()
        });
        assert_eq!(told_at.collect::<Vec<_>>(), [11]);
    }
}
