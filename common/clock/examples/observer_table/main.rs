//! Prints how well the observer and simpler methods follow a far clock, in virtual time.
//!
//! `cargo run --release --example observer_table -- [seeds] [what…]`
#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]

mod peers;
mod world;

use peers::{Follower, Hull, Kalman, LeastSquares, MinimumServo, Observer};
use world::{Case, Run, bound};

/// What one run came to. Seconds.
#[derive(Clone, Copy, Default)]
struct Figures {
    rms: f64,
    max: f64,
    mean: f64,
    lock1: f64,
    lock5: f64,
    synced: f64,
    shifts: u32,
    backward: u32,
    settle: f64,
    worst: f64,
    detect: f64,
    sigma: f64,
    normal: f64,
    exponential: f64,
    walk: f64,
    lock_rms: f64,
    early: [f64; 6],
    seed: u64,
    lead: f64,
}

const WITHIN: f64 = 1e-6;

fn follow(follower: &mut dyn Follower, case: &Case, run: &Run) -> Figures {
    let cycle = (case.cycle * 1e9) as i64;
    let cycles = (case.seconds / case.cycle) as i64;
    let mut errors = vec![f64::NAN; cycles as usize];
    let mut figures = Figures {
        synced: f64::NAN,
        detect: f64::NAN,
        ..Figures::default()
    };
    let (mut next, mut previous) = (0, f64::NEG_INFINITY);
    for k in 0..cycles {
        let now = k * cycle;
        while next < run.messages.len() && run.messages[next].arrived <= now {
            follower.observe(&run.messages[next]);
            next += 1;
        }
        if let Some(far) = follower.far(now) {
            let now = now as f64 * 1e-9;
            errors[k as usize] = far - run.far(now) + world::MIN_DELAY;
            figures.backward += u32::from(far <= previous);
            previous = far;
            if let Some(output) = follower.output() {
                use coaxle_clock::observer::ObserverState::Synced;
                if figures.synced.is_nan() && output.state == Synced {
                    figures.synced = now;
                }
                if figures.detect.is_nan() && output.shifts > 0 {
                    figures.detect = now;
                }
            }
        }
    }
    if let Some(output) = follower.output() {
        figures.shifts = output.shifts;
        figures.lead = output.lead.0;
        figures.sigma = output.offset_sigma.0;
        figures.normal = output.normal_jitter.0;
        figures.exponential = output.exponential_jitter.0;
        figures.walk = output.random_walk_ppm;
    }
    let steady_from = ((case.seconds * 0.25) / case.cycle) as usize;
    let mut steady = &errors[steady_from..];
    let step = case.drift_step.or(case.delay_step);
    if let Some((at, _)) = step {
        steady = &errors[steady_from..(at / case.cycle) as usize];
    }
    let n = steady.len() as f64;
    let mean = steady.iter().sum::<f64>() / n;
    figures.mean = mean;
    figures.rms = (steady.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n).sqrt();
    figures.max = steady.iter().map(|e| (e - mean).abs()).fold(0.0, f64::max);
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
        figures.worst = after.iter().map(|e| (e - mean).abs()).fold(0.0, f64::max);
    }
    if let Some((at, _)) = case.delay_step {
        figures.detect -= at;
    }
    figures
}

/// The first time from which the error stays within a microsecond of the constant for so long.
fn lock(errors: &[f64], constant: f64, seconds: f64, cycle: f64) -> f64 {
    let needed = (seconds / cycle) as usize;
    let mut good = 0;
    for (k, error) in errors.iter().enumerate() {
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

const EARLY: [f64; 6] = [0.05, 0.1, 0.2, 0.5, 1.0, 2.0];

/// The first time from which the error has an rms within a microsecond over both the next one and
/// the next five seconds.
fn lock_rms(errors: &[f64], constant: f64, cycle: f64) -> f64 {
    let (short, long) = ((1.0 / cycle) as usize, (5.0 / cycle) as usize);
    let mut sums = vec![0.0];
    for error in errors {
        let e = error - constant;
        sums.push(sums[sums.len() - 1] + if e.is_nan() { 1.0 } else { e * e });
    }
    let within = |k: usize, n: usize| sums[k + n] - sums[k] <= n as f64 * WITHIN * WITHIN;
    (0..errors.len().saturating_sub(long))
        .find(|k| (errors[*k] - constant).abs() <= WITHIN && within(*k, short) && within(*k, long))
        .map_or(f64::INFINITY, |k| k as f64 * cycle)
}

fn quantile(values: &[f64], part: f64) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * part).round() as usize]
}

fn all<F: Fn() -> Box<dyn Follower> + Sync>(
    case: &Case,
    first: u64,
    seeds: u64,
    make: F,
) -> Vec<Figures> {
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

fn print(name: &str, case: &Case, figures: &[Figures]) {
    let column = |f: fn(&Figures) -> f64| figures.iter().map(f).collect::<Vec<_>>();
    let rms = column(|f| f.rms * f.rms).iter().sum::<f64>() / figures.len() as f64;
    let max = column(|f| f.max);
    let (lock1, lock5) = (column(|f| f.lock1), column(|f| f.lock5));
    let synced = column(|f| f.synced);
    let mean = column(|f| f.mean - f.lead);
    println!(
        "{name:28} rms {:6.0} ({:4.0}) ns  max med {:5.0} worst {:5.0}  lock1 {:6.3}/{:6.3}  lock5 {:6.3}/{:6.3}  rms {:6.3}/{:6.3}  synced {:5.2}/{:5.2}  mean {:7.2} [{:.2},{:.2}] µs  shifts {} back {}  sigma {:.0} ns jitter {:.2}/{:.2}",
        rms.sqrt() * 1e9,
        bound(case) * 1e9,
        quantile(&max, 0.5) * 1e9,
        quantile(&max, 1.0) * 1e9,
        quantile(&lock1, 0.5),
        quantile(&lock1, 0.9),
        quantile(&lock5, 0.5),
        quantile(&lock5, 0.9),
        quantile(&column(|f| f.lock_rms), 0.5),
        quantile(&column(|f| f.lock_rms), 0.9),
        quantile(&synced, 0.5),
        quantile(&synced, 0.9),
        quantile(&mean, 0.5) * 1e6,
        quantile(&mean, 0.0) * 1e6,
        quantile(&mean, 1.0) * 1e6,
        figures.iter().map(|f| f.shifts).sum::<u32>(),
        figures.iter().map(|f| f.backward).sum::<u32>(),
        quantile(&column(|f| f.sigma), 0.5) * 1e9,
        quantile(&column(|f| f.normal), 0.5) * 1e6,
        quantile(&column(|f| f.exponential), 0.5) * 1e6,
    );
}

fn early(figures: &[Figures]) {
    for (i, at) in EARLY.iter().enumerate() {
        let mean = figures.iter().map(|f| f.early[i]).sum::<f64>() / figures.len() as f64;
        let square = figures.iter().map(|f| f.early[i].powi(2)).sum::<f64>() / figures.len() as f64;
        print!("  {at} s: {:.2} ({:+.2})", square.sqrt() * 1e6, mean * 1e6);
    }
    println!(" µs rms (mean)");
    for f in figures
        .iter()
        .filter(|f| f.early[5].abs() > 10e-6 || f.shifts > 0)
    {
        println!(
            "  seed {}: {:.1?} shifts {}",
            f.seed,
            f.early.map(|e| e * 1e6),
            f.shifts
        );
    }
}

fn cases_of() -> [(&'static str, Case); 3] {
    [
        ("5/20 stamped", Case::new(5.0, 20.0, true)),
        ("5/20", Case::new(5.0, 20.0, false)),
        ("20/100", Case::new(20.0, 100.0, false)),
    ]
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let seeds = arguments.first().and_then(|n| n.parse().ok()).unwrap_or(30);
    let first = arguments.get(1).and_then(|n| n.parse().ok()).unwrap_or(1);
    let wanted = |name: &str| arguments.len() < 3 || arguments[2..].iter().any(|a| a == name);
    let cases = [
        ("5/20 stamped", Case::new(5.0, 20.0, true)),
        ("5/20", Case::new(5.0, 20.0, false)),
        ("20/100", Case::new(20.0, 100.0, false)),
        ("1/20", Case::new(1.0, 20.0, false)),
        ("20/20", Case::new(20.0, 20.0, false)),
        ("5/100", Case::new(5.0, 100.0, false)),
    ];
    if wanted("cases") {
        for (name, case) in &cases {
            let figures = all(case, first, seeds, || Box::new(Observer::new(case.cycle)));
            print(name, case, &figures);
            early(&figures);
        }
    }
    if wanted("unordered") {
        for (name, case) in cases {
            let case = Case {
                in_order: false,
                ..case
            };
            let figures = all(&case, first, seeds, || Box::new(Observer::new(case.cycle)));
            print(&format!("{name}, unordered"), &case, &figures);
        }
    }
    if wanted("steps") {
        steps(first, seeds);
    }
    if wanted("peers") {
        for (name, case) in [
            ("5/20", Case::new(5.0, 20.0, false)),
            ("20/100", Case::new(20.0, 100.0, false)),
            ("1/20", Case::new(1.0, 20.0, false)),
        ] {
            peers(name, &case, first, seeds);
        }
    }
    if wanted("hour") {
        for (name, case) in cases_of() {
            let case = Case {
                seconds: 3600.0,
                ..case
            };
            let figures = all(&case, first, seeds.min(8), || {
                Box::new(Observer::new(case.cycle))
            });
            print(&format!("{name}, an hour"), &case, &figures);
        }
    }
    if wanted("load") {
        for (name, case) in cases_of() {
            for times in [5.0, 20.0, 0.2] {
                let case = Case {
                    load: Some((100.0, 160.0, times)),
                    ..case
                };
                let figures = all(&case, first, seeds, || Box::new(Observer::new(case.cycle)));
                print(&format!("{name}, 60 s x{times}"), &case, &figures);
            }
        }
    }
    if wanted("other") {
        for cycle in [1e-4, 1e-2, 1e-1] {
            let case = Case {
                cycle,
                seconds: if cycle < 1e-3 {
                    60.0
                } else {
                    240.0 * (cycle / 1e-3).min(8.0)
                },
                spikes: 1e-4,
                ..Case::new(5.0, 20.0, false)
            };
            let figures = all(&case, first, seeds, || Box::new(Observer::new(case.cycle)));
            print(&format!("5/20, T = {cycle} s"), &case, &figures);
        }
        for (sender, network) in [(0.05, 20.0), (20.0, 1.0), (1.0, 1.0), (100.0, 1000.0)] {
            let case = Case::new(sender, network, false);
            let figures = all(&case, first, seeds, || Box::new(Observer::new(case.cycle)));
            print(&format!("{sender}/{network}"), &case, &figures);
        }
    }
}

fn steps(first: u64, seeds: u64) {
    for (name, sender, network, stamps) in [
        ("5/20 stamped", 5.0, 20.0, true),
        ("5/20", 5.0, 20.0, false),
        ("20/100", 20.0, 100.0, false),
    ] {
        for by in [5e-6, -5e-6] {
            let case = Case {
                seconds: 120.0,
                drift_step: Some((80.0, by)),
                ..Case::new(sender, network, stamps)
            };
            let figures = all(&case, first, seeds, || Box::new(Observer::new(case.cycle)));
            let settle: Vec<f64> = figures.iter().map(|f| f.settle).collect();
            let worst: Vec<f64> = figures.iter().map(|f| f.worst).collect();
            println!(
                "{name:14} drift step {:+} ppm: settled {:.2}/{:.2} s, worst error {:.2}/{:.2} µs",
                by * 1e6,
                quantile(&settle, 0.5),
                quantile(&settle, 0.9),
                quantile(&worst, 0.5) * 1e6,
                quantile(&worst, 1.0) * 1e6
            );
        }
        for by in [2e-4, -2e-4, 2e-3, -2e-3] {
            let case = Case {
                seconds: 80.0,
                delay_step: Some((40.0, by)),
                ..Case::new(sender, network, stamps)
            };
            let figures = all(&case, first, seeds, || Box::new(Observer::new(case.cycle)));
            let detect: Vec<f64> = figures.iter().map(|f| f.detect).collect();
            let shifts: u32 = figures.iter().map(|f| f.shifts).sum();
            let backward: u32 = figures.iter().map(|f| f.backward).sum();
            println!(
                "{name:14} delay step {:+} µs: detected {:.3}/{:.3} s worst {:.3}, {shifts} shifts, backward {backward}",
                by * 1e6,
                quantile(&detect, 0.5),
                quantile(&detect, 0.9),
                quantile(&detect, 1.0)
            );
        }
    }
}

fn peers(name: &str, case: &Case, first: u64, seeds: u64) {
    let noise = (case.sender_jitter.powi(2) + case.network_jitter.powi(2)).sqrt();
    let figures = all(case, first, seeds, || Box::new(Observer::new(case.cycle)));
    print(&format!("{name} observer"), case, &figures);
    let figures = all(case, first, seeds, || {
        Box::new(Kalman::new(case.cycle, noise, case.walk))
    });
    print(&format!("{name} Kalman"), case, &figures);
    let best = |name: &str, tried: Vec<(String, Vec<Figures>)>| {
        let of = |figures: &[Figures]| figures.iter().map(|f| f.rms * f.rms).sum::<f64>();
        let (tuning, figures) = tried
            .into_iter()
            .min_by(|a, b| of(&a.1).total_cmp(&of(&b.1)))
            .unwrap();
        print(&format!("{name} {tuning}"), case, &figures);
    };
    let tried = [5.0, 10.0, 20.0, 40.0].map(|seconds| {
        (
            format!("{seconds} s"),
            all(case, first, seeds, || {
                Box::new(LeastSquares::new(case.cycle, seconds))
            }),
        )
    });
    best(&format!("{name} least squares"), tried.into());
    let mut tried = Vec::new();
    for length in [4, 8, 16, 32] {
        for bandwidth in [0.1, 0.2, 0.4] {
            tried.push((
                format!("{length}, {bandwidth}"),
                all(case, first, seeds, || {
                    Box::new(MinimumServo::new(case.cycle, length, bandwidth))
                }),
            ));
        }
    }
    best(&format!("{name} minimum PI"), tried);
    let tried = [10.0, 20.0, 40.0].map(|seconds| {
        (
            format!("{seconds} s"),
            all(case, first, seeds, || {
                Box::new(Hull::new(case.cycle, seconds))
            }),
        )
    });
    best(&format!("{name} hull"), tried.into());
}
