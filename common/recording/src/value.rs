//! Value of a row.

use coaxle_node::signal::Kind;
use serde::{Serialize, Serializer};

/// A known value of a signal.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A [`Kind::Number`].
    Number(f64),
    /// A [`Kind::Count`].
    Count(u64),
    /// A [`Kind::Integer`].
    Integer(i64),
    /// A [`Kind::Flag`].
    Flag(bool),
    /// A [`Kind::Text`].
    Text(String),
}

impl Value {
    /// Returns the kind of the value.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Number(_) => Kind::Number,
            Self::Count(_) => Kind::Count,
            Self::Integer(_) => Kind::Integer,
            Self::Flag(_) => Kind::Flag,
            Self::Text(_) => Kind::Text,
        }
    }

    /// Returns the number, if it is one.
    #[must_use]
    pub const fn as_number(&self) -> Option<f64> {
        match *self {
            Self::Number(number) => Some(number),
            _ => None,
        }
    }
}

/// Serialises as the original field, so that a table of values is identical to one of rows.
impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(number) => serializer.serialize_f64(*number),
            Self::Count(count) => serializer.serialize_u64(*count),
            Self::Integer(integer) => serializer.serialize_i64(*integer),
            Self::Flag(flag) => serializer.serialize_bool(*flag),
            Self::Text(text) => serializer.serialize_str(text),
        }
    }
}
