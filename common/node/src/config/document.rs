//! TOML as a document, from which types are read.

use coaxle_wire::document::Document;
use toml::{Table, Value};

pub(crate) fn document_of_table(table: &Table) -> Document {
    let fields = table.iter();
    let fields = fields.map(|(key, value)| (Document::Text(key.clone()), document_of(value)));
    Document::Table(fields.collect())
}

pub(crate) fn document_of(value: &Value) -> Document {
    match value {
        Value::String(text) => Document::Text(text.clone()),
        Value::Integer(number) => Document::Integer(*number),
        Value::Float(number) => Document::Float(*number),
        Value::Boolean(value) => Document::Boolean(*value),
        Value::Datetime(date) => Document::Date(date.to_string()),
        Value::Array(elements) => Document::List(elements.iter().map(document_of).collect()),
        Value::Table(table) => document_of_table(table),
    }
}
