//! Tables of a recording, for other programs.
//!
//! Each table of a recording becomes one wide table, `at_ns`, `woke_ns` and a column for each signal; Parquet has the time of day
//! (`time`) before them. A
//! row is a cycle, so that values of one instant are beside each other, and no program has to join them
//! by their time.

mod csv_table;
mod parquet_table;

use std::io::{self, Read, Write};

use coaxle_node::signal::Kind;

pub use self::parquet_table::{ParquetTable, TypedColumn};
use crate::damage_list::DamageList;
use crate::format::CLOCK_OFFSET;
use crate::read_table::{ReadTable, Row};
use crate::reader::{Item, Reader};
use crate::value::Value;
use crate::writer::Facts;

/// Format of an exported table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// CSV, identical to a trace.
    Csv,
    /// Typed columns, compressed.
    Parquet,
}

/// Result of an export.
#[derive(Debug, Default)]
pub struct Exported {
    /// The tables, with their numbers of rows.
    pub rows: Vec<(String, u64)>,
    /// Damage of the recording, with its places.
    pub damage: DamageList,
    /// Incomplete rows, which were left out.
    pub incomplete: u64,
    /// Records of the audit, which are not rows of a table.
    pub audit: u64,
}

/// Reason why a table could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// An error of the system.
    #[error("cannot be written: {0}")]
    System(#[from] io::Error),
    /// An error of the CSV writer.
    #[error("cannot be written: {0}")]
    Csv(#[from] csv::Error),
    /// An error of the Parquet writer.
    #[error("cannot be written: {0}")]
    Parquet(#[from] parquet::errors::ParquetError),
}

/// Destination of a table.
trait TableWriter {
    fn row(&mut self, row: &Row) -> Result<(), ExportError>;
    fn finish(self: Box<Self>) -> Result<(), ExportError>;
}

/// Writes the tables of a recording, each to the result of `create` for the n-th of all tables. Damaged
/// parts of the recording are left out and reported; of an unfinished recording, all complete rows are
/// written.
///
/// # Errors
/// [`ExportError`]: a table cannot be written.
pub fn export<R: Read, W: Write + Send + 'static>(
    recording: R,
    format: Format,
    mut create: impl FnMut(&[ReadTable], usize) -> io::Result<W>,
) -> Result<Exported, ExportError> {
    let mut reader = Reader::new(recording);
    let mut exported = Exported::default();
    let mut facts = Facts::new();
    let mut writers: Vec<Option<Box<dyn TableWriter>>> = Vec::new();
    while let Some(item) = reader.next() {
        match item {
            Ok(Item::Row(row)) => {
                let tables = reader.tables();
                let table = &tables[row.table];
                // Tables appear while the file is read, with their first channels.
                writers.resize_with(tables.len(), || None);
                let writer = &mut writers[row.table];
                let writer = match writer {
                    Some(writer) => writer,
                    // Opened with the first row: only then are all columns of the table known.
                    None => writer.insert(open(format, create(tables, row.table)?, table, &facts)?),
                };
                writer.row(&row)?;
                count(&mut exported.rows, &table.name);
            }
            Ok(Item::Facts(more)) => facts.extend(more),
            Ok(Item::Audit { .. }) => exported.audit += 1,
            Ok(_) => {}
            Err(damage) => exported.damage.note(damage),
        }
    }
    exported.incomplete = reader.incomplete_rows();
    for writer in writers.into_iter().flatten() {
        writer.finish()?;
    }
    Ok(exported)
}

fn open<W: Write + Send + 'static>(
    format: Format,
    to: W,
    table: &ReadTable,
    facts: &Facts,
) -> Result<Box<dyn TableWriter>, ExportError> {
    Ok(match format {
        Format::Csv => Box::new(csv_table::CsvTable::new(to, table)?),
        Format::Parquet => Box::new(DatedTable {
            table: ParquetTable::new(to, &typed_columns(table), facts)?,
            clock_offset_ns: clock_offset_ns(facts),
        }),
    })
}

/// A table as Parquet, with the time of day of each row.
struct DatedTable<W: Write + Send> {
    table: ParquetTable<W>,
    clock_offset_ns: i64,
}

impl<W: Write + Send> TableWriter for DatedTable<W> {
    fn row(&mut self, row: &Row) -> Result<(), ExportError> {
        let time = row.at_ns.saturating_add(self.clock_offset_ns);
        let when = [time, row.at_ns, row.woke_ns].map(Value::Integer);
        let values = row.values.iter().map(Option::as_ref);
        self.table.row(when.iter().map(Some).chain(values))
    }

    fn finish(self: Box<Self>) -> Result<(), ExportError> {
        self.table.finish()
    }
}

/// Returns the time of day at time 0 of the clock of the rows, ns; 0 as in virtual time without it.
fn clock_offset_ns(facts: &Facts) -> i64 {
    let offset = facts.get(CLOCK_OFFSET);
    offset.and_then(|offset| offset.parse().ok()).unwrap_or(0)
}

fn typed_columns(table: &ReadTable) -> Vec<TypedColumn> {
    // All three times are in every row, so that readers need no null for them.
    let time = (None, "", false);
    let when = [(Some(Kind::Integer), "", false); 2];
    let kinds =
        (table.columns.iter()).map(|column| (Some(column.kind), column.unit.as_str(), true));
    let typed = std::iter::once(time).chain(when).chain(kinds);
    // Data tools look for a column of this name.
    let names = std::iter::once("time".to_owned()).chain(columns(table));
    let typed = names.zip(typed);
    let typed = typed.map(|(name, (kind, unit, is_optional))| TypedColumn {
        name,
        unit: unit.to_owned(),
        kind,
        is_optional,
    });
    typed.collect()
}

fn count(rows: &mut Vec<(String, u64)>, table: &str) {
    match rows.iter_mut().find(|(name, _)| name == table) {
        Some((_, rows)) => *rows += 1,
        None => rows.push((table.to_owned(), 1)),
    }
}

/// Returns the columns of a table, in the format of a trace.
fn columns(table: &ReadTable) -> impl Iterator<Item = String> {
    let when = ["at_ns", "woke_ns"].map(str::to_owned);
    when.into_iter()
        .chain(table.columns.iter().map(|c| c.name()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::{boiler, row};
    use crate::{RowEncoder, Writer};
    use parquet::basic::{LogicalType, TimeUnit};
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;
    use std::sync::{Arc, Mutex};

    /// Bytes that can be read while they are written.
    #[derive(Clone, Default)]
    struct Shared(Arc<Mutex<Vec<u8>>>);

    impl Write for Shared {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// An hour after the beginning of 1970.
    const CLOCK_OFFSET_NS: i64 = 3_600_000_000_000;

    fn exported(format: Format, rows: u64) -> Vec<u8> {
        let mut encoder = RowEncoder::of(&boiler());
        let mut writer =
            Writer::create(Vec::new(), &[boiler()], &Facts::new(), CLOCK_OFFSET_NS).unwrap();
        for k in 0..rows {
            let encoded = encoder.encode(k as i64, k as i64 + 1, &row(k)).unwrap();
            writer.row(0, &encoded).unwrap();
        }
        let file = writer.finish().unwrap();
        let shared = Shared::default();
        let exported = export(file.as_slice(), format, |_, _| Ok(shared.clone())).unwrap();
        assert_eq!(exported.rows, [("boiler".to_owned(), rows)]);
        assert!(exported.damage.listed().is_empty());
        let bytes = shared.0.lock().unwrap();
        bytes.clone()
    }

    #[test]
    fn a_table_in_csv_is_to_the_letter_what_rows_are() {
        let mut expected = csv::WriterBuilder::new()
            .has_headers(false)
            .from_writer(Vec::new());
        let columns = coaxle_node::signal::trace_columns(&boiler().instances);
        expected.write_record(columns).unwrap();
        for k in 0..50 {
            expected
                .serialize((k as i64, k as i64 + 1, &row(k)))
                .unwrap();
        }
        let expected = String::from_utf8(expected.into_inner().unwrap()).unwrap();
        assert_eq!(
            String::from_utf8(exported(Format::Csv, 50)).unwrap(),
            expected
        );
    }

    #[test]
    fn a_table_in_parquet_has_typed_columns() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&exported(Format::Parquet, 50)).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let metadata = reader.metadata().file_metadata();
        let units = metadata.key_value_metadata().unwrap();
        let unit = units.iter().find(|pair| pair.key == "unit.temperature");
        assert_eq!(unit.unwrap().value.as_deref(), Some("°C"));
        let rows: Vec<_> = reader
            .get_row_iter(None)
            .unwrap()
            .map(Result::unwrap)
            .collect();
        assert_eq!(rows.len(), 50);
        let (read, expected) = (&rows[49], row(49));
        let schema = reader.metadata().file_metadata().schema_descr();
        let time = schema.column(0);
        assert_eq!(time.name(), "time");
        let utc = LogicalType::timestamp(true, TimeUnit::NANOS);
        assert_eq!(time.logical_type_ref(), Some(&utc));
        assert_eq!(read.get_long(0).unwrap(), CLOCK_OFFSET_NS + 49);
        assert_eq!(read.get_long(1).unwrap(), 49);
        assert_eq!(
            read.get_double(3).unwrap(),
            expected.node.temperature.unwrap()
        );
        assert_eq!(read.get_ulong(4).unwrap(), 49);
        assert_eq!(read.get_string(5).unwrap(), "off");
        assert_eq!(read.get_long(11).unwrap(), -49);
        assert!(rows[0].get_double(3).is_err(), "not known");
        assert!(rows[0].get_bool(8).unwrap());
    }
}
