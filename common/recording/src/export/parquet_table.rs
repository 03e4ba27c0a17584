//! A table as Parquet.

use std::io::Write;
use std::sync::Arc;

use coaxle_node::signal::Kind;
use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result as Written};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};

use super::ExportError;
use crate::value::Value;
use crate::writer::Facts;

/// Greatest number of values in memory before a row group is written: some tens of megabytes.
const MOST_VALUES: usize = 2 << 20;

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TypedColumn {
    /// Name of the column.
    pub name: String,
    /// Unit, stored in the file under `unit.NAME`; empty if it has none.
    pub unit: String,
    /// Kind of its values; none for integers that are times, ns since 1970 (UTC).
    pub kind: Option<Kind>,
    /// True if values may be missing.
    pub is_optional: bool,
}

/// Writes a table as Parquet, row by row, with bounded memory.
pub struct ParquetTable<W: Write + Send> {
    file: SerializedFileWriter<W>,
    columns: Vec<Cells>,
    rows: usize,
    most_rows: usize,
}

/// The cells of a column in this row group: 1 for a value that is present, and the values.
struct Cells {
    known: Vec<i16>,
    values: CellValues,
    is_optional: bool,
}

enum CellValues {
    Numbers(Vec<f64>),
    Integers(Vec<i64>),
    Flags(Vec<bool>),
    Texts(Vec<ByteArray>),
}

impl<W: Write + Send> ParquetTable<W> {
    /// Makes a table of these columns, with further metadata of the file.
    ///
    /// # Errors
    /// [`ExportError`]: it cannot be written.
    pub fn new(to: W, columns: &[TypedColumn], facts: &Facts) -> Result<Self, ExportError> {
        let units = columns.iter().filter(|column| !column.unit.is_empty());
        let units = units.map(|c| KeyValue::new(format!("unit.{}", c.name), c.unit.clone()));
        let facts = facts
            .iter()
            .map(|(key, value)| KeyValue::new(key.clone(), value.clone()));
        let properties = WriterProperties::builder()
            // The method that readers of Parquet support most widely.
            .set_compression(Compression::SNAPPY)
            .set_key_value_metadata(Some(facts.chain(units).collect()))
            .build();
        let file = SerializedFileWriter::new(to, schema(columns)?, Arc::new(properties))?;
        Ok(Self {
            file,
            columns: columns.iter().map(Cells::of).collect(),
            rows: 0,
            // A row group holds all columns at once, so that wide tables get fewer rows. At least one, however wide.
            most_rows: (MOST_VALUES / columns.len().max(1)).max(1),
        })
    }

    /// Appends a row: a value for each column, in their order; none where it is missing.
    ///
    /// # Errors
    /// [`ExportError`]: it cannot be written, or a value that has to be there is not.
    pub fn row<'a>(
        &mut self,
        values: impl IntoIterator<Item = Option<&'a Value>>,
    ) -> Result<(), ExportError> {
        for (cells, value) in self.columns.iter_mut().zip(values) {
            cells.push(value);
        }
        self.rows += 1;
        if self.rows >= self.most_rows {
            self.write_out()?;
        }
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// [`ExportError`]: it cannot be written.
    pub fn finish(mut self) -> Result<(), ExportError> {
        if self.rows > 0 {
            self.write_out()?;
        }
        self.file.close()?;
        Ok(())
    }

    /// Writes the complete row group.
    fn write_out(&mut self) -> Written<()> {
        let mut piece = self.file.next_row_group()?;
        for cells in &mut self.columns {
            if let Some(mut writer) = piece.next_column()? {
                // Definition levels exist for optional columns only.
                let known = cells.is_optional.then_some(cells.known.as_slice());
                cells.values.write(&mut writer, known)?;
                writer.close()?;
                cells.clear();
            }
        }
        self.rows = 0;
        piece.close().map(|_| ())
    }
}

fn schema(columns: &[TypedColumn]) -> Written<TypePtr> {
    let fields = columns.iter().map(|column| {
        let (physical, logical) = types_of(column.kind);
        let repetition = match column.is_optional {
            true => Repetition::OPTIONAL,
            false => Repetition::REQUIRED,
        };
        let field = Type::primitive_type_builder(&column.name, physical)
            .with_repetition(repetition)
            .with_logical_type(logical);
        field.build().map(Arc::new)
    });
    let group = Type::group_type_builder("row").with_fields(fields.collect::<Written<_>>()?);
    group.build().map(Arc::new)
}

fn types_of(kind: Option<Kind>) -> (Physical, Option<LogicalType>) {
    let Some(kind) = kind else {
        let time = LogicalType::timestamp(true, TimeUnit::NANOS);
        return (Physical::INT64, Some(time));
    };
    match kind {
        Kind::Number => (Physical::DOUBLE, None),
        // Parquet has no unsigned integers on disk; the logical type makes readers interpret the same bits so.
        Kind::Count => (Physical::INT64, Some(LogicalType::integer(64, false))),
        Kind::Integer => (Physical::INT64, None),
        Kind::Flag => (Physical::BOOLEAN, None),
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    }
}

impl Cells {
    fn of(column: &TypedColumn) -> Self {
        let values = match column.kind {
            Some(Kind::Number) => CellValues::Numbers(Vec::new()),
            Some(Kind::Count | Kind::Integer) | None => CellValues::Integers(Vec::new()),
            Some(Kind::Flag) => CellValues::Flags(Vec::new()),
            Some(Kind::Text) => CellValues::Texts(Vec::new()),
        };
        Self {
            known: Vec::new(),
            values,
            is_optional: column.is_optional,
        }
    }

    fn push(&mut self, value: Option<&Value>) {
        let is_known = match (&mut self.values, value) {
            (CellValues::Numbers(numbers), Some(Value::Number(number))) => {
                numbers.push(*number);
                true
            }
            (CellValues::Integers(integers), Some(Value::Integer(integer))) => {
                integers.push(*integer);
                true
            }
            // The column is declared as unsigned.
            (CellValues::Integers(integers), Some(Value::Count(count))) => {
                integers.push(count.cast_signed());
                true
            }
            (CellValues::Flags(flags), Some(Value::Flag(flag))) => {
                flags.push(*flag);
                true
            }
            (CellValues::Texts(texts), Some(Value::Text(text))) => {
                texts.push(ByteArray::from(text.as_str()));
                true
            }
            // A value of another kind counts as missing, so that all columns keep the same length.
            _ => false,
        };
        self.known.push(is_known.into());
    }

    fn clear(&mut self) {
        self.known.clear();
        match &mut self.values {
            CellValues::Numbers(numbers) => numbers.clear(),
            CellValues::Integers(integers) => integers.clear(),
            CellValues::Flags(flags) => flags.clear(),
            CellValues::Texts(texts) => texts.clear(),
        }
    }
}

impl CellValues {
    fn write(&self, to: &mut SerializedColumnWriter<'_>, known: Option<&[i16]>) -> Written<()> {
        let written = match (to.untyped(), self) {
            (ColumnWriter::DoubleColumnWriter(to), Self::Numbers(numbers)) => {
                to.write_batch(numbers, known, None)
            }
            (ColumnWriter::Int64ColumnWriter(to), Self::Integers(integers)) => {
                to.write_batch(integers, known, None)
            }
            (ColumnWriter::BoolColumnWriter(to), Self::Flags(flags)) => {
                to.write_batch(flags, known, None)
            }
            (ColumnWriter::ByteArrayColumnWriter(to), Self::Texts(texts)) => {
                to.write_batch(texts, known, None)
            }
            _ => Err(ParquetError::General("a column of another kind".to_owned())),
        };
        written.map(|_| ())
    }
}
