//! `coaxle saw`: plans a flying saw's synchronisation and shows it.

mod characteristics;
mod course;
mod edit;
mod plan;
mod plot;
mod refusal;
mod text;

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, Subcommand};
use coaxle_files::saw::SawFile;
use coaxle_report::inspect;

/// Commands on a saw file.
#[derive(Debug, Subcommand)]
pub enum SawSubcommand {
    /// Print the profile and its characteristic values, or why it is refused
    Plan(SawPlanArgs),
    /// Draw position, velocity, acceleration and jerk of the slave, as a page for a browser
    Plot(SawPlotArgs),
    /// Move distances, speeds and limits on a page in the browser, on this PC: docs/SAWS.md
    Edit(edit::SawEditArgs),
}

/// Arguments of `coaxle saw plan`.
#[derive(Debug, Args)]
pub struct SawPlanArgs {
    /// Saw file, TOML
    file: PathBuf,
    /// As JSON with all digits
    #[arg(long)]
    json: bool,
}

/// Arguments of `coaxle saw plot`.
#[derive(Debug, Args)]
pub struct SawPlotArgs {
    /// Saw file, TOML
    file: PathBuf,
    /// The page to write
    #[arg(short, long, value_name = "HTML")]
    output: PathBuf,
}

/// Runs a command and prints its result; false if the synchronisation is refused. A reader that
/// stops early, as `head` does, is no error.
///
/// # Errors
/// A saw file that cannot be read, naming file and field; an output that cannot be written.
pub fn print(command: &SawSubcommand) -> anyhow::Result<bool> {
    match command {
        SawSubcommand::Edit(args) => edit::run(args).map(|_| true),
        command => inspect::print(|out| run(command, out)),
    }
}

/// Runs a command and writes its result.
///
/// # Errors
/// As [`print()`].
pub fn run(command: &SawSubcommand, out: &mut dyn Write) -> anyhow::Result<bool> {
    match command {
        SawSubcommand::Plan(args) => {
            let saw = SawFile::load(&args.file)?;
            let planned = saw.plan();
            let answer = match (&planned, args.json) {
                (Ok(plan), true) => format!("{:#}", plan::json_of(&saw, plan)),
                (Ok(plan), false) => plan::in_words(&saw, plan),
                (Err(refusal), true) => format!("{:#}", refusal::json_of(&saw, refusal)),
                (Err(refusal), false) => refusal::in_words(&args.file, &saw, refusal),
            };
            writeln!(out, "{answer}")?;
            // A refusal is an answer, printed like a plan; only the exit code tells both apart.
            Ok(planned.is_ok())
        }
        SawSubcommand::Plot(args) => {
            let saw = SawFile::load(&args.file)?;
            match saw.plan() {
                Ok(plan) => inspect::write_plot(&args.output, &plot::page(&saw, &plan), out)?,
                Err(refusal) => {
                    writeln!(out, "{}", refusal::in_words(&args.file, &saw, &refusal))?;
                    return Ok(false);
                }
            }
            Ok(true)
        }
        // A page is not written: `print` serves it.
        SawSubcommand::Edit(_) => Ok(true),
    }
}

#[cfg(test)]
mod tests;
