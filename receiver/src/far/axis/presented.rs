//! Presentation of an axis: its values shown as much later as its frames say.

use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::FrameHeader;
use coaxle_remote::{FarCorrection, FrameHistory, ShownLater};

use super::Axis;

/// A delay that changes by no more than a cycle is followed at this part of the time: a cascade slews its own as slowly.
/// Anything more is another delay, to which the axis is brought.
const SLEW: f64 = 1e-3;

/// Newest frames of an axis, and the delay by which they are shown.
#[derive(Debug)]
pub(super) struct Presented {
    frames: FrameHistory,
    /// Delay in force; zero where the newest values are moved to now.
    by: Span,
    /// True if the newest cycle showed values between two frames.
    pub(super) is_interpolated: bool,
    /// Own cycles in which the frame that was needed had not arrived.
    pub(super) extrapolated: u64,
}

impl Presented {
    pub(super) fn new(cycle: CycleTime) -> Self {
        Self {
            frames: FrameHistory::new(cycle.span()),
            by: Span::ZERO,
            is_interpolated: false,
            extrapolated: 0,
        }
    }

    /// Forgets all frames: the next ones are unrelated to them.
    pub(super) fn clear(&mut self) {
        self.frames.clear();
    }

    /// Takes the set values of a frame.
    pub(super) fn take(&mut self, count: u64, set: &Kinematics) {
        self.frames.take(count, set);
    }

    /// Adopts the delay of the newest frame, `passed` after the previous cycle.
    pub(super) fn follow(&mut self, header: &FrameHeader, passed: Span) {
        let stated = header
            .present_after
            .map_or(Span::ZERO, |delay| delay.span());
        let change = stated - self.by;
        let is_slewed = self.by > Span::ZERO && change.abs() <= header.cycle_time.span();
        let most = Seconds(passed.as_secs_f64() * SLEW).to_span();
        self.by = match is_slewed && change.abs() > most {
            true if change > Span::ZERO => self.by + most,
            true => self.by - most,
            false => stated,
        };
        self.frames.prepare(self.by, header.cycle_time.span());
    }

    /// The frames and their delay, if they are shown later.
    pub(super) fn later(&self) -> Option<ShownLater<'_>> {
        (self.by > Span::ZERO).then(|| ShownLater {
            frames: &self.frames,
            by: Seconds(self.by.as_secs_f64()),
        })
    }

    /// True if the instant that is shown lies before the newest frame: a silence since then takes nothing away.
    pub(super) fn covers(&self, correction: &FarCorrection) -> bool {
        let known = correction.of_clock();
        self.by > Span::ZERO && known.is_some_and(|Seconds(age)| age <= self.by.as_secs_f64())
    }

    /// Notes how the newest cycle was calculated; `is_by_clock` in a mode that shows frames later.
    pub(super) fn note(&mut self, is_by_clock: bool, is_interpolated: bool, elapsed: u32) {
        self.is_interpolated = is_interpolated;
        if self.by > Span::ZERO && is_by_clock && !is_interpolated {
            self.extrapolated = self.extrapolated.saturating_add(elapsed.into());
        }
    }

    /// True if its frames are to be shown later.
    pub(super) fn is_in_force(&self) -> bool {
        self.by > Span::ZERO
    }
}

impl Axis {
    /// Forgets its frames: the next ones are unrelated to them.
    pub(super) fn forget_frames(&mut self) {
        if let Some(presented) = &mut self.presented {
            presented.clear();
        }
    }

    /// True if the frames that are shown have arrived, although they are shown later.
    pub(in super::super) fn covers(&self, correction: &FarCorrection) -> bool {
        let presented = self.presented.as_ref();
        presented.is_some_and(|presented| presented.covers(correction))
    }

    /// Adopts the presentation delay of the newest frame. Between values shown later and values as received lies the
    /// whole delay, over which a blend would be a straight line.
    pub(super) fn follow_presentation(
        &mut self,
        header: &FrameHeader,
        correction: &FarCorrection,
        elapsed: u32,
    ) {
        let Some(presented) = &mut self.presented else {
            return;
        };
        presented.follow(header, self.cycle_time * i64::from(elapsed));
        let shows = presented.is_in_force() && correction.time(correction.mode).is_some();
        if std::mem::replace(&mut self.showed_later, shows) != shows {
            self.begin_anew();
            self.rejoin();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::CycleIndex;
    use coaxle_node::PresentAfter;

    const CYCLE: Span = Span::from_millis(1);

    fn header(delay: Span) -> FrameHeader {
        FrameHeader {
            sender: 1,
            epoch: 1,
            index: CycleIndex(0),
            count: 0,
            cycle_time: CycleTime::new(CYCLE).unwrap(),
            present_after: PresentAfter::new(delay),
            send_stamp: None,
        }
    }

    #[test]
    fn a_delay_is_adopted_at_once_and_small_changes_are_slewed() {
        let mut presented = Presented::new(CycleTime::new(CYCLE).unwrap());
        assert!(presented.later().is_none());
        let mut follow = |micros| {
            presented.follow(&header(Span::from_micros(micros)), CYCLE);
            presented.by.as_nanos()
        };
        assert_eq!(follow(20_000), 20_000_000);
        // By a microsecond a millisecond, either way, and to the end.
        assert_eq!(follow(20_800), 20_001_000);
        assert_eq!(follow(19_500), 20_000_000);
        assert_eq!(follow(20_001), 20_001_000);
        // Another delay, and none.
        assert_eq!(follow(30_000), 30_000_000);
        assert_eq!(follow(0), 0);
        assert_eq!(follow(500), 500_000);
    }
}
