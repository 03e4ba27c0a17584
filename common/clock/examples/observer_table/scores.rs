//! Score of one follower for one run, measured against the truth.
//!
//! The far time may be off by a constant, as one-way messages do not show the least delay: the mean
//! over the steady part is taken away. After a step of the delay the truth has moved by the step.

use std::ops::Range;

use coaxle_clock::observer::{ObserverOutput, ObserverState};

use crate::drive::{Cycle, drive};
use crate::figures::lock_rms;
use crate::peers::Follower;
use crate::world::{Case, Run};

/// Time allowed for a step of the delay to be noticed and followed before errors count, s, ...
const GRACE: f64 = 2.0;
/// ... besides the time for slewing by it: the observer's usual limit, s/s.
const SLEW: f64 = 1e-4;

/// Ranges of a run's cycles by their use.
pub(crate) struct Scope {
    cycles: usize,
    /// Cycles for the constant that is taken away.
    steady: Range<usize>,
    /// Cycles whose errors count.
    scored: Range<usize>,
    /// Cycles whose errors do not count: between a step of the delay and the end of its grace.
    excused: Range<usize>,
    /// Cycle from which the time to settle is taken.
    settles_from: Option<usize>,
    /// Step of the delay at the end of the steady part, s.
    delay_step: f64,
}

impl Scope {
    /// The whole of a run after its first `skipped` part.
    pub(crate) fn undisturbed(cycles: usize, skipped: f64) -> Self {
        let steady = (cycles as f64 * skipped) as usize..cycles;
        Self {
            cycles,
            scored: steady.clone(),
            steady,
            excused: 0..0,
            settles_from: None,
            delay_step: 0.0,
        }
    }

    /// A generated case: up to its event the constant is taken, from then on errors count.
    pub(crate) fn of_case(case: &Case) -> Self {
        let index = |seconds: f64| (seconds / case.cycle) as usize;
        let whole = Self::undisturbed(index(case.seconds), 0.25);
        let from = whole.steady.start;
        if let Some((at, by)) = case.delay_step {
            // Slewing by a step takes its size over the limit, which no estimator can avoid.
            let (at, after) = (index(at), index(at + GRACE + by.abs() / SLEW));
            return Self {
                // The constant is that of before the event: what stays off afterwards is an error.
                steady: from..at,
                scored: after..whole.cycles,
                excused: at..after,
                settles_from: Some(at),
                delay_step: by,
                ..whole
            };
        }
        let load = case.load.map(|(from, to, _)| (from, to));
        let Some((at, settles_from)) = load.or(case.drift_step.map(|(at, _)| (at, at))) else {
            return whole;
        };
        Self {
            steady: from..index(at),
            scored: index(at)..whole.cycles,
            settles_from: Some(index(settles_from)),
            ..whole
        }
    }
}

/// Score of one run. In seconds unless stated otherwise.
pub(crate) struct Score {
    pub(crate) mean_square: f64,
    pub(crate) max: f64,
    /// From the event, if there is one, until within a microsecond, rms.
    pub(crate) settled: Option<f64>,
    /// Uncertainty that only the observer reports.
    pub(crate) claims: Option<Claims>,
}

/// Truth of the observer's own uncertainty.
pub(crate) struct Claims {
    pub(crate) shifts: u32,
    /// Part of the cycles whose error is within three standard deviations.
    pub(crate) within: f64,
    /// Standard deviation reported for them, rms.
    pub(crate) sigma: f64,
    /// Cycles while synchronised, from the start of the run, and those of them whose error is within three
    /// standard deviations.
    pub(crate) synced: u64,
    pub(crate) synced_within: u64,
    /// The largest error while synchronised, from the start of the run.
    pub(crate) max_synced: f64,
    /// The largest error while synchronised in units of three standard deviations.
    pub(crate) worst_ratio: f64,
    /// Not finite if never.
    pub(crate) synced_after: f64,
    pub(crate) worst_drift_ppm: f64,
    /// Part of the cycles of the steady part whose drift is within three standard deviations.
    pub(crate) drift_within: f64,
    pub(crate) lead: f64,
}

/// Report of the observer in one cycle.
#[derive(Clone, Copy)]
struct Said {
    synced: bool,
    three_sigma: f64,
    drift_error_ppm: f64,
    drift_three_sigma_ppm: f64,
}

struct Trace {
    cycle: f64,
    /// Not a number while the follower knows nothing yet.
    errors: Vec<f64>,
    said: Vec<Said>,
    last: Option<ObserverOutput>,
}

pub(crate) fn score(follower: &mut dyn Follower, run: &Run, scope: &Scope) -> Score {
    let mut trace = trace(follower, run, scope);
    let steady = &trace.errors[scope.steady.clone()];
    let constant = steady.iter().sum::<f64>() / steady.len() as f64;
    for error in &mut trace.errors {
        *error -= constant;
    }
    let scored = &trace.errors[scope.scored.clone()];
    let settled = scope
        .settles_from
        .map(|from| lock_rms(&trace.errors[from..], 0.0, trace.cycle));
    Score {
        mean_square: scored.iter().map(|e| e * e).sum::<f64>() / scored.len() as f64,
        max: scored.iter().fold(0.0, |max, e| e.abs().max(max)),
        settled,
        claims: trace.last.map(|last| trace.claims(&last, scope)),
    }
}

fn trace(follower: &mut dyn Follower, run: &Run, scope: &Scope) -> Trace {
    let mut trace = Trace {
        cycle: run.cycle(),
        errors: Vec::with_capacity(scope.cycles),
        said: Vec::new(),
        last: None,
    };
    drive(follower, run, scope.cycles, |cycle| {
        let stepped = cycle.number >= scope.excused.start;
        // Messages alone cannot tell a longer path from a later clock, so far time is right to move by it.
        let moved = if stepped { scope.delay_step } else { 0.0 };
        let far = cycle.far.unwrap_or(f64::NAN);
        trace.errors.push(far - run.far(cycle.now) + moved);
        if let Some(output) = &cycle.output {
            trace.said.push(said(output, run, cycle));
        }
        trace.last = cycle.output;
    });
    trace
}

fn said(output: &ObserverOutput, run: &Run, cycle: &Cycle) -> Said {
    Said {
        synced: output.state == ObserverState::Synced,
        three_sigma: 3.0 * output.offset_sigma.0,
        drift_error_ppm: (output.drift_ppm - run.drift_ppm(cycle.now)).abs(),
        drift_three_sigma_ppm: 3.0 * output.drift_sigma_ppm,
    }
}

impl Trace {
    fn claims(&self, last: &ObserverOutput, scope: &Scope) -> Claims {
        let cycles = || self.errors.iter().map(|e| e.abs()).zip(&self.said);
        let scored = cycles().take(scope.scored.end).skip(scope.scored.start);
        let within = scored.clone().filter(|(e, said)| *e <= said.three_sigma);
        let within = within.count();
        let squares = scored.map(|(_, said)| said.three_sigma * said.three_sigma);
        let sigma = (squares.sum::<f64>() / scope.scored.len() as f64).sqrt() / 3.0;
        let synced = || {
            cycles()
                .enumerate()
                // From the very start, unlike the other figures: `synced` promises something from its first cycle on.
                .filter(|(number, (_, said))| said.synced && !scope.excused.contains(number))
                .map(|(_, cycle)| cycle)
        };
        let first_synced = self.said.iter().position(|said| said.synced);
        let drifts = self.said[scope.steady.start..].iter();
        let drift_is_within = |said: &&Said| said.drift_error_ppm <= said.drift_three_sigma_ppm;
        let drifts_within = drifts.clone().filter(drift_is_within).count();
        Claims {
            shifts: last.shifts,
            within: within as f64 / scope.scored.len() as f64,
            sigma,
            synced: synced().count() as u64,
            synced_within: synced().filter(|(e, said)| *e <= said.three_sigma).count() as u64,
            max_synced: synced().map(|(e, _)| e).fold(0.0, f64::max),
            worst_ratio: synced()
                .map(|(e, said)| e / said.three_sigma)
                .fold(0.0, f64::max),
            synced_after: first_synced.map_or(f64::INFINITY, |k| k as f64 * self.cycle),
            drift_within: drifts_within as f64 / drifts.len() as f64,
            worst_drift_ppm: drifts.map(|said| said.drift_error_ppm).fold(0.0, f64::max),
            lead: last.lead.0,
        }
    }
}
