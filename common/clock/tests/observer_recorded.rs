//! Accuracy of the observer where delays are correlated: over recorded arrivals, and over generated ones of the kinds
//! that were recorded.
//!
//! `cargo run --release --example observer_table -- --help` shows how to print these figures for longer runs.
#![allow(missing_docs, dead_code, unreachable_pub, clippy::unwrap_used)]

#[path = "../examples/observer_table/bench.rs"]
mod bench;
#[path = "../examples/observer_table/drive.rs"]
mod drive;
#[path = "../examples/observer_table/figures.rs"]
mod figures;
#[path = "../examples/observer_table/link.rs"]
mod link;
#[path = "../examples/observer_table/peers.rs"]
mod peers;
#[path = "../examples/observer_table/recorded.rs"]
mod recorded;
#[path = "../examples/observer_table/references.rs"]
mod references;
#[path = "../examples/observer_table/scores.rs"]
mod scores;
#[path = "../examples/observer_table/world.rs"]
mod world;

use bench::{Scores, Subject};
use link::{Correlated, PowerSaving};
use recorded::StampedBy;
use scores::Score;
use std::path::Path;
use world::Case;

/// First of the seeds, on which no parameter was tuned.
const FIRST_SEED: u64 = 7_000_000;

fn rms<'a>(scores: impl ExactSizeIterator<Item = &'a Score>) -> f64 {
    let n = scores.len() as f64;
    (scores.map(|score| score.mean_square).sum::<f64>() / n).sqrt()
}

fn rms_of_observer(runs: &[Scores]) -> f64 {
    rms(runs.iter().map(|run| &run.observer))
}

#[test]
fn recorded_arrivals_are_followed() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/arrivals");
    for recording in recorded::load(&directory).unwrap() {
        let name = &recording.name;
        let largest = match name.as_str() {
            // On busy machines the lowest delay itself varies by a µs.
            "udp-2-busy" | "udp-4-busy" => 1.5e-6,
            _ => 0.7e-6,
        };
        let subject = Subject::Recorded(&recording, StampedBy::Thread);
        let runs = bench::all(subject, FIRST_SEED, 5);
        let observer = rms_of_observer(&runs);
        assert!(observer <= largest, "{name}: {observer} s");
        for (seed, run) in runs.iter().enumerate() {
            let [observer, servo] =
                [&run.observer, &run.servos[0]].map(|score| rms([score].into_iter()));
            assert!(
                // On the full recordings the servo is better on one of them, 0.20 for 0.23 µs, and the pieces here are short.
                observer <= 1.5 * servo,
                "{name}, {seed}: {observer} s, servo {servo} s"
            );
            let claims = run.observer.claims.as_ref().unwrap();
            assert_eq!(claims.shifts, 0, "{name}, {seed}");
            let (offset, drift) = (claims.within, claims.drift_within);
            assert!(offset >= 0.97, "{name}, {seed}: {offset}");
            assert!(drift >= 0.97, "{name}, {seed}: {drift}");
        }
    }
}

/// The magnitude of a first-order autoregressive process on top of other jitter.
fn half_normal(width: f64, time: f64) -> Case {
    Case {
        correlated: Some(Correlated::HalfNormal { width, time }),
        ..Case::new(5.0, 20.0, false)
    }
}

#[test]
fn delays_that_are_alike_for_tenths_of_a_second() {
    let case = half_normal(15e-6, 0.3);
    let runs = bench::all(Subject::Generated(&case), FIRST_SEED, 10);
    for (seed, run) in runs.iter().enumerate() {
        let rms = rms([&run.observer].into_iter());
        // The worst of thirty seeds has 1.4 µs.
        assert!(rms <= 2e-6, "{seed}: {rms} s");
    }
}

#[test]
fn delays_that_are_alike_for_seconds() {
    let case = half_normal(40e-6, 5.0);
    let rms = rms_of_observer(&bench::all(Subject::Generated(&case), FIRST_SEED, 10));
    assert!(rms <= 11e-6, "{rms} s");
}

#[test]
fn a_small_step_of_the_delay_does_not_kick_the_drift() {
    let case = Case {
        seconds: 60.0,
        delay_step: Some((40.0, 30e-6)),
        ..Case::new(5.0, 20.0, false)
    };
    for run in bench::all(Subject::Generated(&case), FIRST_SEED, 10) {
        let worst = run.observer.claims.unwrap().worst_drift_ppm;
        // 22 ppm without the hold of the estimate.
        assert!(worst < 2.0, "{worst} ppm");
    }
}

/// Asserts that the runs are within three standard deviations for 99 % of their cycles, none of them for less than 98 %, and
/// that the reported standard deviation is on the mean no larger than `largest` times the error.
fn assert_honest(name: &str, runs: &[Scores], largest: f64) {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let of = |run: &Scores| {
        let claims = run.observer.claims.as_ref().unwrap();
        (
            claims.within,
            claims.sigma / run.observer.mean_square.sqrt(),
        )
    };
    let (parts, ratios): (Vec<f64>, Vec<f64>) = runs.iter().map(of).unzip();
    let worst = parts.iter().copied().fold(1.0, f64::min);
    assert!(mean(&parts) >= 0.99 && worst >= 0.98, "{name}: {parts:?}");
    assert!(mean(&ratios) < largest, "{name}: {ratios:?}");
}

/// Before it was calibrated by its own innovations: 98.3, 90 and, in the worst run of arrivals on 50 µs, 65 %. Its later
/// calibration was forgotten too soon: 87 % in one of thirty runs of the first case, 95 % where a servo sets back every 10 s.
#[test]
fn it_is_as_sure_as_it_says() {
    let plain = Case::new(5.0, 20.0, false);
    let stamped = Case::new(5.0, 20.0, true);
    let servo = |period: f64| Case {
        servo: Some((1e-6, period)),
        ..plain
    };
    let sine = Case {
        sine_drift: Some((5e-6, 20.0)),
        ..plain
    };
    let grid = Case {
        arrival_grid: Some(50e-6),
        ..plain
    };
    let correlated = |case: Case| Case {
        correlated: half_normal(40e-6, 5.0).correlated,
        ..case
    };
    for (name, case, largest) in [
        ("5/20", plain, 2.5),
        ("5/20 stamped", stamped, 2.5),
        ("AR(1) 40 µs/5 s", correlated(plain), 5.0),
        ("AR(1) 40 µs/5 s, stamped", correlated(stamped), 5.0),
        ("sine 5 ppm/20 s", sine, 2.5),
        ("servo 1 µs/s, 4 s", servo(4.0), 2.5),
        ("servo 1 µs/s, 10 s", servo(10.0), 2.5),
        ("arrivals on 50 µs", grid, 6.0),
    ] {
        let runs = bench::all(Subject::Generated(&case), FIRST_SEED, 10);
        assert_honest(name, &runs, largest);
    }
}

/// An access point that keeps messages back for 102 ms: 2 ms off before, by the waiting of whole batches, and within three
/// standard deviations for 96 and 83 % of the time, as waits were taken for independent.
#[test]
fn the_last_of_each_batch_is_followed() {
    for cycle in [1e-3, 1e-2] {
        let power_saving = PowerSaving {
            beacons: 0.1024,
            airtime: 50e-6,
        };
        let case = Case {
            cycle,
            power_saving: Some(power_saving),
            ..Case::new(5.0, 20.0, true)
        };
        let runs = bench::all(Subject::Generated(&case), FIRST_SEED, 5);
        let observer = rms_of_observer(&runs);
        let regression = rms(runs.iter().map(|run| &run.regression));
        assert!(
            observer <= 2.0 * regression,
            "{cycle}: {observer} s, regression {regression} s"
        );
        assert_honest(&format!("{cycle} s"), &runs, 3.0);
    }
}
