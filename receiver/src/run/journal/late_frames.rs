//! Log events of frames that come too late for the instant at which they are to be shown.

use coaxle_clock::{Instant, Span};
use coaxle_os::Machine;

use super::{Level, Note};
use crate::signals::FarNodeSignals;

/// Time for which they have to be late: less than in a burst of loss that is soon over.
const PATIENCE: Span = Span::from_secs(10);

/// Frames of a node that is shown later.
#[derive(Debug, Default)]
pub(super) struct LateFrames {
    late_since: Option<Instant<Machine>>,
    is_told: bool,
}

impl LateFrames {
    /// Log line, once until they are in time again, with what would do.
    pub(super) fn too_late(&mut self, at: Instant<Machine>, now: &FarNodeSignals) -> Option<Note> {
        let late = now.presentation_lag_us.zip(now.presentation_margin_us);
        let Some((lag, margin)) = late.filter(|(_, margin)| *margin < 0.0) else {
            *self = Self::default();
            return None;
        };
        let since = *self.late_since.get_or_insert(at);
        if self.is_told || at - since < PATIENCE {
            return None;
        }
        self.is_told = true;
        // Upwards: a shortage that is rounded down would remain.
        let [lag, needed] = [lag, lag - margin].map(|micros| (micros / 1e2).ceil() / 10.0);
        let missing = (-margin / 1e2).ceil() / 10.0;
        Some(Note::new(
            Level::Warning,
            format!(
                "frames come too late to be shown between them, and some are predicted: received a lag of {lag} ms, \
                 expected at least {needed} ms: either present-after-ms at the first node longer by {missing} ms, or lag-ms \
                 of a node on the way shorter by as much"
            ),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signals(presentation_lag_us: Option<f64>, margin_us: f64) -> FarNodeSignals {
        FarNodeSignals {
            presentation_lag_us,
            presentation_margin_us: presentation_lag_us.map(|_| margin_us),
            ..FarNodeSignals::default()
        }
    }

    #[test]
    fn lasting_lateness_is_told_once_with_what_would_do() {
        let mut late = LateFrames::default();
        let at = |seconds| Instant::EPOCH + Span::from_secs(seconds);
        let mut told = |seconds, lag, margin| {
            (late.too_late(at(seconds), &signals(lag, margin))).map(|note| note.text)
        };
        assert_eq!(told(0, None, 0.0), None);
        assert_eq!(told(1, Some(20_000.0), -3_210.0), None);
        // In time once.
        assert_eq!(told(9, Some(20_000.0), 10.0), None);
        assert_eq!(told(12, Some(20_000.0), -3_210.0), None);
        let text = told(22, Some(20_000.0), -3_210.0).expect("a line");
        for part in ["a lag of 20 ms", "at least 23.3 ms", "longer by 3.3 ms"] {
            assert!(text.contains(part), "{text}");
        }
        assert_eq!(told(40, Some(20_000.0), -3_210.0), None);
    }
}
