//! Recordings, column by column.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use anyhow::Context;
use coaxle_node::signal::Kind;
use coaxle_recording::{Item, Reader, Value};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};

use crate::columns::{bytes_of, f64s};
use crate::error::told;

/// The signals of a node, row by row.
#[derive(Default)]
struct Table {
    at_ns: Vec<i64>,
    woke_ns: Vec<i64>,
    columns: Vec<Column>,
}

/// The values of a signal. A row without one has an arbitrary value, and is not marked as known.
enum Values {
    Numbers(Vec<f64>),
    Integers(Vec<i64>),
    Flags(Vec<u8>),
    /// Indices of words.
    Words(Vec<i32>, BTreeMap<String, i32>),
}

struct Column {
    values: Values,
    known: Vec<u8>,
}

impl Column {
    const fn of(kind: Kind) -> Self {
        let values = match kind {
            Kind::Number => Values::Numbers(Vec::new()),
            Kind::Count | Kind::Integer => Values::Integers(Vec::new()),
            Kind::Flag => Values::Flags(Vec::new()),
            Kind::Text => Values::Words(Vec::new(), BTreeMap::new()),
        };
        Self {
            values,
            known: Vec::new(),
        }
    }

    fn push(&mut self, value: Option<Value>) {
        self.known.push(u8::from(value.is_some()));
        match (&mut self.values, value) {
            (Values::Numbers(all), value) => {
                all.push(
                    value
                        .and_then(|value| value.as_number())
                        // NumPy's own mark of a missing number; the other kinds have none, hence `known`.
                        .unwrap_or(f64::NAN),
                );
            }
            // NumPy has one type for the column: a count beyond i64 would take 292 years at 1 GHz.
            (Values::Integers(all), Some(Value::Count(count))) => all.push(count.cast_signed()),
            (Values::Integers(all), Some(Value::Integer(integer))) => all.push(integer),
            (Values::Integers(all), _) => all.push(0),
            (Values::Flags(all), value) => all.push(u8::from(value == Some(Value::Flag(true)))),
            (Values::Words(all, words), Some(Value::Text(word))) => {
                // Numbered by first occurrence, so that a new word changes no earlier row.
                let next = words.len() as i32;
                all.push(*words.entry(word).or_insert(next));
            }
            (Values::Words(all, _), _) => all.push(-1),
        }
    }

    fn into_python<'py>(self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let column = PyDict::new(py);
        let (kind, bytes) = match &self.values {
            Values::Numbers(all) => ("number", f64s(py, all)),
            Values::Integers(all) => ("integer", bytes_of(py, all, i64::to_ne_bytes)),
            Values::Flags(all) => ("flag", PyBytes::new(py, all)),
            Values::Words(all, _) => ("text", bytes_of(py, all, i32::to_ne_bytes)),
        };
        column.set_item("kind", kind)?;
        column.set_item("values", bytes)?;
        column.set_item("known", PyBytes::new(py, &self.known))?;
        if let Values::Words(_, words) = self.values {
            let mut in_order: Vec<_> = words.into_iter().collect();
            in_order.sort_unstable_by_key(|(_, place)| *place);
            let words = in_order.into_iter().map(|(word, _)| word);
            column.set_item("words", words.collect::<Vec<_>>())?;
        }
        Ok(column)
    }
}

/// Reads a recording: its tables with their columns, its facts, its damage, and the number of incomplete rows.
#[pyfunction]
pub(crate) fn read_recording<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyDict>> {
    // A large file takes long, and other threads of Python run on meanwhile.
    let read = py.detach(|| read(&path)).map_err(told)?;
    let all = PyDict::new(py);
    let tables = PyList::empty(py);
    for (head, table) in read.heads.iter().zip(read.tables) {
        let columns = PyDict::new(py);
        for (column, values) in head.columns.iter().zip(table.columns) {
            let values = values.into_python(py)?;
            values.set_item("unit", &column.unit)?;
            columns.set_item(column.name(), values)?;
        }
        let as_dict = PyDict::new(py);
        as_dict.set_item("name", &head.name)?;
        as_dict.set_item("role", &head.role)?;
        as_dict.set_item("at_ns", bytes_of(py, &table.at_ns, i64::to_ne_bytes))?;
        as_dict.set_item("woke_ns", bytes_of(py, &table.woke_ns, i64::to_ne_bytes))?;
        as_dict.set_item("columns", columns)?;
        tables.append(as_dict)?;
    }
    all.set_item("tables", tables)?;
    all.set_item("facts", read.facts)?;
    all.set_item("damage", read.damage)?;
    all.set_item("incomplete_rows", read.incomplete)?;
    Ok(all)
}

#[derive(Default)]
struct Read {
    heads: Vec<coaxle_recording::ReadTable>,
    tables: Vec<Table>,
    facts: BTreeMap<String, String>,
    damage: Vec<String>,
    incomplete: u64,
}

/// Greatest number of damaged pieces listed.
const MOST_DAMAGE: usize = 100;

fn read(path: &std::path::Path) -> anyhow::Result<Read> {
    let file = File::open(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut reader = Reader::new(BufReader::new(file));
    let mut read = Read::default();
    while let Some(item) = reader.next() {
        match item {
            Ok(Item::Row(row)) => {
                // A table is complete when its first row comes, and not before.
                for head in &reader.tables()[read.tables.len()..] {
                    let columns = head.columns.iter().map(|column| Column::of(column.kind));
                    read.tables.push(Table {
                        columns: columns.collect(),
                        ..Table::default()
                    });
                }
                let table = &mut read.tables[row.table];
                table.at_ns.push(row.at_ns);
                table.woke_ns.push(row.woke_ns);
                for (column, value) in table.columns.iter_mut().zip(row.values) {
                    column.push(value);
                }
            }
            Ok(Item::Facts(facts)) => read.facts.extend(facts),
            Ok(_) => {}
            // Further damage is not listed, but reading goes on for the rows behind it.
            Err(damage) if read.damage.len() < MOST_DAMAGE => {
                read.damage.push(damage.to_string());
            }
            Err(_) => {}
        }
    }
    read.heads = reader.tables().to_vec();
    // Tables without rows are dropped.
    read.heads.truncate(read.tables.len());
    read.incomplete = reader.incomplete_rows();
    // Damage of a file with rows is a property of the result; without any it is the reason.
    if read.heads.is_empty()
        && let Some(first) = read.damage.first()
    {
        anyhow::bail!("{}: received no recording: {first}", path.display());
    }
    Ok(read)
}
