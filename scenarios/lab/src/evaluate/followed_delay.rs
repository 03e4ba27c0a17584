//! The delay of an axis whose followers decide it, as a receiver follows it.

use coaxle_clock::{CycleTime, Span};

use super::shown_later;
use crate::record::ReceiverCycle;

/// Part of the time by which a receiver follows a delay: `SLEW` of `receiver::far::axis::presented`.
const SLEW: f64 = 1e-3;
/// Distance from that, in a cycle.
// Of a hold-back of 10 ms, a drift that is learnt again by 10 ppm; rounded it is 2 ns.
const TOLERANCE: Span = Span::from_nanos(100);

/// Delay by which the newest cycle was judged.
///
/// While no frame comes, a delay goes on by up to 0.94 ‰ of the time, which no receiver can know. From the next frames on it makes up for that at 0.1 % of the
/// time, less the change meanwhile: 59 µs after 145 ms in swarm schedule 91876, 1.36 µs after three cycles in 90111. That is how a delay is followed, and no error
/// of the clock.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FollowedDelay {
    /// The cycle and the delay.
    newest: Option<(u64, Span)>,
}

impl FollowedDelay {
    /// The delay to judge a cycle by, which is to be shown with the delay `due`; far time has this pace by the own clock: the one that it shows, where that came
    /// from the one before towards `due` as fast as a receiver follows.
    pub(super) fn take(
        &mut self,
        record: &ReceiverCycle,
        due: Span,
        pace: f64,
        cycle_time: CycleTime,
    ) -> Span {
        let number = record.node.cycle;
        let shown = shown_later::shown_in(record, pace);
        let follows = |(cycle, from): (u64, Span)| {
            let passed = cycle_time.as_secs_f64() * number.checked_sub(cycle)? as f64;
            let most = Span::from_secs_f64(SLEW * passed);
            let followed = from + (due - from).clamp(Span::ZERO - most, most);
            shown.filter(|shown| (*shown - followed).abs() <= TOLERANCE)
        };
        let judged = self.newest.and_then(follows).unwrap_or(due);
        // What is shown now is followed from nowhere.
        self.newest = shown.map(|_| (number, judged));
        judged
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Delays to judge cycles by, µs; of each its number, its lag beside a hold-back of 5 ms, and the delay that is due, µs.
    fn judged<const N: usize>(cycles: [(u64, Option<f64>, f64); N]) -> [f64; N] {
        let cycle_time = CycleTime::new(Span::from_millis(1)).unwrap();
        let mut delay = FollowedDelay::default();
        cycles.map(|(number, lag_us, due_us)| {
            let mut record = ReceiverCycle::default();
            record.node.cycle = number;
            record.node.hold_back_us = 5_000.0;
            record.far.presentation_lag_us = lag_us;
            let due = Span::from_micros_f64(due_us);
            delay.take(&record, due, 1.0, cycle_time).as_micros_f64()
        })
    }

    #[test]
    fn a_delay_is_followed_at_a_thousandth_of_the_time_and_not_slower() {
        let begin = (1, Some(15_000.0), 20_000.0);
        // A silence is over in which it went on by 60 µs: a cycle, and the fifth one from there.
        let [_, first, fifth] = judged([
            begin,
            (2, Some(15_001.0), 20_060.0),
            (7, Some(15_006.0), 20_063.0),
        ]);
        assert_eq!((first, fifth), (20_001.0, 20_006.0));
        // It stands, goes the other way, is too fast, or comes to where it should be.
        for lag_us in [15_000.0, 14_999.0, 15_002.0, 15_060.0] {
            let [_, cycle] = judged([begin, (2, Some(lag_us), 20_060.0)]);
            assert_eq!(cycle, 20_060.0, "{lag_us}");
        }
    }

    /// Swarm schedule 81667: back from another mode, an axis came slowly to the delay in force.
    #[test]
    fn what_was_shown_now_is_followed_from_nowhere() {
        let [.., back, next] = judged([
            (1, Some(15_000.0), 20_000.0),
            (2, None, 20_000.0),
            (3, Some(15_001.0), 20_400.0),
            (4, Some(15_002.0), 20_400.0),
        ]);
        assert_eq!((back, next), (20_400.0, 20_400.0));
    }
}
