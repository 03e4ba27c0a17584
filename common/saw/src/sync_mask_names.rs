//! The flags of the sync mode in files: a list of names, `["max-velo", "overshoot-pos"]`; in compact
//! formats, their bits.

use core::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeSeq;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::SyncMask;

impl Serialize for SyncMask {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // In a compact format the number is short, and it is the one that a PLC has.
        if !serializer.is_human_readable() {
            return serializer.serialize_u32(self.bits());
        }
        let mut names = serializer.serialize_seq(Some(self.iter().count()))?;
        for (name, _) in self.iter_names() {
            names.serialize_element(&SpelledFlag(name))?;
        }
        names.end()
    }
}

impl<'de> Deserialize<'de> for SyncMask {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            return deserializer.deserialize_seq(Flags);
        }
        let bits = u32::deserialize(deserializer)?;
        // Refused, not ignored: a check that is asked for and not made would be worse than none.
        Self::from_bits(bits).ok_or_else(|| {
            let unknown = bits & !Self::all().bits();
            D::Error::custom(format_args!(
                "sync mode {bits:#010x} has bits without a meaning: {unknown:#010x}"
            ))
        })
    }
}

/// A flag's name as files spell it: `MAX_VELO` is `max-velo`.
struct SpelledFlag(&'static str);

impl fmt::Display for SpelledFlag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Letter by letter, since the crate allocates nothing here.
        let mut letters = self.0.chars().map(spelled);
        letters.try_for_each(|letter| write!(f, "{letter}"))
    }
}

impl Serialize for SpelledFlag {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

const fn spelled(c: char) -> char {
    match c {
        '_' => '-',
        _ => c.to_ascii_lowercase(),
    }
}

struct Flags;

impl<'de> Visitor<'de> for Flags {
    type Value = SyncMask;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of flags of the sync mode, such as \"max-velo\"")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut flags: A) -> Result<SyncMask, A::Error> {
        let mut mask = SyncMask::empty();
        while let Some(Flag(flag)) = flags.next_element()? {
            mask |= flag;
        }
        Ok(mask)
    }
}

struct Flag(SyncMask);

impl<'de> Deserialize<'de> for Flag {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_str(FlagName)
    }
}

struct FlagName;

impl Visitor<'_> for FlagName {
    type Value = Flag;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "one of")?;
        SyncMask::all()
            .iter_names()
            .try_for_each(|(name, _)| write!(f, " {}", SpelledFlag(name)))
    }

    fn visit_str<E: Error>(self, received: &str) -> Result<Flag, E> {
        // The flag's name is respelled, not the input: `MAX_VELO` in a file stays unknown.
        let named = |name: &str| name.chars().map(spelled).eq(received.chars());
        SyncMask::all()
            .iter_names()
            .find(|(name, _)| named(name))
            .map(|(_, flag)| Flag(flag))
            .ok_or_else(|| E::invalid_value(serde::de::Unexpected::Str(received), &self))
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for SyncMask {
    fn schema_name() -> alloc::borrow::Cow<'static, str> {
        "SyncMask".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let flags = Self::all();
        let names = flags
            .iter_names()
            .map(|(name, _)| alloc::format!("{}", SpelledFlag(name)));
        let names: alloc::vec::Vec<_> = names.collect();
        schemars::json_schema!({
            "description": "Flags of the sync mode: checks of the profile, and the reports of errors.",
            "type": "array",
            "items": { "enum": names },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::IntoDeserializer;
    use serde::de::value::{Error, SeqDeserializer};
    use std::string::ToString;

    fn read(names: &[&'static str]) -> Result<SyncMask, Error> {
        SyncMask::deserialize(SeqDeserializer::new(names.iter().copied()))
    }

    #[test]
    fn flags_are_named() {
        let mask = SyncMask::MAX_VELO | SyncMask::ROLLBACK_LOCK;
        assert_eq!(read(&["max-velo", "rollback-lock"]), Ok(mask));
        let refused = read(&["MAX_VELO"]).unwrap_err().to_string();
        assert!(refused.contains("max-velo"), "{refused}");
    }

    #[test]
    fn every_flag_reads_as_it_is_written() {
        for (name, flag) in SyncMask::all().iter_names() {
            let spelled = SpelledFlag(name).to_string();
            let read = Flag::deserialize(IntoDeserializer::<Error>::into_deserializer(
                spelled.as_str(),
            ));
            assert_eq!(read.map(|Flag(flag)| flag), Ok(flag));
        }
    }
}
