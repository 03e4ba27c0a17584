//! Kinds of signal values, derived from the type of the field.

use std::fmt;
use std::marker::PhantomData;

/// Kind of a signal's values. Any value may be missing, where it is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A number, as `f64`.
    Number,
    /// A count, from 0 on, as `u64`.
    Count,
    /// An integer that may be negative, as `i64`.
    Integer,
    /// True or false.
    Flag,
    /// A word from a fixed set.
    Text,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Number => "number",
            Self::Count => "count",
            Self::Integer => "integer",
            Self::Flag => "flag",
            Self::Text => "text",
        })
    }
}

/// The type of a field. Its kind is its constant `KIND`: that of the type itself where one of the
/// lines below names it, else that of [`AnyOther`], since the compiler looks among a type's own
/// items first. So every enum of names is a text, from any crate, and none has to be listed.
#[doc(hidden)]
pub struct Field<T>(PhantomData<T>);

/// Type that is not named: an enum of words.
#[doc(hidden)]
pub trait AnyOther {
    const KIND: Kind = Kind::Text;
}

impl<T> AnyOther for Field<T> {}

macro_rules! kinds {
    ($($kind:ident: $($type:ty)*;)*) => {
        $($(
            impl Field<$type> {
                pub const KIND: Kind = Kind::$kind;
            }
            impl Field<Option<$type>> {
                pub const KIND: Kind = Kind::$kind;
            }
        )*)*
    };
}

kinds! {
    Number: f32 f64;
    Count: u8 u16 u32 u64;
    Integer: i8 i16 i32 i64;
    Flag: bool;
}

#[cfg(test)]
#[allow(
    unreachable_pub,
    reason = "the macro declares what a crate shows to others"
)]
mod tests {
    use super::*;
    use crate::signal::Signals;

    #[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
    pub enum Word {
        #[default]
        One,
    }

    crate::signals! {
        /// A signal of each kind.
        pub struct Each of Node {
            /// A number.
            a: f64 [""],
            /// A number, or nothing.
            b: Option<f64> [""],
            /// A count.
            c: u32 [""],
            /// A count, or nothing.
            d: Option<u64> [""],
            /// An integer.
            e: i32 [""],
            /// An integer, or nothing.
            f: Option<i64> [""],
            /// A flag.
            g: Option<bool> [""],
            /// A word.
            h: Word [""],
            /// A word, or nothing.
            i: Option<Word> [""],
        }
    }

    #[test]
    fn the_kind_is_that_of_the_field_whether_or_not_it_may_be_missing() {
        use Kind::{Count, Flag, Integer, Number, Text};
        let kinds: Vec<Kind> = Each::SIGNALS.iter().map(|signal| signal.kind).collect();
        let expected = [
            Number, Number, Count, Count, Integer, Integer, Flag, Text, Text,
        ];
        assert_eq!(kinds, expected);
    }
}
