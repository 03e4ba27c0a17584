//! Lines of the log about the health: each change, and reminders of a wait.

use coaxle_clock::{Instant, Span};
use coaxle_os::machine::Machine;

use super::health::Health;

/// Interval of the reminders that a node still waits.
// Often enough for a person who waits, and twelve lines a minute at most.
const REMINDER: Span = Span::from_secs(5);
/// Time in which counterparts usually appear; until then waiting is not worth a warning.
// Three attempts to connect (after 0.25, 0.5 and 1 s) lie within it.
const STARTUP_GRACE: Span = Span::from_secs(2);

/// Decides when a line about the health is due.
pub(super) struct HealthLog {
    last_word: Option<String>,
    next_reminder: Instant<Machine>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Note {
    Changed,
    StillWaiting,
}

impl HealthLog {
    pub(super) fn new(started: Instant<Machine>) -> Self {
        Self {
            last_word: None,
            // The first line about waiting comes after the grace, the next ones at the interval.
            next_reminder: started + STARTUP_GRACE,
        }
    }

    pub(super) fn next(
        &mut self,
        now: Instant<Machine>,
        health: Health,
        word: &str,
    ) -> Option<Note> {
        let first = self.last_word.is_none();
        let changed = self.last_word.as_deref() != Some(word);
        if changed {
            self.last_word = Some(word.to_owned());
        }
        // In the first moment no counterpart is known: not worth a line.
        if changed && !(first && health != Health::Ok) {
            // A change is as good as a reminder.
            self.next_reminder = now + REMINDER;
            return Some(Note::Changed);
        }
        if !is_in_order(health) && now >= self.next_reminder {
            self.next_reminder = now + REMINDER;
            return Some(Note::StillWaiting);
        }
        None
    }
}

/// True if the node needs nothing.
pub(super) fn is_in_order(health: Health) -> bool {
    matches!(health, Health::Ok | Health::ConnectionFlood)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_wait_is_reported_again_and_again_a_short_one_never() {
        let start = Instant::EPOCH;
        let mut log = HealthLog::new(start);
        let at = |secs: f64| start + Span::from_secs_f64(secs);
        let mut notes = Vec::new();
        for tick in 0..60 {
            let now = at(f64::from(tick) * 0.25);
            notes.extend(
                log.next(now, Health::Waiting, "waiting")
                    .map(|note| (note, now)),
            );
        }
        // The grace of 2 s, then every 5 s, until 15 s are over.
        assert_eq!(
            notes,
            [2.0, 7.0, 12.0].map(|secs| (Note::StillWaiting, at(secs)))
        );
        assert_eq!(log.next(at(15.0), Health::Ok, "ok"), Some(Note::Changed));
        assert_eq!(log.next(at(16.0), Health::Ok, "ok"), None);
        assert_eq!(
            log.next(at(16.5), Health::NoData, "no-data"),
            Some(Note::Changed)
        );

        // A flood is a change, and needs nothing of which to remind.
        let flood = Health::ConnectionFlood;
        let changed = log.next(at(17.0), flood, flood.as_str());
        assert_eq!(changed, Some(Note::Changed));
        assert_eq!(log.next(at(60.0), flood, flood.as_str()), None);

        // A counterpart within the grace: only its arrival is logged.
        let mut quick = HealthLog::new(start);
        assert_eq!(quick.next(at(0.1), Health::Waiting, "waiting"), None);
        assert_eq!(quick.next(at(0.6), Health::Ok, "ok"), Some(Note::Changed));
    }
}
