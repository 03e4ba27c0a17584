//! The figures as a markdown table, a row per case.

use crate::bench::{BANDWIDTHS, Scores};
use crate::figures::quantile;
use crate::scores::{Claims, Score};

/// Meaning of the columns, to be printed below the table.
pub(crate) const LEGEND: &str = "\
Errors in µs with their mean removed: rms over all seeds, in brackets that of the worst seed, / largest.
line: through the lowest of each of the last 8 s. servo: PI on the lowest of each second, natural
frequency 0.2 rad/s, damping 0.7; best: the best of a few frequencies. regression: over up to 64
lowest of 1/8 s, their number by a test of runs. bound: Bayesian Cramér-Rao.
The observer's own: shifts of all seeds together; part of the cycles with |e| ≤ 3σ (all seeds, worst
seed); its standard deviation over the rms error (mean, largest); the part within of all cycles while synchronised, from the start on; largest |e| while synchronised,
also over 3σ; synchronised after (median, worst seed); largest error of the drift, and part of the cycles
with it within 3σ; lead (median); after an event: within 1 µs rms again after (median, worst).
Steps of the delay and of the drift, load: errors after the event against the constant before it; the
first 2 s after a step of the delay, and what slewing by it at 100 ppm takes, do not count; the truth
moves by the step.
Recorded: first third skipped, else first quarter.";

const COLUMNS: [&str; 18] = [
    "case",
    "observer rms (worst) / max",
    "bound",
    "line rms (worst) / max",
    "servo rms (worst) / max",
    "best servo rms (rad/s)",
    "regression rms (worst) / max",
    "shifts",
    "in 3σ, % (worst)",
    "σ / rms (most)",
    "synced in 3σ, %",
    "max synced",
    "over 3σ",
    "synced, s (worst)",
    "drift error, ppm",
    "drift in 3σ, %",
    "lead",
    "settled, s (worst)",
];

/// Column widths: rows are printed as they come, so the widths cannot wait for all of them.
const WIDTHS: [usize; 18] = [
    44, 26, 6, 22, 23, 22, 28, 6, 16, 14, 15, 10, 7, 17, 16, 14, 6, 18,
];

pub(crate) fn header() -> String {
    let dashes = COLUMNS.map(|_| "--".to_owned());
    format!("{}\n{}", line(&COLUMNS.map(str::to_owned)), line(&dashes))
}

pub(crate) fn row(name: &str, bound: Option<f64>, runs: &[Scores]) -> String {
    let observer = |f: fn(&Claims) -> f64| -> Vec<f64> {
        let claims = runs.iter().filter_map(|run| run.observer.claims.as_ref());
        claims.map(f).collect()
    };
    let worst = |values: &[f64]| quantile(values, 1.0);
    let within = observer(|claims| claims.within * 100.0);
    let synced = observer(|claims| claims.synced_after);
    line(&[
        name.to_owned(),
        errors(runs, |run| &run.observer),
        bound.map_or_else(nothing, micros),
        errors(runs, |run| &run.line),
        errors(runs, |run| &run.servos[0]),
        best_servo(runs),
        errors(runs, |run| &run.regression),
        observer(|claims| f64::from(claims.shifts))
            .iter()
            .sum::<f64>()
            .to_string(),
        format!("{:.1} ({:.1})", mean(&within), quantile(&within, 0.0)),
        sigma_over_rms(runs),
        format!("{:.1}", synced_within(runs)),
        micros(worst(&observer(|claims| claims.max_synced))),
        short(worst(&observer(|claims| claims.worst_ratio))),
        format!("{:.2} ({:.2})", quantile(&synced, 0.5), worst(&synced)),
        short(worst(&observer(|claims| claims.worst_drift_ppm))),
        format!(
            "{:.1}",
            mean(&observer(|claims| claims.drift_within * 100.0))
        ),
        micros(quantile(&observer(|claims| claims.lead), 0.5)),
        settled(runs),
    ])
}

fn line(cells: &[String; 18]) -> String {
    let cells = cells.iter().zip(WIDTHS);
    let cells = cells.map(|(cell, width)| format!(" {cell:width$} |"));
    format!("|{}", cells.collect::<String>())
}

/// Share of all cycles while synchronised, in per cent.
fn synced_within(runs: &[Scores]) -> f64 {
    let claims = runs.iter().filter_map(|run| run.observer.claims.as_ref());
    let (within, synced) = claims.fold((0, 0), |(within, synced), claims| {
        (within + claims.synced_within, synced + claims.synced)
    });
    within as f64 / synced as f64 * 100.0
}

/// Ratio of the reported standard deviation to the error, the mean over the runs and the largest.
fn sigma_over_rms(runs: &[Scores]) -> String {
    let of = |run: &Scores| {
        let claims = run.observer.claims.as_ref()?;
        Some(claims.sigma / run.observer.mean_square.sqrt())
    };
    let ratios: Vec<f64> = runs.iter().filter_map(of).collect();
    format!("{:.1} ({:.1})", mean(&ratios), quantile(&ratios, 1.0))
}

/// Rms over all runs, that of the worst run, largest error.
fn errors(runs: &[Scores], of: impl Fn(&Scores) -> &Score) -> String {
    let squares: Vec<f64> = runs.iter().map(|run| of(run).mean_square).collect();
    let max = runs.iter().map(|run| of(run).max).fold(0.0, f64::max);
    // Mean of squares over the runs, as of one long run.
    let rms = mean(&squares).sqrt();
    // A follower that knew nothing in some cycle has no rms.
    if !rms.is_finite() {
        return nothing();
    }
    let worst = if runs.len() > 1 {
        format!(" ({})", micros(quantile(&squares, 1.0).sqrt()))
    } else {
        String::new()
    };
    format!("{}{worst} / {}", micros(rms), micros(max))
}

fn best_servo(runs: &[Scores]) -> String {
    let rms = |i: usize| {
        let squares: Vec<f64> = runs.iter().map(|run| run.servos[i].mean_square).collect();
        mean(&squares).sqrt()
    };
    let best = (0..BANDWIDTHS.len()).min_by(|a, b| rms(*a).total_cmp(&rms(*b)));
    best.filter(|best| rms(*best).is_finite())
        .map_or_else(nothing, |best| {
            format!("{} ({})", micros(rms(best)), BANDWIDTHS[best])
        })
}

fn settled(runs: &[Scores]) -> String {
    let settled: Vec<f64> = runs.iter().filter_map(|run| run.observer.settled).collect();
    if settled.is_empty() {
        return nothing();
    }
    let (median, worst) = (quantile(&settled, 0.5), quantile(&settled, 1.0));
    format!("{median:.2} ({worst:.2})")
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn micros(seconds: f64) -> String {
    short(seconds * 1e6)
}

/// Formats with about three digits.
fn short(value: f64) -> String {
    let decimals = match value.abs() {
        size if size < 0.1 => 3,
        size if size < 10.0 => 2,
        size if size < 100.0 => 1,
        _ => 0,
    };
    format!("{value:.decimals$}")
}

fn nothing() -> String {
    "–".to_owned()
}
