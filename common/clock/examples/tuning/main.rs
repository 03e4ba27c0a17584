//! Multiplies each tuned constant of the clock by 0.7 and by 1.3, and prints what that changes in short runs of one seed each.
//!
//! `cargo run --release -p coaxle-clock --features perturb --example tuning -- [--long] [--extreme] [BLOCK[.CONSTANT]...]`
#![allow(
    missing_docs,
    dead_code,
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::unwrap_used
)]

mod cases;
mod far;
mod gate;
mod long;
mod outcome;
mod table;

#[path = "../observer_table/drive.rs"]
mod drive;
#[path = "../observer_table/figures.rs"]
mod figures;
#[path = "../observer_table/link.rs"]
mod link;
#[path = "../observer_table/peers.rs"]
mod peers;
#[path = "../observer_table/scores.rs"]
mod scores;
#[path = "../observer_table/world.rs"]
mod world;

use std::process::ExitCode;

use table::TunedConstant;

/// Factors on a constant, …
const FACTORS: [f64; 2] = [0.7, 1.3];
/// … and those of which one mostly switches its mechanism off: without any change it may go.
const EXTREMES: [f64; 2] = [1e-3, 1e3];

fn main() -> ExitCode {
    let mut wanted: Vec<String> = std::env::args().skip(1).collect();
    let mut is_set = |option: &str| {
        let words = wanted.len();
        wanted.retain(|word| word != option);
        wanted.len() < words
    };
    let is_long = is_set("--long");
    let factors = if is_set("--extreme") {
        EXTREMES
    } else {
        FACTORS
    };
    let cases = if is_long { long::all() } else { cases::all() };
    let constants: Vec<TunedConstant> = TunedConstant::all()
        .filter(|constant| wanted.is_empty() || wanted.iter().any(|word| constant.is(word)))
        .collect();
    if constants.is_empty() {
        eprintln!("none of the constants is {}", wanted.join(" or "));
        return ExitCode::from(2);
    }
    table::print(&constants, &cases, factors);
    ExitCode::SUCCESS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perturbed_constant_changes_the_run_until_it_is_restored() {
        let cases = cases::all();
        let case = cases.iter().find(|case| case.name == "5/20").unwrap();
        let before = case.outcome();
        let clamp = TunedConstant::all().find(|constant| constant.is("FilterTuning.clamp"));
        let clamp = clamp.unwrap();
        // A clamp at 1.5 standard deviations is met by every seventh message.
        let _ = (clamp.block.perturb)(clamp.name, 0.3);
        assert_ne!(case.outcome().digest, before.digest);
        (clamp.block.restore)();
        assert_eq!(case.outcome().digest, before.digest);
    }

    #[test]
    fn no_constant_is_named_twice() {
        let mut names: Vec<String> = TunedConstant::all()
            .map(|constant| constant.path())
            .collect();
        names.sort();
        let count = names.len();
        names.dedup();
        assert_eq!(names.len(), count);
    }

    #[test]
    fn the_manual_has_a_row_of_each_constant_and_of_no_other() {
        let manual = include_str!("../../../../docs/OBSERVER-METHOD.md");
        let rows = manual.lines().filter_map(|line| {
            let (path, _) = line.strip_prefix("| `")?.split_once('`')?;
            path.contains("Tuning.").then_some(path)
        });
        let mut rows: Vec<&str> = rows.collect();
        rows.sort_unstable();
        rows.dedup();
        let mut paths: Vec<String> = TunedConstant::all()
            .map(|constant| constant.path())
            .collect();
        paths.sort();
        assert_eq!(rows, paths);
    }
}
