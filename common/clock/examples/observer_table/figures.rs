//! Follows many runs and reduces each to a few figures.

use coaxle_clock::observer::ObserverState;

use crate::drive::drive;
use crate::peers::Follower;
use crate::world::{self, Case, Run};

/// Result of one run. Seconds.
#[derive(Clone, Copy, Default)]
pub(crate) struct Figures {
    pub(crate) rms: f64,
    pub(crate) max: f64,
    pub(crate) mean: f64,
    pub(crate) lock1: f64,
    pub(crate) lock5: f64,
    pub(crate) synced: f64,
    pub(crate) shifts: u32,
    pub(crate) backward: u32,
    pub(crate) settle: f64,
    pub(crate) worst: f64,
    pub(crate) detect: f64,
    pub(crate) sigma: f64,
    pub(crate) normal: f64,
    pub(crate) exponential: f64,
    pub(crate) walk: f64,
    pub(crate) lock_rms: f64,
    pub(crate) early: [f64; 6],
    pub(crate) seed: u64,
    pub(crate) lead: f64,
}

const WITHIN: f64 = 1e-6;

pub(crate) fn follow(follower: &mut dyn Follower, case: &Case, run: &Run) -> Figures {
    let cycles = (case.seconds / case.cycle) as usize;
    let mut errors = vec![f64::NAN; cycles];
    let mut figures = Figures {
        synced: f64::NAN,
        detect: f64::NAN,
        ..Figures::default()
    };
    let mut previous = f64::NEG_INFINITY;
    drive(follower, run, cycles, |cycle| {
        let (Some(far), now) = (cycle.far, cycle.now) else {
            return;
        };
        // One-way messages cannot show the least delay, so it is no error.
        errors[cycle.number] = far - run.far(now) + world::MIN_DELAY;
        // Strictly: far time is promised to rise from cycle to cycle.
        figures.backward += u32::from(far <= previous);
        previous = far;
        if let Some(output) = &cycle.output {
            if figures.synced.is_nan() && output.state == ObserverState::Synced {
                figures.synced = now;
            }
            if figures.detect.is_nan() && output.shifts > 0 {
                figures.detect = now;
            }
        }
    });
    if let Some(output) = follower.output() {
        figures.shifts = output.shifts;
        figures.lead = output.lead.0;
        figures.sigma = output.offset_sigma.0;
        figures.normal = output.normal_jitter.0;
        figures.exponential = output.exponential_jitter.0;
        figures.walk = output.random_walk_ppm;
    }
    // The first quarter is for the lock, which has figures of its own.
    let steady_from = ((case.seconds * 0.25) / case.cycle) as usize;
    let mut steady = &errors[steady_from..];
    let load = case.load.map(|(from, to, _)| (from, to));
    if let Some((at, _)) = case.drift_step.or(case.delay_step).or(load) {
        steady = &errors[steady_from..(at / case.cycle) as usize];
    }
    let n = steady.len() as f64;
    let mean = steady.iter().sum::<f64>() / n;
    figures.mean = mean;
    figures.rms = (steady.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n).sqrt();
    figures.max = largest(steady, mean);
    figures.lock1 = lock(&errors, mean, 1.0, case.cycle);
    figures.lock5 = lock(&errors, mean, 5.0, case.cycle);
    figures.lock_rms = lock_rms(&errors, mean, case.cycle);
    for (early, at) in figures.early.iter_mut().zip(EARLY) {
        *early = errors[(at / case.cycle) as usize] - mean;
    }
    if let Some((at, _)) = case.drift_step {
        let after = (at / case.cycle) as usize;
        let after = &errors[after..];
        figures.settle = lock(after, mean, 1.0, case.cycle);
        figures.worst = largest(after, mean);
    }
    if let Some((from, to)) = load {
        let (from, to) = ((from / case.cycle) as usize, (to / case.cycle) as usize);
        figures.settle = lock_rms(&errors[to..], mean, case.cycle);
        figures.worst = largest(&errors[from..], mean);
    }
    if let Some((at, _)) = case.delay_step {
        figures.detect -= at;
    }
    figures
}

fn largest(errors: &[f64], constant: f64) -> f64 {
    let distances = errors.iter().map(|error| (error - constant).abs());
    distances.fold(0.0, f64::max)
}

/// The first time from which the error stays within a microsecond of the constant for `seconds`.
fn lock(errors: &[f64], constant: f64, seconds: f64, cycle: f64) -> f64 {
    let needed = (seconds / cycle) as usize;
    let mut good = 0;
    for (k, error) in errors.iter().enumerate() {
        // Not a number is not within.
        good = if (error - constant).abs() <= WITHIN {
            good + 1
        } else {
            0
        };
        if good == needed {
            return (k + 1 - needed) as f64 * cycle;
        }
    }
    f64::INFINITY
}

pub(crate) const EARLY: [f64; 6] = [0.05, 0.1, 0.2, 0.5, 1.0, 2.0];

/// The first time from which the error has an rms within a microsecond over both the next one and
/// the next five seconds.
pub(crate) fn lock_rms(errors: &[f64], constant: f64, cycle: f64) -> f64 {
    let (short, long) = ((1.0 / cycle) as usize, (5.0 / cycle) as usize);
    let mut sums = vec![0.0];
    for error in errors {
        let e = error - constant;
        // A second squared where nothing is known yet: no window with it is within a microsecond.
        sums.push(sums[sums.len() - 1] + if e.is_nan() { 1.0 } else { e * e });
    }
    // Sums from the start, so that each window is one subtraction.
    let within = |k: usize, n: usize| sums[k + n] - sums[k] <= n as f64 * WITHIN * WITHIN;
    (0..errors.len().saturating_sub(long))
        .find(|k| (errors[*k] - constant).abs() <= WITHIN && within(*k, short) && within(*k, long))
        .map_or(f64::INFINITY, |k| k as f64 * cycle)
}

pub(crate) fn quantile(values: &[f64], part: f64) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    // The nearest rank, without interpolation, as one of them may be infinite.
    values[((values.len() - 1) as f64 * part).round() as usize]
}

pub(crate) fn all<F: Fn() -> Box<dyn Follower> + Sync>(
    case: &Case,
    first: u64,
    seeds: u64,
    make: F,
) -> Vec<Figures> {
    // Two threads with every other seed, whose runs take as long on the average.
    let half = |odd: u64| {
        (0..seeds)
            .filter(|seed| seed % 2 == odd)
            .map(|seed| Figures {
                seed: first + seed,
                ..follow(&mut *make(), case, &Run::new(case, first + seed))
            })
            .collect::<Vec<_>>()
    };
    std::thread::scope(|scope| {
        let other = scope.spawn(|| half(1));
        let mut figures = half(0);
        figures.extend(other.join().unwrap());
        figures
    })
}
