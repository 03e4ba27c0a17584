//! Commands of a step: to its slave, or on the cam plates of the receiver.

use std::fmt;
use std::sync::LazyLock;

use coaxle_cam::TableId;
use coaxle_node::config::schema::{alternatives, resolved, schema_of};
use coaxle_slave::Command;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeSeed, EnumAccess, Error, IgnoredAny, IntoDeserializer, MapAccess, VariantAccess,
    Visitor,
};
use serde::{Deserialize, Deserializer, Serialize};

use crate::cam_source::CamSource;

/// The command of a step.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum StepCommand {
    /// A command to the slave.
    Slave(Command),
    /// A command on the plates.
    Plate(PlateCommand),
}

/// A command on the cam plates of the receiver, which all of its slaves share: executed at once, or
/// refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    rename_all = "kebab-case",
    rename_all_fields = "kebab-case",
    deny_unknown_fields
)]
pub enum PlateCommand {
    /// `MC_CamTableSelect`: loads a plate, or replaces another. The plate is read and calculated at
    /// the start.
    #[doc(alias = "MC_CamTableSelect")]
    CamTableSelect {
        /// Number of the plate, 1 to 255; by default the number in the plate.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        table: Option<TableId>,
        /// Permission to replace a plate of that number.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        replace: bool,
        /// The plate.
        plate: CamSource,
    },
    /// Deletes a plate.
    CamTableDelete {
        /// The number of the plate.
        table: TableId,
    },
}

impl StepCommand {
    /// PLC name of the command.
    pub(super) const fn name(&self) -> &'static str {
        match self {
            Self::Slave(command) => command.name(),
            Self::Plate(PlateCommand::CamTableSelect { .. }) => "MC_CamTableSelect",
            Self::Plate(PlateCommand::CamTableDelete { .. }) => "cam-table-delete",
        }
    }
}

impl PlateCommand {
    const NAMES: [&str; 2] = ["cam-table-select", "cam-table-delete"];
}

impl JsonSchema for StepCommand {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "StepCommand".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let (slave, plate) = (
            generator.subschema_for::<Command>(),
            generator.subschema_for::<PlateCommand>(),
        );
        json_schema!({
            "description": "What a step does: a command to its slave, or one about the cam plates.",
            "anyOf": [slave, plate],
        })
    }
}

/// The names of all commands, in the order of the schema.
static NAMES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let root = schema_of::<StepCommand>().to_value();
    let kinds = alternatives(&root).into_iter().flatten();
    let commands = kinds.flat_map(|kind| alternatives(resolved(&root, kind)).into_iter().flatten());
    let fields = commands.filter_map(|command| command["properties"].as_object());
    fields.flat_map(|fields| fields.keys().cloned()).collect()
});

/// By hand: the first key selects the kind of command, so that errors behind it name their field.
impl<'de> Deserialize<'de> for StepCommand {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(StepCommandVisitor)
    }
}

struct StepCommandVisitor;

impl<'de> Visitor<'de> for StepCommandVisitor {
    type Value = StepCommand;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a command, such as { halt = {} }")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<StepCommand, A::Error> {
        let Some(name) = map.next_key::<String>()? else {
            return Err(Error::invalid_length(0, &self));
        };
        if !NAMES.contains(&name) {
            let known: Vec<_> = NAMES.iter().map(|name| format!("`{name}`")).collect();
            let known = known.join(", ");
            return Err(Error::custom(format!(
                "unknown variant `{name}`, expected one of {known}"
            )));
        }
        let fields = Variant {
            name: &name,
            map: &mut map,
        };
        let command = if PlateCommand::NAMES.contains(&name.as_str()) {
            StepCommand::Plate(PlateCommand::deserialize(fields)?)
        } else {
            StepCommand::Slave(Command::deserialize(fields)?)
        };
        match map.next_key::<IgnoredAny>()? {
            None => Ok(command),
            Some(_) => Err(Error::invalid_length(2, &self)),
        }
    }
}

/// A field of a map, read as the variant of an enum.
struct Variant<'a, A> {
    name: &'a str,
    map: &'a mut A,
}

impl<'de, A: MapAccess<'de>> Deserializer<'de> for Variant<'_, A> {
    type Error = A::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, A::Error> {
        visitor.visit_enum(self)
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

impl<'de, A: MapAccess<'de>> EnumAccess<'de> for Variant<'_, A> {
    type Error = A::Error;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), A::Error> {
        let name: StrDeserializer<'_, A::Error> = self.name.into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'de, A: MapAccess<'de>> VariantAccess<'de> for Variant<'_, A> {
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
