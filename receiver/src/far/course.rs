//! Checks that far time passes as time does.

use coaxle_clock::{Instant, Remote, Span};
use coaxle_remote::FilterState;

/// Far time of an axis's set values from cycle to cycle.
#[derive(Debug, Default)]
pub(super) struct FarTimeCourse {
    last: Option<(FilterState, Instant<Remote>)>,
}

/// Advance of the far time in a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Advance {
    /// Advances with the time.
    By(Span),
    /// No motion advances so.
    Jump,
    /// The set values stand for no far time, or by another mode than before.
    Unknown,
}

impl FarTimeCourse {
    /// Compares the far time of this cycle and its mode with the previous cycle's; none if its set
    /// values stand for none. `passed` is the time since the previous cycle.
    ///
    /// Far time jumps if it moves back, or forward by more than twice the time passed: no motion
    /// does that. Beats do in mode bypass, on purpose, and a change of mode is blended.
    pub(super) fn advance(
        &mut self,
        mode: FilterState,
        far_time: Option<Instant<Remote>>,
        passed: Span,
    ) -> Advance {
        let now = far_time.map(|far_time| (mode, far_time));
        let before = std::mem::replace(&mut self.last, now);
        let (Some((mode_before, before)), Some((mode, now))) = (before, now) else {
            return Advance::Unknown;
        };
        // Instants of two modes differ by their corrections, which is no advance.
        if mode == FilterState::Bypass || mode != mode_before {
            return Advance::Unknown;
        }
        // Equal instants are a jump, too: far time goes strictly on.
        if now > before && now - before <= passed * 2 {
            Advance::By(now - before)
        } else {
            Advance::Jump
        }
    }

    /// Restarts: the next far time is unrelated to the previous one.
    pub(super) const fn forget(&mut self) {
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: Span = Span::from_millis(1);

    fn jumps(course: &mut FarTimeCourse, mode: FilterState, micros: i64) -> bool {
        let far_time = Instant::from_nanos(micros * 1_000);
        course.advance(mode, Some(far_time), CYCLE) == Advance::Jump
    }

    #[test]
    fn far_time_that_goes_back_or_on_too_fast_jumps() {
        for mode in [FilterState::Time, FilterState::Sync, FilterState::Observer] {
            let mut course = FarTimeCourse::default();
            let seen = [0, 1_000, 2_001, 2_002, 4_002, 4_002, 4_001, 6_002, 7_000];
            let found = seen.map(|micros| jumps(&mut course, mode, micros));
            let expected = [false, false, false, false, false, true, true, true, false];
            assert_eq!(found, expected, "{mode:?}");
        }
    }

    #[test]
    fn neither_beats_nor_changes_of_mode_are_jumps() {
        let mut course = FarTimeCourse::default();
        for micros in [0, 1_000, 1_000, 3_000] {
            assert!(!jumps(&mut course, FilterState::Bypass, micros));
        }
        assert!(!jumps(&mut course, FilterState::Time, 1_500));
        assert_eq!(
            course.advance(FilterState::Pt1, None, CYCLE),
            Advance::Unknown
        );
        assert!(!jumps(&mut course, FilterState::Time, 500));
        course.forget();
        assert!(!jumps(&mut course, FilterState::Time, 0));
    }
}
