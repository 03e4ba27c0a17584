//! Accuracy of an encoder master that follows an axis, over seeds that no parameter was tuned on,
//! measured by the differences of the positions it emits.
//!
//! `cargo run --release -p coaxle-remote --example encoder_table` prints these figures and those of
//! simpler methods. The long test is run with `cargo test --release -p coaxle-remote --test
//! encoder -- --ignored --nocapture`.
#![allow(
    missing_docs,
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    clippy::print_stdout
)]

#[path = "../../examples/encoder_table/figures.rs"]
mod figures;
#[path = "../../examples/encoder_table/motion.rs"]
mod motion;
mod no_alloc;
#[path = "../../examples/encoder_table/peers.rs"]
mod peers;
#[path = "../../examples/encoder_table/world.rs"]
mod world;

use figures::{Figures, all};
use peers::{Conditioned, parameters};
use world::{Case, INCREMENTS, PROFILES, Profile, SPEEDS};

// Far from the default seeds of the example, 1000 and on.
const FIRST_SEED: u64 = 7_000_000;
const SEEDS: u64 = 6;

fn cases(profile: Profile, increment: f64, speeds: &[f64], seeds: u64) -> Vec<Case> {
    let of_speed = |&speed: &f64| {
        (FIRST_SEED..FIRST_SEED + seeds).map(move |seed| Case::new(profile, increment, speed, seed))
    };
    speeds.iter().flat_map(of_speed).collect()
}

fn worst(cases: &[Case]) -> Figures {
    all(cases, &|case| Box::new(Conditioned::new(parameters(case))))
        .iter()
        .fold(Figures::default(), |worst, other| worst.or(other))
}

/// Asserts the largest error, µm, for each increment.
fn assert_largest(profile: Profile, speeds: &[f64], wanted: [f64; 4]) {
    for (increment, wanted) in INCREMENTS.into_iter().zip(wanted) {
        let largest = worst(&cases(profile, increment, speeds, SEEDS)).largest;
        assert!(largest <= wanted, "{profile:?} {increment}: {largest} µm");
    }
}

/// Limits that hold for any motion of an axis.
fn assert_bounds(profile: Profile, increment: f64, figures: &Figures) {
    let name = format!("{profile:?} {increment}: {figures:#?}");
    assert_eq!(figures.false_directions, 0, "{name}");
    assert_eq!(figures.undershoots, 0, "{name}");
    assert!(figures.jerk <= 1e5 * 1.000_01, "{name}");
    assert!(figures.acceleration <= 5_000.0 * 1.000_01, "{name}");
    // A ramp that is unobserved for a twentieth of a second is unknown for that long.
    let unseen = if profile == Profile::BurstLoss {
        30e3
    } else {
        0.0
    };
    assert!(figures.ever <= 3_000.0 + unseen, "{name}");
}

#[test]
fn a_constant_speed_is_followed() {
    // Bounds of this file are the wanted accuracies in µm, for 0.001, 0.01, 0.05 and 0.1 mm.
    assert_largest(Profile::Constant, &SPEEDS, [15.0, 38.0, 100.0, 170.0]);
}

#[test]
fn a_ripple_is_followed() {
    assert_largest(Profile::Ripple, &SPEEDS, [20.0, 50.0, 100.0, 170.0]);
}

#[test]
fn a_soft_ramp_is_followed() {
    assert_largest(Profile::SoftRamp, &SPEEDS, [35.0, 110.0, 340.0, 570.0]);
}

/// At constant speed. In ramps the errors are those of the still unknown acceleration.
#[test]
fn the_uncertainty_is_that_of_the_errors() {
    for increment in INCREMENTS {
        let sigmas = worst(&cases(Profile::Constant, increment, &SPEEDS, SEEDS)).sigmas;
        // Errors repeat with the beat of counts and cycles, and are no white noise.
        assert!((0.2..4.0).contains(&sigmas), "{increment}: {sigmas}");
    }
}

/// An axis with the same jerk limit cannot be caught up with while it uses it.
#[test]
fn stop_and_go_with_all_the_jerk_there_is_is_followed_roughly() {
    let wanted = [360.0, 900.0, 2_100.0, 3_200.0];
    assert_largest(Profile::StopAndGo, &[2_000.0], wanted);
}

#[test]
fn it_stands_where_the_axis_does() {
    for increment in INCREMENTS {
        let of = |profile| worst(&cases(profile, increment, &SPEEDS, SEEDS)).standing;
        let (stopped, trembling) = (of(Profile::StopAndGo), of(Profile::Flicker));
        assert!(
            // An increment and a half, in µm: half of one is unseen, and the walk back leaves the rest.
            stopped <= 1.5e3 * increment + 2.0,
            "{increment}: {stopped} µm"
        );
        assert!(
            trembling <= 1.3e3 * increment,
            "{increment}: {trembling} µm"
        );
    }
}

/// If a sample is a whole number of increments after the last, or the other way round, all samples
/// see the same unknown part of an increment; hence these speeds. Slower than an increment in a few
/// cycles the edges still beat with the cycles.
#[test]
fn off_resonance_the_mean_is_right() {
    for increment in INCREMENTS {
        let slow = 0.5 + 50.0 * increment;
        for (per_cycle, wanted) in [(0.161_8, slow), (0.618, 0.5), (3.382, 0.5), (12.618, 0.5)] {
            let speed = per_cycle * increment / world::CYCLE;
            if speed > 2_000.0 {
                continue;
            }
            let exact = |case: Case| Case {
                spread: 0.0,
                ..case
            };
            let cases = cases(Profile::Constant, increment, &[speed], SEEDS);
            let cases: Vec<_> = cases.into_iter().map(exact).collect();
            let mean = worst(&cases).mean;
            assert!(mean <= wanted, "{increment}, {speed} mm/s: {mean} µm");
        }
    }
}

/// A shaft that trembles over several increments is followed as well as noise of that size allows.
#[test]
fn vibration_that_was_announced_is_averaged() {
    for (vibration, wanted) in [(0.3, 1.5), (0.5, 1.5), (1.5, 3.0)] {
        for profile in [Profile::Constant, Profile::Flicker] {
            for increment in INCREMENTS {
                let cases = cases(profile, increment, &SPEEDS, SEEDS);
                let trembling = |case: Case| Case { vibration, ..case };
                let cases: Vec<_> = cases.into_iter().map(trembling).collect();
                let figures = worst(&cases);
                let name = format!("{profile:?} {vibration}, {increment}: {figures:#?}");
                assert_eq!(figures.false_directions, 0, "{name}");
                assert!(figures.largest <= wanted * 1e3 * increment + 5.0, "{name}");
            }
        }
    }
}

#[test]
fn limits_and_directions_are_kept_in_every_profile() {
    for profile in PROFILES {
        for increment in INCREMENTS {
            let figures = worst(&cases(profile, increment, &SPEEDS, SEEDS));
            assert_bounds(profile, increment, &figures);
        }
    }
}

/// 500 runs of every profile, increment and speed: 80 000 runs, under a minute with `--release`.
#[test]
#[ignore = "long: see the top of this file"]
fn limits_and_directions_are_kept_in_500_runs_of_everything() {
    for profile in PROFILES {
        for increment in INCREMENTS {
            let mut of_all = Figures::default();
            for speed in SPEEDS {
                let figures = worst(&cases(profile, increment, &[speed], 500));
                let Figures {
                    largest,
                    ever,
                    standing,
                    jerk,
                    ..
                } = figures;
                println!(
                    "{profile:?} {increment} {speed}: {largest:.1} {ever:.1} {standing:.1} µm, {:.2} mm/s, {:.0} mm/s², {jerk:.0} mm/s³, {} {}",
                    figures.velocity_square.sqrt(),
                    figures.acceleration,
                    figures.false_directions,
                    figures.undershoots,
                );
                of_all = of_all.or(&figures);
            }
            assert_bounds(profile, increment, &of_all);
        }
    }
}
