//! Changes of a clock's rate that no exchange of a timing channel can show yet.

use std::collections::VecDeque;

use coaxle_clock::timing;
use coaxle_receiver::ReceiverConfig;
use coaxle_sim::Truth;

use crate::topology::{ReceiverAxis, View};

/// Cycles for which a response may wait until it is taken, and its request before.
const WAITING: f64 = 2.0;

/// Error of far time by a change of a clock's rate that is too recent to be known.
///
/// A receiver can at best go on along the straight line that the clocks followed until the newest exchanges that it has measured, those of the
/// time D ago. So the error is the second difference of the sender's true time x over the receiver's own:
/// |x(t) − 2·x(t − D) + x(t − 2·D)|. After a change of the rate by Δ that is Δ·u for the first time D since it, u after the change, and
/// nothing from 2·D on; with steady clocks it is zero. Changes of a rate that wanders may cancel in it: the one of half the time counts, too. Swarm
/// schedule 81060: a step of 4.9 ppm, behind which the rate has come back from another.
#[derive(Debug)]
pub(super) struct UnnoticedChange {
    /// The time D, s.
    within: f64,
    /// Own time, s, and the truth, of the last 2·D, and of what lies before a pause in them.
    marks: VecDeque<(f64, Truth)>,
}

impl UnnoticedChange {
    /// Absent for an axis without a timing channel.
    pub(super) fn new(config: &ReceiverConfig, view: &View) -> Option<Self> {
        let ReceiverAxis::Far { far, .. } = view.of else {
            return None;
        };
        let timing = config.far.get(far)?.timing.as_ref()?;
        let cycle = config.cycle_time_us.0.as_secs_f64();
        // A beacon leaves in a cycle of the receiver.
        let interval = timing.interval().as_secs_f64().max(cycle);
        let exchanges = f64::from(timing::EXCHANGES_OF_A_CHANGE);
        Some(Self {
            within: exchanges * interval + WAITING * cycle,
            marks: VecDeque::new(),
        })
    }

    /// Forgets the past, as of another clock.
    pub(super) fn forget(&mut self) {
        self.marks.clear();
    }

    /// Takes the next cycle: the truth, and the own time, s. Returns the error, µs.
    pub(super) fn push(&mut self, truth: &Truth, own: f64) -> f64 {
        let follows = |(before, last): &(f64, Truth)| *before < own && last.epoch == truth.epoch;
        if !self.marks.back().is_none_or(follows) {
            self.forget();
        }
        self.marks.push_back((own, *truth));
        let [whole, half] = [self.within, 0.5 * self.within]
            .map(|within| self.beyond_the_line(truth, own, within).unwrap_or((0.0, 0)));
        self.marks.drain(..whole.1);
        whole.0.max(half.0)
    }

    /// Distance from the line that the clocks followed until the time `within` ago, µs, and the number of marks before that line; none if it is not
    /// known that far back.
    fn beyond_the_line(&self, truth: &Truth, own: f64, within: f64) -> Option<(f64, usize)> {
        let until = |limit: f64| self.marks.partition_point(|(at, _)| *at <= limit);
        let (middle, then) = self.marks[until(own - within).checked_sub(1)?];
        // The newest one that is the time D older, so that both differ behind a receiver's pause, too.
        let oldest = until(middle - within).checked_sub(1)?;
        let (first, before) = &self.marks[oldest];
        let expected = then.seconds_since(before).0 * (own - middle) / (middle - first);
        let error = (truth.seconds_since(&then).0 - expected).abs() * 1e6;
        Some((error, oldest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::{CycleTime, Instant, Span};
    use coaxle_curve::profile::Kinematics;
    use coaxle_sim::{Oracle, True, TruthSample};

    /// The truth in each of the first cycles of a millisecond by a receiver's own time. Those behind `change` are longer by 8 ppm, by true time.
    fn truths(cycles: u32, change: u32) -> impl Iterator<Item = (u32, Truth)> {
        let mut oracle = Oracle::<True>::new(
            CycleTime::new(Span::from_millis(1)).unwrap(),
            Span::from_secs(100),
        );
        for count in 0..u64::from(cycles) + 1_000 {
            oracle.push(TruthSample {
                at: Instant::from_nanos(1_000_000 * count as i64),
                epoch: 1,
                count,
                axis: Kinematics::at_rest(0.0),
                present_after: Span::ZERO,
            });
        }
        (1..cycles).map(move |cycle| {
            let since = i64::from(cycle.saturating_sub(change));
            let at = Instant::from_nanos(1_000_000 * i64::from(cycle) + 8 * since);
            (cycle, oracle.at(at).expect("known"))
        })
    }

    const fn unnoticed() -> UnnoticedChange {
        UnnoticedChange {
            within: 0.322,
            marks: VecDeque::new(),
        }
    }

    #[test]
    fn a_change_of_the_rate_is_unnoticed_in_every_cycle_until_it_is_measured() {
        let mut unnoticed = unnoticed();
        for (cycle, truth) in truths(60_000, 44_485) {
            let error = unnoticed.push(&truth, 1e-3 * f64::from(cycle));
            // 8 ppm of the time since the change, up to D.
            let since = cycle.saturating_sub(44_485);
            if (1..320).contains(&since) {
                let expected = 8e-3 * f64::from(since);
                assert!((error - expected).abs() < 1e-3, "{since}: {error} µs");
            }
            assert!(error < 8e-6 * 0.3231 * 1e6, "{cycle}: {error} µs");
        }
    }

    /// The bound was no number in a swarm schedule.
    #[test]
    fn behind_a_pause_a_change_within_it_is_unnoticed() {
        let mut unnoticed = unnoticed();
        for (cycle, truth) in truths(5_000, 3_000) {
            if (2_500..3_500).contains(&cycle) {
                continue;
            }
            let error = unnoticed.push(&truth, 1e-3 * f64::from(cycle));
            let expected = match cycle {
                // The line of the time before the pause.
                3_500..3_822 => 8e-3 * f64::from(cycle - 3_000),
                // One over the pause, which has a part of the change: half of it, 8 ppm · 0.5 s, over a second.
                3_822..4_145 => {
                    assert!((0.0..1.3).contains(&error), "{cycle}: {error} µs");
                    continue;
                }
                _ => 0.0,
            };
            assert!((error - expected).abs() < 1e-3, "{cycle}: {error} µs");
        }
    }
}
