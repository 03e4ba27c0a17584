//! Reading a command by its name.

use std::fmt;
use std::marker::PhantomData;

use coaxle_slave::Command;
use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeSeed, EnumAccess, Error, IgnoredAny, IntoDeserializer, MapAccess, VariantAccess,
    Visitor,
};
use serde::{Deserialize, Deserializer};

use super::any_command::{AnyCommand, CommandFamily, ListedCommand};
use super::cam::PlateCommand;
use super::far::FarCommand;

/// By hand: the first key selects the kind of command, so that errors behind it name their field.
impl<'de, P: Deserialize<'de>> Deserialize<'de> for AnyCommand<P> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::deserialize_one_of(deserializer, |_| true)
    }
}

impl<P> AnyCommand<P> {
    /// Reads a command of a family that is accepted.
    ///
    /// # Errors
    /// That of the deserializer. For another name it lists those that are accepted.
    pub fn deserialize_one_of<'de, D: Deserializer<'de>>(
        deserializer: D,
        accepts: fn(CommandFamily) -> bool,
    ) -> Result<Self, D::Error>
    where
        P: Deserialize<'de>,
    {
        deserializer.deserialize_map(ByName {
            accepts,
            plate: PhantomData,
        })
    }
}

/// Finds the command with a key, among those of the families that are accepted.
pub(super) fn find(
    key: &str,
    accepts: impl Fn(CommandFamily) -> bool,
) -> Result<ListedCommand, String> {
    let is_accepted = |command: &ListedCommand| accepts(command.family);
    let found = ListedCommand::of(key).filter(is_accepted);
    found.ok_or_else(|| {
        let known = ListedCommand::all().filter(is_accepted);
        let known: Vec<_> = known.map(|known| format!("`{}`", known.key)).collect();
        format!(
            "unknown variant `{key}`, expected one of {}",
            known.join(", ")
        )
    })
}

struct ByName<P> {
    accepts: fn(CommandFamily) -> bool,
    plate: PhantomData<P>,
}

impl<'de, P: Deserialize<'de>> Visitor<'de> for ByName<P> {
    type Value = AnyCommand<P>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a command, such as { halt = {} }")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<AnyCommand<P>, A::Error> {
        let Some(name) = map.next_key::<String>()? else {
            return Err(Error::invalid_length(0, &self));
        };
        let listed = find(&name, self.accepts).map_err(Error::custom)?;
        let fields = NamedVariant {
            name: &name,
            map: &mut map,
        };
        let command = match listed.family {
            CommandFamily::Slave => AnyCommand::Slave(Command::deserialize(fields)?),
            CommandFamily::Plate(_) => AnyCommand::Plate(PlateCommand::deserialize(fields)?),
            CommandFamily::Far => AnyCommand::Far(FarCommand::deserialize(fields)?),
        };
        match map.next_key::<IgnoredAny>()? {
            None => Ok(command),
            Some(_) => Err(Error::invalid_length(2, &self)),
        }
    }
}

/// A field of a map, read as the variant of an enum.
struct NamedVariant<'a, A> {
    name: &'a str,
    map: &'a mut A,
}

impl<'de, A: MapAccess<'de>> Deserializer<'de> for NamedVariant<'_, A> {
    type Error = A::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, A::Error> {
        visitor.visit_enum(self)
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

impl<'de, A: MapAccess<'de>> EnumAccess<'de> for NamedVariant<'_, A> {
    type Error = A::Error;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), A::Error> {
        let name: StrDeserializer<'_, A::Error> = self.name.into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'de, A: MapAccess<'de>> VariantAccess<'de> for NamedVariant<'_, A> {
    type Error = A::Error;

    fn unit_variant(self) -> Result<(), A::Error> {
        self.map.next_value()
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, A::Error> {
        self.map.next_value_seed(seed)
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, A::Error> {
        self.map.next_value_seed(Fields(visitor))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, A::Error> {
        self.map.next_value_seed(Fields(visitor))
    }
}

/// The fields of a variant.
struct Fields<V>(V);

impl<'de, V: Visitor<'de>> DeserializeSeed<'de> for Fields<V> {
    type Value = V::Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<V::Value, D::Error> {
        deserializer.deserialize_any(self.0)
    }
}
