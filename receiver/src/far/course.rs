//! Whether far time goes on as time does.

use coaxle_clock::{Instant, Remote, Span};
use coaxle_remote::FilterState;

/// The far time that an axis stands for, from cycle to cycle.
#[derive(Debug, Default)]
pub(super) struct FarTimeCourse {
    last: Option<(FilterState, Instant<Remote>)>,
}

/// How far time went on in a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Advance {
    /// As time does.
    By(Span),
    /// In no way that anything moves.
    Jump,
    /// The set values stand for no far time, or by another mode than before.
    Unknown,
}

impl FarTimeCourse {
    /// The far time of this cycle, and by which mode; none where it stands for none. `passed` is the time since the
    /// cycle before.
    ///
    /// It jumps where it goes back, or on by more than twice as much as time did: nothing that moves does that. Beats
    /// do in mode bypass, on purpose, and a change of mode is blended over.
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
        if mode == FilterState::Bypass || mode != mode_before {
            return Advance::Unknown;
        }
        if now > before && now - before <= passed * 2 {
            Advance::By(now - before)
        } else {
            Advance::Jump
        }
    }

    /// What comes next has nothing to do with what was.
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
