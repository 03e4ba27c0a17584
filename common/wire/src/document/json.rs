//! Types from JSON, with the field that is wrong.

use std::fmt;

use serde::Deserializer;
use serde::de::{DeserializeOwned, DeserializeSeed, MapAccess, SeqAccess, Visitor};
use serde_json::Value;

use super::misread::PathStep;
use super::{Document, Misread};

/// Reads a value from JSON.
///
/// # Errors
/// [`Misread`] with the field, and with the line and the column in the reason.
pub fn from_json<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Misread> {
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let read = serde_json::from_slice(bytes);
    read.map_err(|error| misread::<T, _>(&mut json, &error))
}

/// Reads a value from JSON that was read before.
///
/// # Errors
/// [`Misread`] with the field.
pub fn from_json_value<T: DeserializeOwned>(value: &Value) -> Result<T, Misread> {
    T::deserialize(value).map_err(|error| misread::<T, _>(value, &error))
}

/// The error of the library, with the field that a further reading finds: the library knows the place in the text.
fn misread<'de, T: DeserializeOwned, D: Deserializer<'de>>(
    json: D,
    error: &serde_json::Error,
) -> Misread
where
    D::Error: fmt::Display,
{
    let mut path = Vec::new();
    let found = match Part(&mut path).deserialize(json) {
        // All of it can be read where more follows behind it.
        Ok(document) => T::deserialize(&document).err().unwrap_or_default(),
        Err(end) if end.to_string() == error.to_string() => Misread::at(path),
        // The document ends where it is nested too deeply, inside the field that is wrong.
        Err(_) => {
            let keys = path
                .iter()
                .take_while(|step| matches!(step, PathStep::Key(_)));
            let keys = keys.count();
            path.truncate(keys);
            Misread::at(path)
        }
    };
    found.with_reason(error.to_string())
}

/// A part of a document. After an error the path leads to where it is; otherwise it is as before.
struct Part<'p>(&'p mut Vec<PathStep>);

impl<'de> DeserializeSeed<'de> for Part<'_> {
    type Value = Document;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Document, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Part<'_> {
    type Value = Document;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("any value")
    }

    fn visit_unit<E>(self) -> Result<Document, E> {
        Ok(Document::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Document, E> {
        Ok(Document::Boolean(value))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Document, E> {
        Ok(Document::Integer(number))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Document, E> {
        Ok(Document::Unsigned(number))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Document, E> {
        Ok(Document::Float(number))
    }

    fn visit_str<E>(self, text: &str) -> Result<Document, E> {
        Ok(Document::Text(text.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Document, A::Error> {
        let mut list = Vec::new();
        self.0.push(PathStep::Element(0));
        while let Some(element) = elements.next_element_seed(Part(self.0))? {
            list.push(element);
            self.0.pop();
            self.0.push(PathStep::Element(list.len()));
        }
        self.0.pop();
        Ok(Document::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut fields: A) -> Result<Document, A::Error> {
        let mut table = Vec::new();
        while let Some(key) = fields.next_key::<String>()? {
            self.0.push(PathStep::Key(key.clone()));
            let value = fields.next_value_seed(Part(self.0))?;
            self.0.pop();
            table.push((Document::Text(key), value));
        }
        Ok(Document::Table(table))
    }
}
