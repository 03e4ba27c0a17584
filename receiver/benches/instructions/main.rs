//! Cost of the parts of a cycle in instructions, counted by Callgrind: the figures are equal on
//! every run, independent of the machine's load, so that a slower change is seen early.
//!
//! ```sh
//! cargo bench -p coaxle-receiver --no-default-features --bench instructions
//! ```
//!
//! Each part is run twice, with different numbers of calls; its cost is the difference, so that the
//! preparation does not count. A cost above the budget is an error. Without valgrind no measurement
//! is made, which is reported and not an error.

mod parts;

use std::io::{self, Write as _};
use std::process::{Command, ExitCode};

use parts::{PARTS, Part};

/// The argument before the name of a part and a number of calls.
const RUN: &str = "--run";

/// Tolerance for the code layout of other compilers.
const TOLERANCE: f64 = 1.03;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, run, name, calls] = arguments.as_slice()
        && run == RUN
    {
        return run_part(name, calls);
    }
    match measure_all() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            let _ = writeln!(io::stderr(), "not measured: {error}");
            // A machine without valgrind still runs all other benches.
            ExitCode::SUCCESS
        }
    }
}

fn run_part(name: &str, calls: &str) -> ExitCode {
    let part = PARTS.iter().find(|part| part.name == name);
    let (Some(part), Ok(calls)) = (part, calls.parse()) else {
        return ExitCode::FAILURE;
    };
    (part.run)(calls);
    ExitCode::SUCCESS
}

/// Measures all parts; returns true if all keep their budgets.
fn measure_all() -> io::Result<bool> {
    let mut keeps = true;
    let mut out = io::stdout();
    writeln!(out, "| instructions | a call | budget |\n|--|--|--|")?;
    for part in PARTS {
        let instructions = measure(part)?;
        let is_within = |budget: f64| instructions <= budget * TOLERANCE;
        let budget = match part.budget {
            None => String::new(),
            Some(budget) if is_within(budget) => format!("{budget:.0}"),
            Some(budget) => format!("{budget:.0} **exceeded**"),
        };
        writeln!(out, "| {} | {instructions:.0} | {budget} |", part.name)?;
        keeps &= part.budget.is_none_or(is_within);
    }
    Ok(keeps)
}

/// Instructions of a call.
fn measure(part: &Part) -> io::Result<f64> {
    let few = count(part, part.calls)?;
    let many = count(part, 2 * part.calls)?;
    // n and 2n calls after equal preparations: the difference is that of n calls alone.
    Ok((many - few) / f64::from(part.calls))
}

/// Instructions of a whole process that makes this number of calls.
fn count(part: &Part, calls: u32) -> io::Result<f64> {
    let output = Command::new("valgrind")
        // The totals on standard error suffice; the profile of each run would be a large file.
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe()?)
        .args([RUN, part.name, &calls.to_string()])
        .output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    let collected = said
        .lines()
        .find_map(|line| line.split("Collected :").nth(1));
    collected
        .filter(|_| output.status.success())
        .and_then(|number| number.trim().parse().ok())
        .ok_or_else(|| io::Error::other(format!("{}: {said}", part.name)))
}
