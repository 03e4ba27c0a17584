//! `coaxle gear`: plans a flying gear and shows it.

mod course;
mod plan;
mod plot;

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use coaxle_files::gear::GearFile;
use coaxle_gear::FlyingGearError;
use coaxle_report::inspect;
use serde_json::{Value, json};

/// Commands on a gear file.
#[derive(Debug, Subcommand)]
pub enum GearSubcommand {
    /// Print where the gear engages and releases and the load on the slave, or why it is refused
    Plan(GearPlanArgs),
    /// Draw position, velocity, acceleration and jerk of the slave, as a page for a browser
    Plot(GearPlotArgs),
}

/// Arguments of `coaxle gear plan`.
#[derive(Debug, Args)]
pub struct GearPlanArgs {
    /// Gear file, TOML
    file: PathBuf,
    /// As JSON with all digits
    #[arg(long)]
    json: bool,
}

/// Arguments of `coaxle gear plot`.
#[derive(Debug, Args)]
pub struct GearPlotArgs {
    /// Gear file, TOML
    file: PathBuf,
    /// The page to write
    #[arg(short, long, value_name = "HTML")]
    output: PathBuf,
}

/// Runs a command and prints its result; false if the gear is refused. A reader that stops early, as `head` does, is no
/// error.
///
/// # Errors
/// A gear file that cannot be read, naming file and field; an output that cannot be written.
pub fn print(command: &GearSubcommand) -> anyhow::Result<bool> {
    inspect::print(|out| run(command, out))
}

/// Runs a command and writes its result.
///
/// # Errors
/// As [`print()`].
pub fn run(command: &GearSubcommand, out: &mut dyn Write) -> anyhow::Result<bool> {
    match command {
        GearSubcommand::Plan(args) => {
            let file = GearFile::load(&args.file)?;
            // By the very check of a slave that enables the gear, so that the answer is that of a machine.
            let planned = file.gear();
            let answer = match (&planned, args.json) {
                (Ok(gear), true) => format!("{:#}", plan::json_of(&file, gear)),
                (Ok(gear), false) => plan::in_words(&file, gear),
                (Err(refusal), true) => format!("{:#}", refusal_json(&file, refusal)),
                (Err(refusal), false) => refused(&args.file, refusal),
            };
            writeln!(out, "{answer}")?;
            // A refusal is an answer, printed like a plan; only the exit code tells both apart.
            Ok(planned.is_ok())
        }
        GearSubcommand::Plot(args) => {
            let file = GearFile::load(&args.file)?;
            match file.gear() {
                Ok(gear) => inspect::write_plot(&args.output, &plot::page(&file, &gear), out)?,
                Err(refusal) => {
                    writeln!(out, "{}", refused(&args.file, &refusal))?;
                    return Ok(false);
                }
            }
            Ok(true)
        }
    }
}

fn refused(file: &Path, refusal: &FlyingGearError) -> String {
    format!("{}: refused: {refusal}", file.display())
}

fn refusal_json(file: &GearFile, refusal: &FlyingGearError) -> Value {
    let fastest = match refusal {
        // The only refusal that a slower master cures.
        FlyingGearError::TooFast { fastest, .. } => Some(fastest),
        _ => None,
    };
    json!({
        "title": file.title,
        "master_unit": file.master_unit,
        "slave_unit": file.slave_unit,
        "refusal": {
            "code": refusal.code(),
            "message": refusal.to_string(),
            "remedy": { "master_speed": fastest },
        },
    })
}

#[cfg(test)]
mod tests;
