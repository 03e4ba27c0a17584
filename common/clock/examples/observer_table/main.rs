//! Prints how well the observer and simpler methods follow a far clock, in virtual time, over
//! generated and over recorded arrivals.
//!
//! `cargo run --release -p coaxle-clock --example observer_table -- --help`
#![allow(
    missing_docs,
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::unwrap_used
)]

mod arguments;
mod bench;
mod cases;
mod details;
mod drive;
mod figures;
mod link;
mod peers;
mod recorded;
mod references;
mod scores;
mod table;
mod world;

use std::process::ExitCode;

use arguments::{Arguments, Table, USAGE};
use bench::Subject;
use recorded::StampedBy;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let printed = match arguments::parse(&arguments) {
        Ok(Arguments::Help) => {
            println!("{USAGE}");
            Ok(())
        }
        Ok(Arguments::Table(wanted)) => print_table(&wanted),
        Ok(Arguments::Details {
            seeds,
            first_seed,
            words,
        }) => {
            details::print_details(seeds, first_seed, &words);
            Ok(())
        }
        Err(error) => Err(format!("{error}\n\n{USAGE}")),
    };
    match printed {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn print_table(wanted: &Table) -> Result<(), String> {
    let recordings = if wanted.groups.contains(&cases::RECORDED) {
        recorded::load(&wanted.recorded)?
    } else {
        Vec::new()
    };
    println!("{}", table::header());
    let print = |name: &str, bound: Option<f64>, subject: Subject<'_>| {
        let scores = bench::all(subject, wanted.first_seed, wanted.seeds);
        println!("{}", table::row(name, bound, &scores));
    };
    for group in &wanted.groups {
        for generated in cases::generated(group) {
            let bound = generated.case.has_bound();
            let bound = bound.then(|| world::bound(&generated.case));
            print(&generated.name, bound, Subject::Generated(&generated.case));
        }
    }
    for recording in &recordings {
        let name = &recording.name;
        print(name, None, Subject::Recorded(recording, StampedBy::Thread));
        if recording.has_kernel_stamps() {
            let name = format!("{name}, kernel stamps");
            print(&name, None, Subject::Recorded(recording, StampedBy::Kernel));
        }
    }
    println!("\n{}", table::LEGEND);
    Ok(())
}
