//! Prints the error of a far clock when its drift changes at once, and when the path's delay grows instead.
//!
//! `cargo run --release -p coaxle-clock --example drift_table -- [SEEDS]`
#![allow(missing_docs, clippy::print_stdout, clippy::print_stderr)]

mod cases;
mod scores;
mod world;

use std::process::ExitCode;

use cases::{DELAYS, DRIFTS, LINKS};
use scores::{Score, middle_and_most, score};

const FIRST_SEED: u64 = 9_000_000;

fn main() -> ExitCode {
    let seeds = std::env::args()
        .nth(1)
        .map_or(Ok(10), |seeds| seeds.parse());
    match seeds {
        Ok(seeds) if seeds > 0 => {
            print_table(seeds);
            ExitCode::SUCCESS
        }
        _ => {
            eprintln!("usage: drift_table [SEEDS], a number from 1 on");
            ExitCode::from(2)
        }
    }
}

fn print_table(seeds: u64) {
    println!(
        "| link | what happens | off at most, µs (worst seed) | settled after, s | off at the end, µs | steps | not covered, cycles | best exchange of a second, off at most, µs |"
    );
    println!("|--|--|--|--|--|--|--|--|");
    for (link_name, link) in &LINKS {
        for (course_name, course) in DRIFTS.iter().chain(&DELAYS) {
            let scores: Vec<_> = (0..seeds)
                .map(|seed| score(link, course, FIRST_SEED + seed))
                .collect();
            let micros = |of: fn(&Score) -> f64| {
                let [middle, most] = middle_and_most(&scores, of).map(|s| s * 1e6);
                format!("{middle:.1} ({most:.1})")
            };
            let [settled, latest] = middle_and_most(&scores, |score| score.settled_after);
            let steps: u32 = scores.iter().map(|score| score.steps).sum();
            let beyond: u32 = scores.iter().map(|score| score.beyond).sum();
            println!(
                "| {link_name} | {course_name} | {} | {settled:.1} ({latest:.1}) | {} | {steps} | {beyond} | {} |",
                micros(|score| score.worst),
                micros(|score| score.at_end),
                micros(|score| score.worst_of_exchanges),
            );
        }
    }
}
