//! Name of a command, read before its other fields.

use std::fmt;

use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// Name of a command; none if it is not a command. Its fields are skipped.
#[derive(Debug, Default)]
pub(super) struct CommandName(Option<String>);

impl CommandName {
    pub(super) fn as_deref(&self) -> Option<&str> {
        self.0.as_deref()
    }
}

impl<'de> Deserialize<'de> for CommandName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(CommandNameVisitor)
    }
}

struct CommandNameVisitor;

/// Leaves what is not a map to the reader of the command, whose error names what is expected.
macro_rules! no_command {
    ($($visit:ident($of:ty))*) => { $(
        fn $visit<E>(self, _: $of) -> Result<CommandName, E> {
            Ok(CommandName(None))
        }
    )* };
}

impl<'de> Visitor<'de> for CommandNameVisitor {
    type Value = CommandName;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a command")
    }

    no_command! { visit_bool(bool) visit_i64(i64) visit_u64(u64) visit_f64(f64) visit_str(&str) }

    fn visit_unit<E>(self) -> Result<CommandName, E> {
        Ok(CommandName(None))
    }

    fn visit_seq<A: serde::de::SeqAccess<'de>>(self, mut seq: A) -> Result<CommandName, A::Error> {
        while seq.next_element::<IgnoredAny>()?.is_some() {}
        Ok(CommandName(None))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<CommandName, A::Error> {
        let mut name = None;
        while let Some(key) = map.next_key::<String>()? {
            let _ = map.next_value::<IgnoredAny>()?;
            name.get_or_insert(key);
        }
        Ok(CommandName(name))
    }
}
