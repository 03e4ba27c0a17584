//! `coaxle fmu`: writes units for co-simulation by FMI 3.0.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Subcommand};
use coaxle_fmi::{LIBRARY, MOST_FILE_BYTES, Resources, UnitPackage};
use coaxle_lab::catalog;
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};
use coaxle_os::exit::wrong_argument;

/// Folders of the library, if it is not beside the tool.
const LIBRARY_FOLDERS: [&str; 2] = ["/usr/lib/coaxle", "/usr/local/lib/coaxle"];

/// Units to write.
#[derive(Debug, Subcommand)]
pub(crate) enum FmuSubcommand {
    /// Write a link as a unit: a sender moved by inputs, a network with its faults, and a receiver; of a scenario with one of each
    Link(FmuLinkArgs),
    /// Write a slave axis as a unit, with a saw, a gear or a cam plate
    Slave(FmuSlaveArgs),
}

/// Arguments of `coaxle fmu link`.
#[derive(Debug, Args)]
pub(crate) struct FmuLinkArgs {
    /// Name of a built-in scenario, or path
    scenario: String,
    #[command(flatten)]
    written: WrittenUnit,
}

/// Arguments of `coaxle fmu slave`.
#[derive(Debug, Args)]
pub(crate) struct FmuSlaveArgs {
    /// Saw, gear or cam file, TOML
    file: PathBuf,
    /// Cycle time of the slave, µs: the step of the unit
    #[arg(long, default_value_t = 1000, value_name = "MICROSECONDS")]
    cycle_time_us: u32,
    #[command(flatten)]
    written: WrittenUnit,
}

/// Options of all units.
#[derive(Debug, Args)]
struct WrittenUnit {
    /// The unit to write
    #[arg(long, value_name = "FMU")]
    out: PathBuf,
    /// A file that the scenario or the slave's file names, to be packed with it; from its folder, as it is named there
    #[arg(long = "with", value_name = "FILE")]
    with: Vec<String>,
    /// The library of the units, if it is neither beside this program nor in /usr/lib/coaxle
    #[arg(long, value_name = "SO")]
    library: Option<PathBuf>,
}

/// Writes a unit.
///
/// # Errors
/// A scenario or file that is no unit, a library that is missing, an output that cannot be written.
pub(crate) fn write(command: &FmuSubcommand) -> anyhow::Result<()> {
    match command {
        FmuSubcommand::Link(args) => {
            let source = catalog::find(&args.scenario)?;
            let path = Path::new(&source.file);
            let resources = Resources::of_link(&file_name(path), &source.text);
            write_unit(resources, path, &args.written)
        }
        FmuSubcommand::Slave(args) => {
            let text = text_file::read(&args.file, MOST_CONFIG_BYTES)?;
            let name = file_name(&args.file);
            let resources = Resources::of_slave(&name, &text, args.cycle_time_us)?;
            write_unit(resources, &args.file, &args.written)
        }
    }
}

fn write_unit(mut resources: Resources, path: &Path, written: &WrittenUnit) -> anyhow::Result<()> {
    let folder = path.parent().unwrap_or(Path::new(""));
    for name in &written.with {
        let text = text_file::read(&folder.join(name), MOST_FILE_BYTES)?;
        resources.add(name, text)?;
    }
    let library = library(written.library.as_deref())?;
    let library = fs::read(&library).with_context(|| library.display().to_string())?;
    let unit = UnitPackage::new(&resources, &library)?.into_bytes();
    fs::write(&written.out, unit).with_context(|| format!("cannot write {}", written.out.display()))
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// The library of the units: the given one, the one beside this program, or the installed one.
fn library(given: Option<&Path>) -> anyhow::Result<PathBuf> {
    let candidates: Vec<PathBuf> = match given {
        Some(given) => vec![given.to_owned()],
        None => {
            let tool = std::env::current_exe().unwrap_or_default();
            let beside = tool.parent().map(Path::to_owned);
            let folders = beside.into_iter().chain(LIBRARY_FOLDERS.map(PathBuf::from));
            folders.map(|folder| folder.join(LIBRARY)).collect()
        }
    };
    if let Some(found) = candidates.iter().find(|path| path.is_file()) {
        return Ok(found.clone());
    }
    let looked: Vec<_> = candidates
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    wrong_argument(format!(
        "--library: received no library of the units ({}), expected one: build it with \
         `cargo build --release -p coaxle-fmu`",
        looked.join(", ")
    ))
}
