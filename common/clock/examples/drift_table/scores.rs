//! Size and duration of the far time's error.

use super::cases::{BEGINS, WATCHED};
use super::world::{Course, Link, run};

/// Time before anything happens from which the usual error is taken, s.
const BEFORE: f64 = 3.0;
/// Last seconds, which count as the end.
const END: f64 = 2.0;
/// Distance, s, and part of the network's jitter, within which an error has to stay to be settled.
const SETTLED: f64 = 5e-6;
const SETTLED_PART: f64 = 0.25;

/// Result of one run. In s, the error of before taken away.
#[derive(Clone, Copy, Default)]
pub(crate) struct Score {
    pub(crate) worst: f64,
    pub(crate) settled_after: f64,
    pub(crate) at_end: f64,
    /// Worst error of the exchange with the least round trip of the last second.
    pub(crate) worst_of_exchanges: f64,
    /// Number of times that the drift was taken to have changed at once.
    pub(crate) steps: u32,
    /// Cycles in which the uncertainty did not cover the error, while the delay was measured.
    pub(crate) beyond: u32,
}

pub(crate) fn score(link: &Link, course: &Course, seed: u64) -> Score {
    let mut score = Score::default();
    let (mut usual, mut count) = (0.0, 0.0);
    let width = link.correlated.map_or(0.0, |(width, _)| width);
    // A link with wide jitter is never within a few µs for long, whatever happens on it.
    let near = SETTLED + SETTLED_PART * (link.network + width);
    run(link, course, seed, BEGINS + WATCHED, |cycle| {
        let since = cycle.time - BEGINS;
        if (-BEFORE..0.0).contains(&since) {
            count += 1.0;
            usual += (cycle.error - usual) / count;
        }
        if since < 0.0 {
            return;
        }
        let off = f64::abs(cycle.error - usual);
        score.worst = score.worst.max(off);
        if off > near {
            // The last time that it was off, so that an error that returns counts.
            score.settled_after = since;
        }
        if since > WATCHED - END {
            score.at_end = score.at_end.max(off);
        }
        if let Some(error) = cycle.best_exchange {
            score.worst_of_exchanges = score.worst_of_exchanges.max(error.abs());
        }
        let output = &cycle.output;
        if let Some(uncertainty) = output.delay.uncertainty {
            // What is still to be slewed is reported beside the uncertainty, not in it.
            let bound = uncertainty.0 + output.observer.slew_remaining.0.abs();
            score.beyond += u32::from(cycle.error.abs() > bound);
        }
        score.steps = output.observer.drift_steps;
    });
    score
}

/// Median and largest value of a score.
pub(crate) fn middle_and_most(scores: &[Score], of: fn(&Score) -> f64) -> [f64; 2] {
    let mut all: Vec<_> = scores.iter().map(of).collect();
    all.sort_by(f64::total_cmp);
    [all[all.len() / 2], all[all.len() - 1]]
}
