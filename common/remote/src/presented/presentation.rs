//! The delay by which an axis is shown later, as its frames state it.

use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::Kinematics;

use super::{FrameHistory, ShownLater};

/// A delay that changes from frame to frame by no more than a cycle, and this part of the time between them, is slewed: a cascade
/// and a delay that followers decide change as slowly. The axis follows it as slowly.
/// Anything more is another delay, to which the axis is brought.
const SLEW: f64 = 1e-3;

/// Newest frames of an axis, and the delay by which they are shown.
#[derive(Clone, Debug)]
pub struct AxisPresentation {
    frames: FrameHistory,
    /// Count of the newest frame that was followed, and the delay that it states.
    newest: Option<(u64, Span)>,
    /// Delay in force; zero where the newest values are moved to now.
    by: Span,
    /// Part of it by which the axis is evaluated later, in the far clock's time: the slaves are held back by the rest.
    lag: Seconds,
    /// True if the newest cycle showed values by a delay.
    is_shown: bool,
}

/// The newest frame of a cycle in which a delay is followed.
#[derive(Clone, Copy, Debug)]
pub struct FrameDelay {
    /// The sender's cycle count of the frame.
    pub count: u64,
    /// The delay that it states; zero: its values are moved to now.
    pub delay: Span,
    /// Cycle time of the sender.
    pub cycle: Span,
}

/// Circumstances of a cycle in which a delay is followed.
#[derive(Clone, Copy, Debug)]
pub struct PresentedNow {
    /// Time since the cycle before.
    pub passed: Span,
    /// Age of the newest frame, if the clock is known.
    pub age: Option<Seconds>,
    /// Hold-back: the part of the delay that slaves wait for.
    pub held: Seconds,
}

/// Change of the instant that is shown, beyond what passes and is slewed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShownChange {
    /// The values go on.
    None,
    /// They are shown by another delay.
    AnotherDelay,
    /// They are shown later, and were moved to now before; or the other way.
    LaterOrNow,
}

impl AxisPresentation {
    /// Creates that of an axis without frames, of a sender with this cycle time.
    #[must_use]
    pub fn new(cycle: Span) -> Self {
        Self {
            frames: FrameHistory::new(cycle),
            newest: None,
            by: Span::ZERO,
            lag: Seconds::ZERO,
            is_shown: false,
        }
    }

    /// Forgets all frames: the next ones are unrelated to them.
    pub const fn clear(&mut self) {
        self.frames.clear();
        self.newest = None;
    }

    /// Takes the set values of a frame, and the delay that it states.
    pub fn take(&mut self, count: u64, set: &Kinematics, delay: Span) {
        self.frames.take(count, set, delay);
    }

    /// Follows the delay that the newest frame states, and returns what changes by that.
    pub fn follow(&mut self, stated: &FrameDelay, now: &PresentedNow) -> ShownChange {
        let FrameDelay {
            count,
            delay,
            cycle,
        } = *stated;
        let is_another = self.is_another_delay(stated);
        self.newest = Some((count, delay));
        if is_another {
            // Frames from before are shown by it, too.
            self.frames.restate(delay);
            self.by = delay;
        } else if delay != self.by {
            // A delay that is slewed belongs to the frame that states it, which may be shown only long after.
            let stated = now
                .age
                .and_then(|Seconds(age)| self.frames.delay_at(self.lag.0 - age));
            let stated = stated.map_or(delay, Seconds::to_span);
            let most = match self.is_shown {
                true => Seconds(now.passed.as_secs_f64() * SLEW).to_span(),
                // Nothing has been shown by the delay of before: another mode was in force, or the clock was unknown.
                false => Span::MAX,
            };
            self.by += (stated - self.by).clamp(Span::ZERO - most, most);
        }
        self.frames.prepare(self.by, cycle);
        // A hold-back beyond the delay would be a guess.
        self.lag = Seconds((self.by.as_secs_f64() - now.held.0).max(0.0));
        let shows = self.is_in_force() && now.age.is_some();
        match (core::mem::replace(&mut self.is_shown, shows), shows) {
            (true, true) if is_another => ShownChange::AnotherDelay,
            (before, now) if before != now => ShownChange::LaterOrNow,
            _ => ShownChange::None,
        }
    }

    /// True if a delay is not the one of the frame before, nor slewed since.
    fn is_another_delay(&self, stated: &FrameDelay) -> bool {
        let FrameDelay {
            count,
            delay,
            cycle,
        } = *stated;
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

    /// Returns the frames and their delay; none where the newest values are moved to now.
    #[must_use]
    pub fn later(&self) -> Option<ShownLater<'_>> {
        self.is_in_force().then_some(ShownLater {
            frames: &self.frames,
            by: self.lag,
        })
    }

    /// True if the instant that is shown lies before the newest frame, whose age is none while the clock is unknown: a silence since
    /// then takes nothing away.
    #[must_use]
    pub fn covers(&self, age: Option<Seconds>) -> bool {
        self.is_in_force() && age.is_some_and(|age| age <= self.lag)
    }

    /// True if the frames are to be shown later.
    #[must_use]
    pub fn is_in_force(&self) -> bool {
        self.lag > Seconds::ZERO
    }

    /// True if the newest cycle showed values by a delay: it is in force, and the clock was known.
    #[must_use]
    pub const fn is_shown(&self) -> bool {
        self.is_shown
    }

    /// Returns the delay in force; zero where the newest values are moved to now.
    #[must_use]
    pub const fn delay(&self) -> Span {
        self.by
    }

    /// Returns the part of the delay by which the axis itself is shown later.
    #[must_use]
    pub const fn lag(&self) -> Seconds {
        self.lag
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: Span = Span::from_millis(1);

    fn stated(delay: Span) -> FrameDelay {
        FrameDelay {
            count: 0,
            delay,
            cycle: CYCLE,
        }
    }

    fn now(held: f64) -> PresentedNow {
        PresentedNow {
            passed: CYCLE,
            age: Some(Seconds::ZERO),
            held: Seconds(held),
        }
    }

    #[test]
    fn a_delay_is_adopted_at_once_and_small_changes_are_slewed() {
        let mut presented = AxisPresentation::new(CYCLE);
        assert!(presented.later().is_none());
        let mut follow = |micros| {
            presented.follow(&stated(Span::from_micros(micros)), &now(100e-6));
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
        let mut presented = AxisPresentation::new(CYCLE);
        let elsewhere = PresentedNow {
            age: None,
            ..now(0.0)
        };
        presented.follow(&stated(Span::from_micros(20_000)), &elsewhere);
        presented.follow(&stated(Span::from_micros(20_400)), &now(0.0));
        assert_eq!(presented.by, Span::from_micros(20_400));
    }

    #[test]
    fn a_change_of_the_instant_that_is_shown_is_told() {
        let mut presented = AxisPresentation::new(CYCLE);
        let unknown = PresentedNow {
            age: None,
            ..now(0.0)
        };
        for (micros, now, expected) in [
            (0, now(0.0), ShownChange::None),
            (20_000, unknown, ShownChange::None),
            (20_000, now(0.0), ShownChange::LaterOrNow),
            // Slewed.
            (20_400, now(0.0), ShownChange::None),
            (35_000, now(0.0), ShownChange::AnotherDelay),
            (35_000, unknown, ShownChange::LaterOrNow),
            (50_000, unknown, ShownChange::None),
            (50_000, now(0.0), ShownChange::LaterOrNow),
            (0, now(0.0), ShownChange::LaterOrNow),
        ] {
            let change = presented.follow(&stated(Span::from_micros(micros)), &now);
            assert_eq!(change, expected, "{micros}");
            assert_eq!(presented.is_shown(), micros > 0 && now.age.is_some());
        }
    }

    /// While a delay of seconds is slewed, the frames that are shown are more than a cycle behind what the newest states.
    #[test]
    fn a_long_delay_is_slewed_by_more_than_a_cycle() {
        let mut presented = AxisPresentation::new(CYCLE);
        let begin = Span::from_millis(3_000);
        for count in 0..20_000 {
            let slewed = Span::from_nanos(900 * i64::from(count).min(10_000));
            let stated = FrameDelay {
                count: count.try_into().unwrap(),
                ..stated(begin + slewed)
            };
            let set = Kinematics::at_rest(0.0);
            presented.take(stated.count, &set, stated.delay);
            let before = presented.by;
            presented.follow(&stated, &now(0.0));
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
        let mut presented = AxisPresentation::new(CYCLE);
        for (held, is_later) in [(0.0, true), (19e-3, true), (20e-3, false), (30e-3, false)] {
            let stated = stated(Span::from_millis(20));
            presented.follow(&stated, &now(held));
            assert_eq!(presented.later().is_some(), is_later, "{held}");
        }
    }
}
