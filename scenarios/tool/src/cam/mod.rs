//! `coaxle cam`: examines, designs and converts cam files.

mod advise;
mod characteristics;
mod edit;
mod export;
mod format;
mod import;
mod inverse;
mod new_file;
mod plot;
mod text;
mod values;

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use coaxle_files::cam::{CamFile, CamFileError};
use coaxle_os::exit::{Mistake, lines_of};
use coaxle_plate::Plate;
use coaxle_report::inspect;

/// Commands on a cam file.
#[derive(Debug, Subcommand)]
pub enum CamSubcommand {
    /// Check cam files
    Check {
        /// Cam files, TOML
        #[arg(required = true)]
        files: Vec<PathBuf>,
    },
    /// Print position, velocity, acceleration and jerk of the slave over the master
    Values(values::ValuesArgs),
    /// Print the extremes, mean and effective values, and the values at the ends
    Characteristics(characteristics::CharacteristicsArgs),
    /// Find the master positions at which the slave is somewhere
    Inverse(inverse::InverseArgs),
    /// Draw position, velocity, acceleration and jerk over the master, as a page for a browser
    Plot(CamPlotArgs),
    /// Design a plate on a page in the browser, on this PC: docs/CAMS.md
    Edit(Box<edit::CamEditArgs>),
    /// Advise the law that meets the slave's limits with the least velocity, acceleration, jerk or torque
    Advise(advise::AdviseArgs),
    /// Make a cam file of a point table: CSV, or an array in the structured text of a PLC
    Import(import::ImportArgs),
    /// Write the points of a cam file as CSV or as an array in the structured text of a PLC
    Export(export::CamExportArgs),
}

/// Arguments of `coaxle cam plot`.
#[derive(Debug, Args)]
pub struct CamPlotArgs {
    /// Cam file, TOML
    file: PathBuf,
    /// The page to write
    #[arg(short, long, value_name = "HTML")]
    output: PathBuf,
}

/// Runs a command and prints its result; false if a checked file is not in order, or no law passes. A reader that
/// stops early, as `head` does, is no error.
///
/// # Errors
/// A cam file that makes no plate, naming file, point or row, and field; an inverse without a solution; an output
/// that cannot be written.
pub fn print(command: &CamSubcommand) -> anyhow::Result<bool> {
    match command {
        CamSubcommand::Edit(args) => edit::run(args).map(|_| true),
        command => inspect::print(|out| run(command, out)),
    }
}

/// Runs a command and writes its result.
///
/// # Errors
/// As [`print()`].
pub fn run(command: &CamSubcommand, out: &mut dyn Write) -> anyhow::Result<bool> {
    match command {
        CamSubcommand::Check { files } => return check(files, out),
        CamSubcommand::Values(args) => args.run(out)?,
        CamSubcommand::Characteristics(args) => args.run(out)?,
        CamSubcommand::Inverse(args) => args.run(out)?,
        CamSubcommand::Plot(args) => {
            let (cam, plate) = load(&args.file)?;
            inspect::write_plot(&args.output, &plot::page(&cam, &plate), out)?;
        }
        CamSubcommand::Advise(args) => return args.run(out),
        // A page is not written: `print` serves it.
        CamSubcommand::Edit(_) => {}
        CamSubcommand::Import(args) => args.run(out)?,
        CamSubcommand::Export(args) => args.run(out)?,
    }
    Ok(true)
}

fn check(files: &[PathBuf], out: &mut dyn Write) -> anyhow::Result<bool> {
    let mut good = true;
    for file in files {
        match load(file) {
            Ok((cam, plate)) => {
                let about = text::description(&cam, &plate);
                writeln!(out, "{}: ok, {about}", file.display())?;
                // A step of the velocity is allowed in a plate, but no drive follows it.
                if let Some(steps) = text::velocity_steps(&cam, &plate) {
                    writeln!(out, "{}: {steps}", file.display())?;
                }
            }
            Err(error) => {
                // The other files are checked nevertheless.
                good = false;
                for line in lines_of(&error) {
                    writeln!(out, "{line}")?;
                }
            }
        }
    }
    Ok(good)
}

fn load(file: &Path) -> anyhow::Result<(CamFile, Plate)> {
    let cam = load_unchecked(file)?;
    let plate = cam.plate().map_err(mistake)?;
    Ok((cam, plate))
}

/// A file whose points need not make a plate.
fn load_unchecked(file: &Path) -> anyhow::Result<CamFile> {
    CamFile::load(file).map_err(mistake)
}

/// The error with the exit code of a wrong file.
fn mistake(error: CamFileError) -> anyhow::Error {
    match error {
        CamFileError::Config(error) => error.into(),
        // The file is well-formed TOML, but its points are at fault: still the user's to correct.
        CamFileError::Plate { .. } => Mistake::in_file(error.to_string()).into(),
    }
}

#[cfg(test)]
mod tests;
