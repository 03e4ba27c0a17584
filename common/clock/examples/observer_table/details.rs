//! The detailed figures of single groups of generated cases, as docs/OBSERVER.md quotes them.

use crate::figures::{EARLY, Figures, all, quantile};
use crate::peers::{Efficient, Hull, Kalman, LeastSquares, MinimumServo, Observer, Ts5066};
use crate::world::{Case, bound, efficient_width};

/// The words that select what is printed.
pub(crate) const WORDS: [&str; 8] = [
    "cases",
    "unordered",
    "steps",
    "peers",
    "hour",
    "load",
    "busy",
    "other",
];

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

/// Prints what the words select, everything if there are none.
pub(crate) fn print_details(seeds: u64, first: u64, words: &[String]) {
    let wanted = |name: &str| words.is_empty() || words.iter().any(|word| word == name);
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
            let ideal = Case {
                // Normal noise with the same Fisher information, for which the exact posterior is a Kalman filter.
                efficient: Some(efficient_width(case)),
                ..*case
            };
            let figures = all(&ideal, first, seeds, || Box::new(Efficient::new(&ideal)));
            print(&format!("{name}, what is possible"), &ideal, &figures);
            early(&figures);
        }
    }
    if wanted("unordered") {
        for (name, case) in cases {
            let case = Case {
                // As over UDP: a spike then delays one message and not those behind it.
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
            // Fifteen times as long as the other cases.
            let figures = all(&case, first, seeds.min(8), || {
                Box::new(Observer::new(case.cycle))
            });
            print(&format!("{name}, an hour"), &case, &figures);
        }
    }
    if wanted("load") {
        load(first, seeds);
    }
    if wanted("busy") {
        for network in [50.0, 75.0, 100.0] {
            let case = Case::busy(network);
            let figures = all(&case, first, seeds, || Box::new(Observer::new(case.cycle)));
            print(&format!("busy, {network} µs"), &case, &figures);
        }
        let case = Case::correlated_delay();
        let figures = all(&case, first, seeds, || Box::new(Observer::new(case.cycle)));
        print("busy, correlated delay", &case, &figures);
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

/// A minute of other jitter: the error, and the time until it is within a microsecond (rms) again.
fn load(first: u64, seeds: u64) {
    for (name, case) in cases_of() {
        for times in [5.0, 20.0, 0.2] {
            let case = Case {
                load: Some((100.0, 160.0, times)),
                ..case
            };
            let figures = all(&case, first, seeds, || Box::new(Observer::new(case.cycle)));
            let settle: Vec<f64> = figures.iter().map(|f| f.settle).collect();
            let worst: Vec<f64> = figures.iter().map(|f| f.worst).collect();
            println!(
                "{name:14} network jitter x {times}: worst error {:.2}/{:.2} µs, back after {:.2}/{:.2} s, {} shifts, {} backward",
                quantile(&worst, 0.5) * 1e6,
                quantile(&worst, 1.0) * 1e6,
                quantile(&settle, 0.5),
                quantile(&settle, 1.0),
                figures.iter().map(|f| f.shifts).sum::<u32>(),
                figures.iter().map(|f| f.backward).sum::<u32>(),
            );
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
    let tried = [0.95, 0.5].map(|slope| {
        (
            format!("slope {slope}"),
            all(case, first, seeds, || {
                Box::new(Ts5066::new(case.cycle, slope))
            }),
        )
    });
    best(&format!("{name} TS5066"), tried.into());
}
