//! A document as read, before its fields have types, and reading types from it.
//!
//! A config type is as many copies of its reading code as there are deserializers that read it. Here is one for
//! all formats, and its error carries the path of the field: a wrapper around another deserializer, which serde
//! offers for that, doubles each copy and its visitors.

mod json;
mod misread;
mod reading;
#[cfg(test)]
mod tests;

pub use json::{from_json, from_json_value};
pub use misread::Misread;

/// A document, or a part of it.
#[derive(Clone, Debug, PartialEq)]
pub enum Document {
    /// No value; TOML has none of these.
    Null,
    /// True or false.
    Boolean(bool),
    /// A whole number.
    Integer(i64),
    /// A whole number as JSON has it: not negative.
    Unsigned(u64),
    /// A number.
    Float(f64),
    /// A text.
    Text(String),
    /// A date or a time of TOML, as written: read as a text, but no name of a variant.
    Date(String),
    /// A list.
    List(Vec<Document>),
    /// A table: its keys, which are texts, and their values. A key may be there twice.
    Table(Vec<(Document, Document)>),
}
