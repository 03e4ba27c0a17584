//! Multiplies each tuned constant of the clock by 0.7 and by 1.3, and prints what that changes in short runs of one seed each.
//!
//! `cargo run --release -p coaxle-clock --features perturb --example tuning -- [--long] [BLOCK[.CONSTANT]...]`
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

fn main() -> ExitCode {
    let mut wanted: Vec<String> = std::env::args().skip(1).collect();
    let is_long = wanted.first().is_some_and(|word| word == "--long");
    if is_long {
        wanted.remove(0);
    }
    let cases = if is_long { cases::long() } else { cases::all() };
    let constants: Vec<TunedConstant> = TunedConstant::all()
        .filter(|constant| wanted.is_empty() || wanted.iter().any(|word| constant.is(word)))
        .collect();
    if constants.is_empty() {
        eprintln!("none of the constants is {}", wanted.join(" or "));
        return ExitCode::from(2);
    }
    table::print(&constants, &cases);
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
}
