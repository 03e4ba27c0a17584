//! Types from a document: serde's deserializer over a part of it.

use std::slice;

use serde::Deserializer;
use serde::de::{
    DeserializeSeed, EnumAccess, Error, MapAccess, SeqAccess, Unexpected, VariantAccess, Visitor,
};

use super::{Document, Misread};

impl<'de> Deserializer<'de> for &'de Document {
    type Error = Misread;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misread> {
        match self {
            Document::Null => visitor.visit_unit(),
            Document::Boolean(value) => visitor.visit_bool(*value),
            Document::Integer(number) => visitor.visit_i64(*number),
            Document::Unsigned(number) => visitor.visit_u64(*number),
            Document::Float(number) => visitor.visit_f64(*number),
            Document::Text(text) | Document::Date(text) => visitor.visit_borrowed_str(text),
            Document::List(list) => read_list(list, visitor),
            Document::Table(table) => read_table(table, visitor),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misread> {
        match self {
            Document::Null => visitor.visit_none(),
            value => visitor.visit_some(value),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Misread> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misread> {
        visitor.visit_enum(variant_of(self)?)
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        seq tuple tuple_struct map struct identifier ignored_any
    }
}

fn read_list<'de, V: Visitor<'de>>(list: &'de [Document], visitor: V) -> Result<V::Value, Misread> {
    let mut elements = Elements {
        rest: list.iter(),
        count: list.len(),
    };
    let value = visitor.visit_seq(&mut elements)?;
    all_read(elements.rest.len(), list.len(), "fewer elements in array")?;
    Ok(value)
}

fn read_table<'de, V: Visitor<'de>>(
    table: &'de [(Document, Document)],
    visitor: V,
) -> Result<V::Value, Misread> {
    let mut fields = Fields {
        rest: table.iter(),
        value: None,
    };
    let value = visitor.visit_map(&mut fields)?;
    all_read(fields.rest.len(), table.len(), "fewer elements in map")?;
    Ok(value)
}

fn all_read(rest: usize, count: usize, expected: &'static str) -> Result<(), Misread> {
    match rest {
        0 => Ok(()),
        _ => Err(Misread::invalid_length(count, &expected)),
    }
}

/// The elements of a list that were not read yet.
struct Elements<'de> {
    rest: slice::Iter<'de, Document>,
    count: usize,
}

impl<'de> SeqAccess<'de> for Elements<'de> {
    type Error = Misread;

    fn next_element_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Misread> {
        let index = self.count - self.rest.len();
        let Some(element) = self.rest.next() else {
            return Ok(None);
        };
        let value = seed.deserialize(element);
        value
            .map(Some)
            .map_err(|misread| misread.within_element(index))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// The fields of a table that were not read yet.
struct Fields<'de> {
    rest: slice::Iter<'de, (Document, Document)>,
    /// The key that was read, and the value that belongs to it.
    value: Option<&'de (Document, Document)>,
}

impl<'de> MapAccess<'de> for Fields<'de> {
    type Error = Misread;

    fn next_key_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Misread> {
        self.value = self.rest.next();
        let Some((key, _)) = self.value else {
            return Ok(None);
        };
        let read = seed.deserialize(key);
        // A field that is unknown is the one that is wrong.
        read.map(Some)
            .map_err(|misread| misread.within_key(key.key()))
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Misread> {
        let Some((key, value)) = self.value.take() else {
            return Err(Misread::custom("value is missing"));
        };
        seed.deserialize(value)
            .map_err(|misread| misread.within_key(key.key()))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// A variant of an enum: a text, or a table with the variant as its only key.
struct Variant<'de> {
    name: &'de Document,
    /// Contents of the variant; none for a text.
    value: Option<&'de Document>,
}

fn variant_of(document: &Document) -> Result<Variant<'_>, Misread> {
    match document {
        Document::Text(_) => Ok(Variant {
            name: document,
            value: None,
        }),
        Document::Table(table) => match table.as_slice() {
            [(name, value)] => Ok(Variant {
                name,
                value: Some(value),
            }),
            [] => Err(Misread::custom(
                "wanted exactly 1 element, found 0 elements",
            )),
            _ => Err(Misread::custom(
                "wanted exactly 1 element, more than 1 element",
            )),
        },
        _ => Err(Misread::invalid_type(
            Unexpected::UnitVariant,
            &"string only",
        )),
    }
}

impl<'de> EnumAccess<'de> for Variant<'de> {
    type Error = Misread;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), Misread> {
        Ok((seed.deserialize(self.name)?, self))
    }
}

impl<'de> Variant<'de> {
    /// Contents of the variant, if they are of this kind.
    fn value(&self, kind: &'static str) -> Result<&'de Document, Misread> {
        let missing = || Misread::invalid_type(Unexpected::UnitVariant, &kind);
        self.value.ok_or_else(missing)
    }

    fn within<T>(&self, read: Result<T, Misread>) -> Result<T, Misread> {
        read.map_err(|misread| misread.within_key(self.name.key()))
    }
}

impl<'de> VariantAccess<'de> for Variant<'de> {
    type Error = Misread;

    fn unit_variant(self) -> Result<(), Misread> {
        self.within(self.value.map_or(Ok(()), read_nothing))
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Misread> {
        let read = self.value("newtype variant");
        self.within(read.and_then(|value| seed.deserialize(value)))
    }

    fn tuple_variant<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Misread> {
        let read = self.value("tuple variant");
        self.within(read.and_then(|value| read_tuple(value, length, visitor)))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misread> {
        let read = self.value("struct variant");
        self.within(read.and_then(|value| value.deserialize_any(visitor)))
    }
}

fn read_tuple<'de, V: Visitor<'de>>(
    value: &'de Document,
    length: usize,
    visitor: V,
) -> Result<V::Value, Misread> {
    match value {
        Document::List(list) if list.len() == length => read_list(list, visitor),
        Document::List(_) => {
            let expected = format_args!("expected tuple with length {length}");
            Err(Misread::custom(expected))
        }
        other => Err(no_table(other)),
    }
}

/// A variant that holds nothing may have null, an empty table or an empty list.
fn read_nothing(value: &Document) -> Result<(), Misread> {
    match value {
        Document::Null => Ok(()),
        Document::List(list) if list.is_empty() => Ok(()),
        Document::Table(table) if table.is_empty() => Ok(()),
        Document::List(_) => Err(Misread::custom("expected empty array")),
        Document::Table(_) => Err(Misread::custom("expected empty table")),
        other => Err(no_table(other)),
    }
}

fn no_table(received: &Document) -> Misread {
    let received = received.kind();
    Misread::custom(format_args!("expected table, found {received}"))
}

impl Document {
    /// The text of a key.
    fn key(&self) -> &str {
        match self {
            Self::Text(key) => key,
            _ => "?",
        }
    }

    /// Name of the type, as TOML calls it.
    const fn kind(&self) -> &'static str {
        match self {
            Self::Null => "null",
            Self::Boolean(_) => "boolean",
            Self::Integer(_) | Self::Unsigned(_) => "integer",
            Self::Float(_) => "float",
            Self::Text(_) => "string",
            Self::Date(_) => "datetime",
            Self::List(_) => "array",
            Self::Table(_) => "table",
        }
    }
}
