//! `coaxle info`: content of a recording.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use coaxle_node::one_line;
use coaxle_recording::{Damage, DamageList, Facts, Item, ReadTable, Reader, Row};

use super::{damage, open};

/// Arguments of `coaxle info`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// The recording
    pub(super) file: PathBuf,
}

/// Content read so far.
#[derive(Default)]
struct RecordingContent {
    facts: Facts,
    files: Vec<String>,
    rows: BTreeMap<usize, TableRows>,
    lines: u64,
    statuses: u64,
    audit: u64,
    inputs: u64,
    damage: DamageList,
}

/// The rows of a table.
struct TableRows {
    count: u64,
    start_ns: i64,
    end_ns: i64,
}

/// Describes the content of a recording: its facts, files, tables and log.
///
/// # Errors
/// Names the file that cannot be read.
pub(crate) fn info(args: &InfoArgs) -> anyhow::Result<String> {
    let mut reader = Reader::new(open(&args.file)?);
    let mut content = RecordingContent::default();
    // Item by item: a recording of a day does not fit into memory.
    for item in reader.by_ref() {
        content.take(item);
    }
    Ok(content.lines(reader.tables()).join("\n"))
}

impl RecordingContent {
    fn take(&mut self, item: Result<Item, Damage>) {
        match item {
            // Facts at the end replace those at the start, as the number of dropped rows is final only there.
            Ok(Item::Facts(facts)) => self.facts.extend(facts),
            Ok(Item::Attachment { name, data, .. }) => {
                self.files
                    // Names come from a file and may hold control characters for the terminal.
                    .push(format!("{}, {} bytes", one_line(&name), data.len()));
            }
            Ok(Item::Row(row)) => self.row(&row),
            Ok(Item::Log(_)) => self.lines += 1,
            Ok(Item::Status { .. }) => self.statuses += 1,
            Ok(Item::Audit { .. }) => self.audit += 1,
            Ok(Item::Inputs { .. }) => self.inputs += 1,
            Err(damage) => self.damage.note(damage),
        }
    }

    fn row(&mut self, row: &Row) {
        let rows = self.rows.entry(row.table).or_insert(TableRows {
            count: 0,
            start_ns: row.at_ns,
            end_ns: row.at_ns,
        });
        rows.count += 1;
        // MCAP does not require rows to be in the order of time.
        rows.start_ns = rows.start_ns.min(row.at_ns);
        rows.end_ns = rows.end_ns.max(row.at_ns);
    }

    fn lines(&self, tables: &[ReadTable]) -> Vec<String> {
        let facts = self.facts.iter();
        let mut lines: Vec<String> = facts
            .map(|(name, fact)| format!("{}: {}", one_line(name), one_line(fact)))
            .collect();
        lines.extend(self.files.iter().map(|file| format!("file {file}")));
        for (n, table) in tables.iter().enumerate() {
            let (name, role) = (one_line(&table.name), one_line(&table.role));
            let columns = table.columns.len();
            let rows = self.rows.get(&n).map_or_else(
                || "no row".to_owned(),
                |rows| {
                    // Saturating, because times of a damaged file may be anything.
                    let seconds = rows.end_ns.saturating_sub(rows.start_ns) as f64 * 1e-9;
                    format!("{} rows, {seconds:.3} s", rows.count)
                },
            );
            lines.push(format!("{role} {name}: {rows}, {columns} signals"));
        }
        lines.push(format!(
            "{} lines of log, {} times its status",
            self.lines, self.statuses
        ));
        if self.audit > 0 {
            lines.push(format!(
                "{} records of the audit, for `coaxle audit`",
                self.audit
            ));
        }
        if self.inputs > 0 {
            lines.push(format!(
                "inputs of {} cycles, for `coaxle replay`",
                self.inputs
            ));
        }
        lines.extend(damage(&self.damage));
        lines
    }
}
