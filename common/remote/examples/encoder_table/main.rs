//! Prints the accuracy of an encoder master and simpler methods that follow an axis, in virtual time.
//!
//! `cargo run --release -p coaxle-remote --example encoder_table -- [RUNS] [FIRST-SEED] [METHODS]`:
//! RUNS of each case, default 10; seeds from FIRST-SEED on, default 1000; number of METHODS,
//! default 4, beginning with the encoder master.
#![allow(
    missing_docs,
    unreachable_pub,
    clippy::print_stdout,
    clippy::unwrap_used
)]

mod figures;
mod motion;
mod peers;
mod world;

use figures::{Figures, all};
use peers::{AlphaBeta, Conditioned, Differences, Follower, Pt1, parameters};
use world::{Case, INCREMENTS, PROFILES, Profile, SPEEDS};

type Make = dyn Fn(&Case) -> Box<dyn Follower> + Sync;

fn main() {
    let mut numbers = std::env::args().skip(1).map(|word| word.parse::<u64>());
    let mut number = |otherwise: u64| numbers.next().and_then(Result::ok).unwrap_or(otherwise);
    let (runs, first) = (number(10), number(1_000));
    let methods_shown = number(4) as usize;
    for profile in PROFILES {
        println!("{profile:?}");
        println!("{HEADER}");
        for increment in INCREMENTS {
            for (name, make) in methods().iter().take(methods_shown) {
                let figures = worst(profile, increment, first, runs, make);
                println!("{}", row(increment, name, &figures));
            }
        }
        println!();
    }
}

const HEADER: &str = "| q, mm | method | largest by speed, µm | ever | standing | rms | mean | v rms, mm/s | a, mm/s² | j, mm/s³ | false | under | sigmas |\n|--|--|--|--|--|--|--|--|--|--|--|--|--|";

fn methods() -> Vec<(&'static str, Box<Make>)> {
    vec![
        (
            "master",
            Box::new(|case| Box::new(Conditioned::new(parameters(case)))),
        ),
        (
            "differences",
            Box::new(|case| Box::new(Differences::new(case.increment))),
        ),
        (
            "PT1 20 ms",
            Box::new(|case| Box::new(Pt1::new(case.increment, 0.02))),
        ),
        (
            "α-β 100 rad/s",
            Box::new(|case| Box::new(AlphaBeta::new(case.increment, 100.0))),
        ),
    ]
}

/// The worst of every speed.
fn worst(profile: Profile, increment: f64, first: u64, runs: u64, make: &Make) -> Vec<Figures> {
    let of = |speed: f64| {
        let cases: Vec<_> = (first..first + runs)
            .map(|seed| Case::new(profile, increment, speed, seed))
            .collect();
        let figures = all(&cases, make);
        figures
            .iter()
            .fold(Figures::default(), |worst, other| worst.or(other))
    };
    SPEEDS.map(of).to_vec()
}

fn row(increment: f64, name: &str, by_speed: &[Figures]) -> String {
    let each = |f: fn(&Figures) -> f64| {
        let texts: Vec<_> = by_speed
            .iter()
            .map(|figures| format!("{:.1}", f(figures)))
            .collect();
        texts.join(" / ")
    };
    let worst = by_speed
        .iter()
        .fold(Figures::default(), |worst, other| worst.or(other));
    format!(
        "| {increment} | {name} | {} | {:.1} | {:.1} | {:.2} | {} | {} | {:.0} | {:.3e} | {} | {} | {} |",
        each(|f| f.largest),
        worst.ever,
        worst.standing,
        worst.square.sqrt(),
        each(|f| f.mean),
        each(|f| f.velocity_square.sqrt()),
        worst.acceleration,
        worst.jerk,
        worst.false_directions,
        worst.undershoots,
        each(|f| f.sigmas),
    )
}
