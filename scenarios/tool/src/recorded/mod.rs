//! `coaxle record`, `coaxle recover`, `coaxle export`, `coaxle info`, `coaxle replay`: recordings of running nodes and
//! their use.

mod info;
mod live;
mod replay;

use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use coaxle_host::files::create_new;
use coaxle_node::text_file;
use coaxle_os::exit::{wrong_argument, wrong_file};
use coaxle_recording::export::{Exported, Format};
use coaxle_recording::{DamageList, Item, Reader, Recovered};

pub(crate) use info::{InfoArgs, info};
pub(crate) use live::{RecordArgs, record};
pub(crate) use replay::{ReplayArgs, replay};

/// Arguments of `coaxle recover`.
#[derive(Debug, Args)]
pub(crate) struct RecoverArgs {
    /// The recording: of a node that was killed, or a file that is damaged
    file: PathBuf,
    /// The file to write the intact part to, which must not be there yet [default: beside it, FILE-recovered.mcap]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Arguments of `coaxle export`.
#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// Format: csv, as a trace has it, or parquet
    #[arg(value_enum)]
    format: TableFormat,
    /// The recording
    file: PathBuf,
    /// The file to write the table to, which must not be there yet [default: beside it]. Of several tables each gets its name behind that of the file
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum TableFormat {
    Csv,
    Parquet,
}

/// First bytes of every MCAP file.
const MAGIC: &[u8] = b"\x89MCAP";

/// Greatest number of damaged pieces listed.
// The first ones show the kind of damage; of the others the number is printed.
const MOST_LINES: usize = 10;

/// Writes the intact part of a recording, and describes it.
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
    // Into another file: the damaged one stays for another attempt.
    let recovered = coaxle_recording::recover(from, writing);
    let recovered = recovered.with_context(|| to.display().to_string())?;
    let mut lines = vec![kept(&recovered)];
    lines.extend(damage(&recovered.damage));
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

/// Writes the rows of a recording as tables, and lists them.
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
    let mut not_created = None;
    let exported = coaxle_recording::export::export(from, format, |tables, n| {
        let path = path_of(&one, tables.len(), &tables[n].name);
        let file = create(&args.file, &path).map_err(|error| {
            // The export takes only `io::Error`, so the error itself is kept beside.
            let text = io::Error::other(error.to_string());
            not_created = Some(error);
            text
        })?;
        written.push(path);
        Ok(file)
    });
    // This error says more than the export's, which wraps it.
    if let Some(error) = not_created {
        return Err(error);
    }
    let exported = exported.with_context(|| one.display().to_string())?;
    name_all(&one, &exported, &mut written)?;
    let mut text = export_text(&exported, &written);
    if exported.audit > 0 {
        let path = beside(&one, "-audit", "jsonl");
        export_audit(&args.file, &path)?;
        text += &format!("\naudit, {} records: {}", exported.audit, path.display());
    }
    Ok(text)
}

/// Writes the records of the audit, one JSON object on a line.
fn export_audit(from: &Path, to: &Path) -> anyhow::Result<()> {
    let mut out = BufWriter::new(create(from, to)?);
    // Read once more: a recording of a day does not fit into memory.
    for item in Reader::new(open(from)?) {
        // Damage was listed with the tables.
        if let Ok(Item::Audit { json, .. }) = item {
            writeln!(out, "{json}").with_context(|| cannot_write(to))?;
        }
    }
    out.flush().with_context(|| cannot_write(to))
}

/// In a recording of several nodes the second table may turn up when the first one has got its file already.
fn name_all(one: &Path, exported: &Exported, written: &mut [PathBuf]) -> anyhow::Result<()> {
    // Only now the number of tables is final, and with it the names.
    let count = written.len();
    for ((table, _), path) in exported.rows.iter().zip(written) {
        let named = path_of(one, count, table);
        if *path != named {
            // `rename` would replace it silently.
            if named.exists() {
                return Err(io::Error::from(io::ErrorKind::AlreadyExists))
                    .with_context(|| cannot_write(&named));
            }
            let renamed = std::fs::rename(&*path, &named);
            renamed.with_context(|| cannot_write(&named))?;
            *path = named;
        }
    }
    Ok(())
}

fn export_text(exported: &Exported, written: &[PathBuf]) -> String {
    let mut lines = Vec::new();
    if written.is_empty() {
        lines.push("no row is in it".to_owned());
    }
    for ((table, rows), path) in exported.rows.iter().zip(written) {
        lines.push(format!("{table}, {rows} rows: {}", path.display()));
    }
    lines.extend(damage(&exported.damage));
    if exported.incomplete > 0 {
        lines.push(format!(
            "{} rows are left out: not all of them is there",
            exported.incomplete
        ));
    }
    lines.join("\n")
}

/// Path of a table: the only one is at the path given.
fn path_of(one: &Path, tables: usize, name: &str) -> PathBuf {
    if tables == 1 {
        return one.to_owned();
    }
    // Names of tables come from the file and may hold a slash.
    let is_plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    let name: String = name
        .chars()
        .map(|c| if is_plain(c) { c } else { '_' })
        .collect();
    let ending = one.extension().unwrap_or_default().to_string_lossy();
    beside(one, &format!("-{name}"), &ending)
}

/// The path with a suffix behind its stem.
fn beside(path: &Path, behind: &str, ending: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}{behind}.{ending}"))
}

/// A line for each damaged piece.
pub(crate) fn damage(damage: &DamageList) -> impl Iterator<Item = String> {
    let listed = damage.listed();
    let hidden = listed.len().saturating_sub(MOST_LINES) as u64 + damage.more();
    let more = (hidden > 0).then(|| format!("and {hidden} more"));
    let shown = listed.iter().take(MOST_LINES);
    shown.map(ToString::to_string).chain(more)
}

pub(crate) fn open(path: &Path) -> anyhow::Result<BufReader<File>> {
    // The file is read piece by piece: it may be of any length.
    let mut file = BufReader::new(text_file::open(path, u64::MAX)?);
    let begins = file
        .fill_buf()
        .with_context(|| path.display().to_string())?;
    if !begins.starts_with(MAGIC) {
        return wrong_file(format!(
            "{}: received another file, expected a recording in MCAP",
            path.display()
        ));
    }
    Ok(file)
}

/// Creates a new file, never over the one being read or any other.
fn create(from: &Path, to: &Path) -> anyhow::Result<File> {
    let is_same = match (from.canonicalize(), to.canonicalize()) {
        (Ok(from), Ok(to)) => from == to,
        // A file that does not exist yet is none of the others.
        _ => false,
    };
    if is_same {
        return wrong_argument(format!(
            "--out: received {}, the recording itself, expected another file",
            to.display()
        ));
    }
    create_new(to).with_context(|| cannot_write(to))
}

fn cannot_write(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::signal::Instance;
    use coaxle_os::exit::lines_of;
    use coaxle_receiver::signals::NodeSignals;
    use coaxle_recording::{Facts, RowEncoder, Table, Writer};

    /// A recording of this many cycles of a millisecond, of two receivers.
    fn recording(folder: &Path, rows: i64) -> PathBuf {
        let table = |name: &str| Table {
            name: name.to_owned(),
            role: "receiver".to_owned(),
            instances: vec![Instance::of::<NodeSignals>("")],
        };
        let tables = ["saw", "press/ram"].map(table);
        let path = folder.join("line.mcap");
        let file = File::create(&path).unwrap();
        let mut writer = Writer::create(file, &tables, &Facts::new(), 0).unwrap();
        let mut encoder = RowEncoder::of(&tables[0]);
        for k in 0..rows {
            let at = k * 1_000_000;
            let row = encoder.encode(at, at, &NodeSignals::default()).unwrap();
            writer.row(0, &row).unwrap();
            writer.row(1, &row).unwrap();
        }
        writer.finish().unwrap();
        path
    }

    fn exporting(file: &Path) -> ExportArgs {
        ExportArgs {
            format: TableFormat::Csv,
            file: file.to_owned(),
            out: None,
        }
    }

    #[test]
    fn each_table_gets_a_file_with_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let text = export(&exporting(&recording(folder.path(), 3))).unwrap();
        for name in ["line-saw.csv", "line-press_ram.csv"] {
            assert!(text.contains(name), "{text}");
            let text = std::fs::read_to_string(folder.path().join(name)).unwrap();
            assert_eq!(text.lines().count(), 1 + 3);
            assert!(text.starts_with("at_ns,woke_ns,cycle,"), "{text}");
        }
    }

    #[test]
    fn the_audit_is_counted_and_exported_line_by_line() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("saw.mcap");
        let table = Table {
            name: "saw".to_owned(),
            role: "receiver".to_owned(),
            instances: vec![Instance::of::<NodeSignals>("")],
        };
        let out = File::create(&file).unwrap();
        let mut writer = Writer::create(out, &[table], &Facts::new(), 0).unwrap();
        for n in 1..=3 {
            writer.audit(0, n, &format!("{{\"number\":{n}}}")).unwrap();
        }
        writer.finish().unwrap();
        let content = info(&InfoArgs { file: file.clone() }).unwrap();
        assert!(content.contains("3 records of the audit"), "{content}");
        let text = export(&exporting(&file)).unwrap();
        assert!(text.contains("audit, 3 records: "), "{text}");
        let lines = std::fs::read_to_string(folder.path().join("saw-audit.jsonl")).unwrap();
        let expected = "{\"number\":1}\n{\"number\":2}\n{\"number\":3}\n";
        assert_eq!(lines, expected);
    }

    #[test]
    fn what_is_kept_of_a_broken_file_is_said_and_can_be_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = recording(folder.path(), 1_000);
        let whole = std::fs::read(&file).unwrap();
        std::fs::write(&file, &whole[..whole.len() / 2]).unwrap();
        let out = None;
        let text = recover(&RecoverArgs {
            file: file.clone(),
            out,
        });
        let text = text.unwrap();
        assert!(text.starts_with("kept "), "{text}");
        assert!(text.contains("the file ends"), "{text}");
        let recovered = folder.path().join("line-recovered.mcap");
        let content = info(&InfoArgs { file: recovered }).unwrap();
        assert!(content.contains("receiver saw: "), "{content}");
        assert!(!content.contains("the file ends"), "{content}");
    }

    #[test]
    fn what_is_no_recording_or_would_be_overwritten_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let text = folder.path().join("trace.csv");
        std::fs::write(&text, "at_ns,woke_ns\n").unwrap();
        let error = export(&exporting(&text)).unwrap_err().to_string();
        assert!(error.ends_with("expected a recording in MCAP"), "{error}");
        let file = recording(folder.path(), 3);
        let out = Some(file.clone());
        let recovering = RecoverArgs {
            file: file.clone(),
            out,
        };
        let error = recover(&recovering).unwrap_err().to_string();
        assert!(error.contains("the recording itself"), "{error}");
        for name in ["line-recovered.mcap", "line-press_ram.csv"] {
            std::fs::write(folder.path().join(name), "somebody's").unwrap();
        }
        let recovering = RecoverArgs {
            file: file.clone(),
            out: None,
        };
        let recovered = recover(&recovering).unwrap_err();
        let exported = export(&exporting(&file)).unwrap_err();
        for error in [recovered, exported] {
            let text = lines_of(&error);
            assert!(
                text[0].contains("expected a name that is not taken"),
                "{text:?}"
            );
        }
        for name in ["line-recovered.mcap", "line-press_ram.csv"] {
            let text = std::fs::read_to_string(folder.path().join(name)).unwrap();
            assert_eq!(text, "somebody's");
        }
    }
}
