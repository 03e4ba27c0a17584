//! Flattens a structure of signals into the messages of a row, without naming fields.

use coaxle_node::signal::Kind;
use serde::ser::{self, Impossible, Serialize};

use crate::encoded_row::{EncodedRow, RowError, Slot};
use crate::protobuf::{put_bytes, put_count, put_integer, put_number};

/// Writes consecutive values, each into the field of its signal.
pub(crate) struct RowSerializer<'a> {
    slots: &'a [Slot],
    columns: &'a [String],
    next: usize,
    row: &'a mut EncodedRow,
}

impl<'a> RowSerializer<'a> {
    pub(crate) const fn new(
        slots: &'a [Slot],
        columns: &'a [String],
        row: &'a mut EncodedRow,
    ) -> Self {
        let next = 0;
        Self {
            slots,
            columns,
            next,
            row,
        }
    }

    /// Checks that all values have been written.
    pub(crate) fn finish(&self) -> Result<(), RowError> {
        if self.next == self.slots.len() {
            return Ok(());
        }
        Err(RowError::Length {
            received: self.next,
            expected: self.slots.len(),
        })
    }

    /// Writes a value of this kind, or an unknown one.
    fn value(
        &mut self,
        kind: Option<Kind>,
        put: impl FnOnce(&mut Vec<u8>, u32),
    ) -> Result<(), RowError> {
        let Some(slot) = self.slots.get(self.next) else {
            return Err(RowError::Length {
                received: self.next + 1,
                expected: self.slots.len(),
            });
        };
        // An unknown value has no kind to compare.
        if let Some(kind) = kind
            && kind != slot.kind
        {
            return Err(self.wrong_kind(kind, slot.kind));
        }
        put(self.row.open_message(), slot.number);
        // By the slot, not by structures: groups may be nested in any way, and an absent last value ends its message
        // too.
        if slot.is_last {
            self.row.end_message();
        }
        self.next += 1;
        Ok(())
    }

    fn wrong_kind(&self, received: Kind, expected: Kind) -> RowError {
        RowError::Kind {
            column: self.columns[self.next].clone(),
            received,
            expected,
        }
    }
}

impl ser::Error for RowError {
    fn custom<T: std::fmt::Display>(message: T) -> Self {
        Self::NoRow(message.to_string())
    }
}

fn no_row<T>(what: &str) -> Result<T, RowError> {
    Err(RowError::NoRow(what.to_owned()))
}

macro_rules! values {
    ($($method:ident: $type:ty, $kind:ident, $put:ident as $as:ty;)*) => {
        $(fn $method(self, value: $type) -> Result<(), RowError> {
            self.value(Some(Kind::$kind), |out, number| $put(out, number, value as $as))
        })*
    };
}

impl ser::Serializer for &mut RowSerializer<'_> {
    type Ok = ();
    type Error = RowError;
    type SerializeSeq = Self;
    type SerializeTuple = Self;
    type SerializeTupleStruct = Self;
    type SerializeTupleVariant = Impossible<(), RowError>;
    type SerializeMap = Impossible<(), RowError>;
    type SerializeStruct = Self;
    type SerializeStructVariant = Impossible<(), RowError>;

    values! {
        serialize_f32: f32, Number, put_number as f64;
        serialize_f64: f64, Number, put_number as f64;
        serialize_u8: u8, Count, put_count as u64;
        serialize_u16: u16, Count, put_count as u64;
        serialize_u32: u32, Count, put_count as u64;
        serialize_u64: u64, Count, put_count as u64;
        serialize_i8: i8, Integer, put_integer as i64;
        serialize_i16: i16, Integer, put_integer as i64;
        serialize_i32: i32, Integer, put_integer as i64;
        serialize_i64: i64, Integer, put_integer as i64;
        serialize_bool: bool, Flag, put_count as u64;
    }

    fn serialize_char(self, value: char) -> Result<(), RowError> {
        self.serialize_str(value.encode_utf8(&mut [0; 4]))
    }

    fn serialize_str(self, value: &str) -> Result<(), RowError> {
        self.value(Some(Kind::Text), |out, number| {
            put_bytes(out, number, value.as_bytes());
        })
    }

    fn serialize_bytes(self, _: &[u8]) -> Result<(), RowError> {
        no_row("bytes")
    }

    fn serialize_none(self) -> Result<(), RowError> {
        let is_number = (self.slots.get(self.next)).is_some_and(|slot| slot.kind == Kind::Number);
        self.value(None, |out, number| {
            // PlotJuggler does not look at presence, and would plot an absent number as 0. An absent optional field is the
            // encoding of other unknown values.
            if is_number {
                put_number(out, number, f64::NAN);
            }
        })
    }

    fn serialize_some<T: ?Sized + Serialize>(self, value: &T) -> Result<(), RowError> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), RowError> {
        no_row("nothing")
    }

    fn serialize_unit_struct(self, name: &'static str) -> Result<(), RowError> {
        no_row(name)
    }

    fn serialize_unit_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
    ) -> Result<(), RowError> {
        // States are recorded by name, which stays readable when numbers change.
        self.serialize_str(variant)
    }

    fn serialize_newtype_struct<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), RowError> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: ?Sized + Serialize>(
        self,
        name: &'static str,
        _: u32,
        _: &'static str,
        _: &T,
    ) -> Result<(), RowError> {
        no_row(name)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Self, RowError> {
        Ok(self)
    }

    fn serialize_tuple(self, _: usize) -> Result<Self, RowError> {
        Ok(self)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Self, RowError> {
        Ok(self)
    }

    fn serialize_tuple_variant(
        self,
        name: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeTupleVariant, RowError> {
        no_row(name)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self::SerializeMap, RowError> {
        no_row("a map")
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, RowError> {
        Ok(self)
    }

    fn serialize_struct_variant(
        self,
        name: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeStructVariant, RowError> {
        no_row(name)
    }
}

macro_rules! one_after_the_other {
    ($($trait:ident, $method:ident;)*) => {
        $(impl ser::$trait for &mut RowSerializer<'_> {
            type Ok = ();
            type Error = RowError;

            fn $method<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), RowError> {
                value.serialize(&mut **self)
            }

            fn end(self) -> Result<(), RowError> {
                Ok(())
            }
        })*
    };
}

one_after_the_other! {
    SerializeSeq, serialize_element;
    SerializeTuple, serialize_element;
    SerializeTupleStruct, serialize_field;
}

impl ser::SerializeStruct for &mut RowSerializer<'_> {
    type Ok = ();
    type Error = RowError;

    fn serialize_field<T: ?Sized + Serialize>(
        &mut self,
        _: &'static str,
        value: &T,
    ) -> Result<(), RowError> {
        value.serialize(&mut **self)
    }

    fn end(self) -> Result<(), RowError> {
        Ok(())
    }
}
