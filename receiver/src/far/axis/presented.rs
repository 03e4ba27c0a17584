//! Presentation of an axis: its values shown as much later as its frames say.

use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::{FrameHeader, PresentAfter};
use coaxle_remote::{FarCorrection, FrameHistory, ShownLater};

use super::{Axis, AxisScan};

/// A delay that changes from frame to frame by no more than a cycle, and this part of the time between them, is slewed: a cascade
/// and a delay that followers decide change as slowly. The axis follows it as slowly.
/// Anything more is another delay, to which the axis is brought.
const SLEW: f64 = 1e-3;

/// Newest frames of an axis, and the delay by which they are shown.
#[derive(Debug)]
pub(super) struct Presented {
    frames: FrameHistory,
    /// Count of the newest frame that was followed, and the delay that it states.
    newest: Option<(u64, Span)>,
    /// Delay in force; zero where the newest values are moved to now.
    by: Span,
    /// Part of it by which the axis is evaluated later, in the far clock's time: the slaves are held back by the rest.
    lag: Seconds,
    /// True if the newest cycle showed values between two frames.
    pub(super) is_interpolated: bool,
    /// Own cycles in which the frame that was needed had not arrived.
    pub(super) extrapolated: u64,
}

/// Circumstances of a cycle in which a delay is followed.
#[derive(Clone, Copy, Debug)]
pub(super) struct PresentedNow {
    /// Time since the cycle before.
    passed: Span,
    /// Age of the newest frame, if the clock is known.
    age: Option<Seconds>,
    /// Hold-back: the part of the delay that slaves wait for.
    held: Seconds,
    /// True if the cycle before showed values by a delay.
    was_shown: bool,
}

impl Presented {
    pub(super) fn new(cycle: CycleTime) -> Self {
        Self {
            frames: FrameHistory::new(cycle.span()),
            newest: None,
            by: Span::ZERO,
            lag: Seconds::ZERO,
            is_interpolated: false,
            extrapolated: 0,
        }
    }

    /// Forgets all frames: the next ones are unrelated to them.
    pub(super) fn clear(&mut self) {
        self.frames.clear();
        self.newest = None;
    }

    /// Takes the set values of a frame, and the delay that it states.
    pub(super) fn take(&mut self, count: u64, set: &Kinematics, stated: Option<PresentAfter>) {
        self.frames.take(count, set, delay_of(stated));
    }

    /// Follows the delay that the frames state.
    pub(super) fn follow(&mut self, header: &FrameHeader, now: &PresentedNow) {
        let cycle = header.cycle_time.span();
        let newest = delay_of(header.present_after);
        let is_another = self.is_another_delay(header.count, newest, cycle);
        self.newest = Some((header.count, newest));
        if is_another {
            // Frames from before are shown by it, too.
            self.frames.restate(newest);
            self.by = newest;
        } else if newest != self.by {
            // A delay that is slewed belongs to the frame that states it, which may be shown only long after.
            let stated = now
                .age
                .and_then(|Seconds(age)| self.frames.delay_at(self.lag.0 - age));
            let stated = stated.map_or(newest, Seconds::to_span);
            let most = match now.was_shown {
                true => Seconds(now.passed.as_secs_f64() * SLEW).to_span(),
                // Nothing has been shown by the delay of before: another mode was in force, or the clock was unknown.
                false => Span::MAX,
            };
            self.by += (stated - self.by).clamp(Span::ZERO - most, most);
        }
        self.frames.prepare(self.by, cycle);
        // A hold-back beyond the delay would be a guess.
        self.lag = Seconds((self.by.as_secs_f64() - now.held.0).max(0.0));
    }

    /// True if a delay is not the one of the frame before, nor slewed since.
    fn is_another_delay(&self, count: u64, delay: Span, cycle: Span) -> bool {
        let Some((count_before, before)) = self.newest else {
            return true;
        };
        // Mostly it is constant.
        if delay == before {
            return false;
        }
        let change = (delay - before).abs().as_secs_f64();
        let between = count.saturating_sub(count_before) as f64 * cycle.as_secs_f64();
        let is_none = before == Span::ZERO || delay == Span::ZERO;
        is_none || change > cycle.as_secs_f64() + between * SLEW
    }

    /// The frames and their delay, if they are shown later.
    pub(super) fn later(&self) -> Option<ShownLater<'_>> {
        self.is_in_force().then_some(ShownLater {
            frames: &self.frames,
            by: self.lag,
        })
    }

    /// True if the instant that is shown lies before the newest frame: a silence since then takes nothing away.
    pub(super) fn covers(&self, correction: &FarCorrection) -> bool {
        let known = correction.of_clock();
        self.is_in_force() && known.is_some_and(|Seconds(age)| age <= self.lag.0)
    }

    /// Notes how the newest cycle was calculated.
    pub(super) fn note(&mut self, is_interpolated: bool, is_predicted: bool, elapsed: u32) {
        self.is_interpolated = is_interpolated;
        if self.is_in_force() && is_predicted {
            self.extrapolated = self.extrapolated.saturating_add(elapsed.into());
        }
    }

    /// True if its frames are to be shown later.
    pub(super) fn is_in_force(&self) -> bool {
        self.lag > Seconds::ZERO
    }
}

fn delay_of(stated: Option<PresentAfter>) -> Span {
    stated.map_or(Span::ZERO, PresentAfter::span)
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

    /// The time by which it is shown later, as its frames state; none where it is shown now whatever they state.
    pub(in super::super) fn delay(&self) -> Option<Span> {
        let by = self.presented.as_ref()?.by;
        (by > Span::ZERO).then_some(by)
    }

    /// True unless it is shown now whatever its frames state.
    pub(in super::super) const fn may_be_later(&self) -> bool {
        self.presented.is_some()
    }

    /// Lag of the axis; none where it is shown now.
    pub(in super::super) fn lag(&self) -> Option<Seconds> {
        let presented = self.presented.as_ref().filter(|_| self.showed_later)?;
        Some(presented.lag)
    }

    /// Adopts the presentation delay of the newest frame. Between values shown later and values as received lies the
    /// whole delay, over which a blend would be a straight line.
    pub(super) fn follow_presentation(
        &mut self,
        header: &FrameHeader,
        correction: &FarCorrection,
        scan: &AxisScan<'_>,
    ) {
        let Some(presented) = &mut self.presented else {
            return;
        };
        let age = correction.time(correction.mode);
        let now = PresentedNow {
            passed: self.cycle_time * i64::from(scan.elapsed),
            age,
            held: scan.held,
            was_shown: self.showed_later,
        };
        presented.follow(header, &now);
        let shows = presented.is_in_force() && age.is_some();
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

    fn now(held: f64) -> PresentedNow {
        PresentedNow {
            passed: CYCLE,
            age: Some(Seconds::ZERO),
            held: Seconds(held),
            was_shown: true,
        }
    }

    #[test]
    fn a_delay_is_adopted_at_once_and_small_changes_are_slewed() {
        let mut presented = Presented::new(CycleTime::new(CYCLE).unwrap());
        assert!(presented.later().is_none());
        let mut follow = |micros| {
            let header = header(Span::from_micros(micros));
            presented.follow(&header, &now(100e-6));
            let lag = presented.by.as_secs_f64() - 100e-6;
            assert!((presented.lag.0 - lag.max(0.0)).abs() < 1e-12);
            presented.by.as_nanos()
        };
        assert_eq!(follow(20_000), 20_000_000);
        // By a microsecond a millisecond, either way, and to the end.
        assert_eq!(follow(20_800), 20_001_000);
        assert_eq!(follow(19_900), 20_000_000);
        assert_eq!(follow(20_001), 20_001_000);
        // Another delay, and none.
        assert_eq!(follow(30_000), 30_000_000);
        assert_eq!(follow(0), 0);
        assert_eq!(follow(500), 500_000);
    }

    /// Swarm 81667: back from another mode, an axis took 0.33 s to come to the delay of its master, and was that much off until then.
    #[test]
    fn what_was_not_shown_is_not_slewed() {
        let mut presented = Presented::new(CycleTime::new(CYCLE).unwrap());
        presented.follow(&header(Span::from_micros(20_000)), &now(0.0));
        let elsewhere = PresentedNow {
            was_shown: false,
            ..now(0.0)
        };
        presented.follow(&header(Span::from_micros(20_400)), &elsewhere);
        assert_eq!(presented.by, Span::from_micros(20_400));
    }

    /// While a delay of seconds is slewed, the frames that are shown are more than a cycle behind what the newest states.
    #[test]
    fn a_long_delay_is_slewed_by_more_than_a_cycle() {
        let mut presented = Presented::new(CycleTime::new(CYCLE).unwrap());
        let begin = Span::from_millis(3_000);
        for count in 0..20_000 {
            let slewed = Span::from_nanos(900 * i64::from(count).min(10_000));
            let header = FrameHeader {
                count: count.try_into().unwrap(),
                ..header(begin + slewed)
            };
            let set = Kinematics::at_rest(0.0);
            presented.take(header.count, &set, header.present_after);
            let before = presented.by;
            presented.follow(&header, &now(0.0));
            let step = presented.by - before;
            assert!(
                count == 0 || step.abs() <= Span::from_micros(1),
                "{count}: {step}"
            );
            if count == 8_000 {
                // What the frames of 3 s ago stated.
                let expected = begin + Span::from_micros(4_500);
                assert!(
                    (presented.by - expected).abs() < Span::from_micros(10),
                    "{}",
                    presented.by
                );
            }
        }
        assert_eq!(presented.by, begin + Span::from_millis(9));
    }

    #[test]
    fn a_hold_back_beyond_the_delay_leaves_no_lag() {
        let mut presented = Presented::new(CycleTime::new(CYCLE).unwrap());
        for (held, is_later) in [(0.0, true), (19e-3, true), (20e-3, false), (30e-3, false)] {
            let header = header(Span::from_millis(20));
            presented.follow(&header, &now(held));
            assert_eq!(presented.later().is_some(), is_later, "{held}");
        }
    }
}
