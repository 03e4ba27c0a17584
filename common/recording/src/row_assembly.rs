//! Assembly of a row from its messages.

use std::collections::BTreeMap;

use coaxle_node::signal::Kind;

use crate::protobuf::{InvalidMessage, MessageFields, WireValue, unzigzag};
use crate::read_table::{Column, ReadTable, Row};
use crate::schema::SchemaField;
use crate::value::Value;

/// A table while its channels are read, and its current row.
#[derive(Default)]
pub(crate) struct OpenTable {
    /// Number of its instances, and those with known channels, by their place.
    pub(crate) expected: usize,
    pub(crate) instances: BTreeMap<usize, OpenInstance>,
    pub(crate) sequence: Option<u32>,
    pub(crate) received: usize,
    pub(crate) at_ns: i64,
    pub(crate) woke_ns: i64,
    values: Vec<Option<Value>>,
}

pub(crate) struct OpenInstance {
    columns: Vec<Column>,
    fields: Vec<SchemaField>,
    /// Start of its values in a row; known when all channels have been read.
    start: usize,
    is_received: bool,
}

impl OpenInstance {
    pub(crate) const fn new(columns: Vec<Column>, fields: Vec<SchemaField>) -> Self {
        Self {
            columns,
            fields,
            start: 0,
            is_received: false,
        }
    }
}

impl OpenTable {
    /// Makes a table of this number of instances.
    pub(crate) fn of(expected: usize) -> Self {
        Self {
            expected,
            ..Self::default()
        }
    }

    /// Sets the place of each instance in a row, as soon as all are known.
    pub(crate) fn lay_out(&mut self, table: &mut ReadTable) {
        if self.instances.len() < self.expected {
            return;
        }
        // In the order of the places, which is that of the columns of a trace, whatever order the channels came in.
        for instance in self.instances.values_mut() {
            instance.start = table.columns.len();
            table.columns.append(&mut instance.columns);
        }
        self.values = vec![None; table.columns.len()];
    }

    pub(crate) fn begin(&mut self, sequence: u32) {
        self.sequence = Some(sequence);
        self.received = 0;
        // An absent field is an unknown value: the last row's must not remain.
        self.values.fill(None);
        for instance in self.instances.values_mut() {
            instance.is_received = false;
        }
    }

    pub(crate) fn put(&mut self, place: usize, data: &[u8]) -> Result<(), InvalidMessage> {
        let Some(instance) = self.instances.get_mut(&place) else {
            return Ok(());
        };
        for field in MessageFields(data) {
            let (number, wire) = field?;
            let known = instance.fields.binary_search_by_key(&number, |f| f.number);
            // A field that is not in the schema comes from a later version, and is ignored as Protocol Buffers
            // demand.
            let Ok(known) = known else {
                continue;
            };
            let value = value(instance.fields[known].kind, wire).ok_or(InvalidMessage)?;
            // No signal is NaN: it is written for an unknown number.
            let is_known = !matches!(value, Value::Number(number) if number.is_nan());
            // No values of an incomplete table: its rows are incomplete, too.
            if let Some(place) = self.values.get_mut(instance.start + known) {
                *place = is_known.then_some(value);
            }
        }
        // A duplicate counts once, or a row would be complete without all of its instances.
        if !instance.is_received {
            instance.is_received = true;
            self.received += 1;
        }
        Ok(())
    }

    /// Takes the row, if it is complete.
    pub(crate) fn take_row(&mut self, table: usize) -> Option<Row> {
        if self.received < self.expected {
            return None;
        }
        self.received = 0;
        // A repetition of the row's messages then begins a row of its own, instead of completing none.
        self.sequence = None;
        Some(Row {
            table,
            at_ns: self.at_ns,
            woke_ns: self.woke_ns,
            values: self.values.clone(),
        })
    }
}

fn value(kind: Kind, wire: WireValue<'_>) -> Option<Value> {
    Some(match (kind, wire) {
        (Kind::Number, WireValue::Fixed64(bits)) => Value::Number(f64::from_bits(bits)),
        (Kind::Count, WireValue::Varint(count)) => Value::Count(count),
        (Kind::Integer, WireValue::Varint(integer)) => Value::Integer(unzigzag(integer)),
        (Kind::Flag, WireValue::Varint(flag)) => Value::Flag(flag != 0),
        (Kind::Text, WireValue::Bytes(text)) => Value::Text(str::from_utf8(text).ok()?.to_owned()),
        _ => return None,
    })
}
