//! `coaxle recover`, `coaxle export`, `coaxle info`: what becomes of recordings.

mod info;

use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use coaxle_node::text_file;
use coaxle_recording::export::{Exported, Format};
use coaxle_recording::{Damage, ReadTable, Recovered};

pub(crate) use info::{InfoArgs, info};

/// What to recover.
#[derive(Debug, Args)]
pub(crate) struct RecoverArgs {
    /// The recording: of a node that was killed, or a file that is damaged
    file: PathBuf,
    /// Where to write what is whole of it [default: beside it, FILE-recovered.mcap]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// What to export.
#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// As what: csv, as a trace has it, or parquet
    #[arg(value_enum)]
    format: TableFormat,
    /// The recording
    file: PathBuf,
    /// Where to write the table [default: beside it]. Of several tables each gets its name behind that of the file
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum TableFormat {
    Csv,
    Parquet,
}

/// As much damage is told line by line.
const MOST_LINES: usize = 10;

/// Writes what is whole of a recording, and says what that is.
///
/// # Errors
/// Names the file that cannot be read or written.
pub(crate) fn recover(args: &RecoverArgs) -> anyhow::Result<String> {
    let to = match &args.out {
        Some(out) => out.clone(),
        None => beside(&args.file, "-recovered", "mcap"),
    };
    let from = open(&args.file)?;
    let writing = create(&args.file, &to)?;
    let recovered = coaxle_recording::recover(from, writing);
    let recovered = recovered.with_context(|| to.display().to_string())?;
    let mut lines = vec![kept(&recovered)];
    lines.extend(damage(&recovered.damage, recovered.more_damage));
    if recovered.lost > 0 {
        let lost = recovered.lost;
        lines.push(format!(
            "{lost} messages are lost with the description of what they are"
        ));
    }
    if recovered.was_whole() {
        lines.push("nothing was wrong with it".to_owned());
    }
    lines.push(format!("recording: {}", to.display()));
    Ok(lines.join("\n"))
}

fn kept(recovered: &Recovered) -> String {
    let messages = recovered.messages;
    let seconds = |(start, end): (u64, u64)| end.saturating_sub(start) as f64 * 1e-9;
    match recovered.span_ns.map(seconds) {
        Some(seconds) => format!("kept {messages} messages, {seconds:.3} s"),
        None => "kept no message".to_owned(),
    }
}

/// Writes the rows of a recording as tables, and says which.
///
/// # Errors
/// Names the file that cannot be read or written.
pub(crate) fn export(args: &ExportArgs) -> anyhow::Result<String> {
    let (format, ending) = match args.format {
        TableFormat::Csv => (Format::Csv, "csv"),
        TableFormat::Parquet => (Format::Parquet, "parquet"),
    };
    let one = match &args.out {
        Some(out) => out.clone(),
        None => args.file.with_extension(ending),
    };
    let from = open(&args.file)?;
    let mut written = Vec::new();
    let exported = coaxle_recording::export::export(from, format, |tables, n| {
        let path = path_of(&one, tables, n);
        let file = create(&args.file, &path).map_err(io::Error::other)?;
        written.push(path);
        Ok(file)
    });
    let exported = exported.with_context(|| one.display().to_string())?;
    Ok(told(&exported, &written))
}

fn told(exported: &Exported, written: &[PathBuf]) -> String {
    let mut lines = Vec::new();
    if written.is_empty() {
        lines.push("no row is in it".to_owned());
    }
    for ((table, rows), path) in exported.rows.iter().zip(written) {
        lines.push(format!("{table}, {rows} rows: {}", path.display()));
    }
    lines.extend(damage(&exported.damage, 0));
    if exported.incomplete > 0 {
        lines.push(format!(
            "{} rows are left out: not all of them is there",
            exported.incomplete
        ));
    }
    lines.join("\n")
}

/// Where a table goes: if it is the only one, where it is said.
fn path_of(one: &Path, tables: &[ReadTable], n: usize) -> PathBuf {
    if tables.len() == 1 {
        return one.to_owned();
    }
    let is_plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    let name = &tables[n].name;
    let name: String = name
        .chars()
        .map(|c| if is_plain(c) { c } else { '_' })
        .collect();
    let ending = one.extension().unwrap_or_default().to_string_lossy();
    beside(one, &format!("-{name}"), &ending)
}

/// The same path with something behind its stem.
fn beside(path: &Path, behind: &str, ending: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}{behind}.{ending}"))
}

/// One line for each piece that is damaged.
fn damage(damage: &[Damage], more: u64) -> impl Iterator<Item = String> {
    let hidden = damage.len().saturating_sub(MOST_LINES) as u64 + more;
    let more = (hidden > 0).then(|| format!("and {hidden} more"));
    let shown = damage.iter().take(MOST_LINES);
    shown.map(ToString::to_string).chain(more)
}

fn open(path: &Path) -> anyhow::Result<BufReader<File>> {
    // It is read bit by bit: it may be of any length.
    Ok(BufReader::new(text_file::open(path, u64::MAX)?))
}

/// Never what is being read.
fn create(from: &Path, to: &Path) -> anyhow::Result<File> {
    let is_same = match (from.canonicalize(), to.canonicalize()) {
        (Ok(from), Ok(to)) => from == to,
        _ => false,
    };
    if is_same {
        bail!(
            "--out: received {}, the recording itself, expected another file",
            to.display()
        );
    }
    File::create(to).with_context(|| format!("cannot write {}", to.display()))
}
