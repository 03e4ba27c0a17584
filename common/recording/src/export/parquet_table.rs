//! A table as Parquet.

use std::io::Write;
use std::sync::Arc;

use coaxle_node::signal::Kind;
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result as Written};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};

use super::{ExportError, TableWriter, columns};
use crate::read_table::{ReadTable, Row};
use crate::value::Value;
use crate::writer::Facts;

/// Values that wait in memory for their piece of the file to be whole: some tens of megabytes.
const MOST_VALUES: usize = 2 << 20;

pub(super) struct ParquetTable<W: Write + Send> {
    file: SerializedFileWriter<W>,
    /// `at_ns`, `woke_ns`.
    when: [Vec<i64>; 2],
    columns: Vec<Cells>,
    most_rows: usize,
}

/// The cells of a column in this piece: 1 where there is a value, and the values.
struct Cells {
    known: Vec<i16>,
    values: Values,
}

enum Values {
    Numbers(Vec<f64>),
    Integers(Vec<i64>),
    Flags(Vec<bool>),
    Texts(Vec<ByteArray>),
}

impl<W: Write + Send> ParquetTable<W> {
    pub(super) fn new(to: W, table: &ReadTable, facts: &Facts) -> Result<Self, ExportError> {
        let units = table
            .columns
            .iter()
            .filter(|column| !column.unit.is_empty());
        let units = units.map(|c| KeyValue::new(format!("unit.{}", c.name()), c.unit.clone()));
        let facts = facts
            .iter()
            .map(|(key, value)| KeyValue::new(key.clone(), value.clone()));
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_key_value_metadata(Some(facts.chain(units).collect()))
            .build();
        let file = SerializedFileWriter::new(to, schema(table)?, Arc::new(properties))?;
        Ok(Self {
            file,
            when: [Vec::new(), Vec::new()],
            columns: table
                .columns
                .iter()
                .map(|column| Cells::of(column.kind))
                .collect(),
            most_rows: (MOST_VALUES / (2 + table.columns.len())).max(1),
        })
    }

    /// Writes the piece of the file that is whole.
    fn write_out(&mut self) -> Written<()> {
        let mut piece = self.file.next_row_group()?;
        for when in &mut self.when {
            if let Some(mut writer) = piece.next_column()? {
                Values::Integers(std::mem::take(when)).write(&mut writer, None)?;
                writer.close()?;
            }
        }
        for cells in &mut self.columns {
            if let Some(mut writer) = piece.next_column()? {
                cells.values.write(&mut writer, Some(&cells.known))?;
                writer.close()?;
                cells.clear();
            }
        }
        piece.close().map(|_| ())
    }
}

impl<W: Write + Send> TableWriter for ParquetTable<W> {
    fn row(&mut self, row: &Row) -> Result<(), ExportError> {
        let [at, woke] = &mut self.when;
        at.push(row.at_ns);
        woke.push(row.woke_ns);
        for (cells, value) in self.columns.iter_mut().zip(&row.values) {
            cells.push(value.as_ref());
        }
        if self.when[0].len() >= self.most_rows {
            self.write_out()?;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), ExportError> {
        if !self.when[0].is_empty() {
            self.write_out()?;
        }
        self.file.close()?;
        Ok(())
    }
}

fn schema(table: &ReadTable) -> Written<TypePtr> {
    let when = [(Kind::Integer, Repetition::REQUIRED); 2];
    let kinds = table
        .columns
        .iter()
        .map(|column| (column.kind, Repetition::OPTIONAL));
    let fields = columns(table).zip(when.into_iter().chain(kinds));
    let fields = fields.map(|(name, (kind, repetition))| {
        let (physical, logical) = types_of(kind);
        let field = Type::primitive_type_builder(&name, physical)
            .with_repetition(repetition)
            .with_logical_type(logical);
        field.build().map(Arc::new)
    });
    let group = Type::group_type_builder("row").with_fields(fields.collect::<Written<_>>()?);
    group.build().map(Arc::new)
}

fn types_of(kind: Kind) -> (Physical, Option<LogicalType>) {
    match kind {
        Kind::Number => (Physical::DOUBLE, None),
        Kind::Count => (Physical::INT64, Some(LogicalType::integer(64, false))),
        Kind::Integer => (Physical::INT64, None),
        Kind::Flag => (Physical::BOOLEAN, None),
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    }
}

impl Cells {
    fn of(kind: Kind) -> Self {
        let values = match kind {
            Kind::Number => Values::Numbers(Vec::new()),
            Kind::Count | Kind::Integer => Values::Integers(Vec::new()),
            Kind::Flag => Values::Flags(Vec::new()),
            Kind::Text => Values::Texts(Vec::new()),
        };
        let known = Vec::new();
        Self { known, values }
    }

    fn push(&mut self, value: Option<&Value>) {
        let is_known = match (&mut self.values, value) {
            (Values::Numbers(numbers), Some(Value::Number(number))) => {
                numbers.push(*number);
                true
            }
            (Values::Integers(integers), Some(Value::Integer(integer))) => {
                integers.push(*integer);
                true
            }
            // The column says that it has no sign.
            (Values::Integers(integers), Some(Value::Count(count))) => {
                integers.push(count.cast_signed());
                true
            }
            (Values::Flags(flags), Some(Value::Flag(flag))) => {
                flags.push(*flag);
                true
            }
            (Values::Texts(texts), Some(Value::Text(text))) => {
                texts.push(ByteArray::from(text.as_str()));
                true
            }
            _ => false,
        };
        self.known.push(is_known.into());
    }

    fn clear(&mut self) {
        self.known.clear();
        match &mut self.values {
            Values::Numbers(numbers) => numbers.clear(),
            Values::Integers(integers) => integers.clear(),
            Values::Flags(flags) => flags.clear(),
            Values::Texts(texts) => texts.clear(),
        }
    }
}

impl Values {
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
