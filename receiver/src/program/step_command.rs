//! Commands of a step: to its slave, or on the cam plates of the receiver.

use coaxle_node::command::{AnyCommand, CommandFamily, PlateCommand, PlateWork};
use coaxle_slave::Command;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserializer;

use crate::cam_source::CamSource;

/// The command of a step: to the slave, or a change of the cam plates, which all slaves of the
/// receiver share. A plate is read and calculated at the start.
pub type StepCommand = AnyCommand<CamSource>;

/// True for the commands that a step can have.
pub(super) fn is_for_steps(family: CommandFamily) -> bool {
    matches!(
        family,
        CommandFamily::Slave | CommandFamily::Plate(PlateWork::Changes)
    )
}

/// Reads the command of a step.
pub(super) fn read<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<StepCommand>, D::Error> {
    StepCommand::deserialize_one_of(deserializer, is_for_steps).map(Some)
}

/// The schema of a step's command.
pub(super) struct StepCommandSchema;

impl JsonSchema for StepCommandSchema {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "StepCommand".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let (slave, plate) = (
            generator.subschema_for::<Command>(),
            generator.subschema_for::<PlateChangeSchema>(),
        );
        json_schema!({
            "description": "What a step does: a command to its slave, or one about the cam plates.",
            "anyOf": [slave, plate],
        })
    }
}

/// The schema of the commands that change the plates.
struct PlateChangeSchema;

impl JsonSchema for PlateChangeSchema {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "PlateChange".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut schema = PlateCommand::<CamSource>::json_schema(generator);
        let rows = PlateCommand::<CamSource>::ROWS.iter();
        let changes: Vec<_> = rows
            .filter(|row| row.traits == PlateWork::Changes)
            .map(|row| row.key)
            .collect();
        if let Some(commands) = schema
            .get_mut("oneOf")
            .and_then(|commands| commands.as_array_mut())
        {
            commands.retain(|command| {
                let fields = &command["properties"];
                changes.iter().any(|key| fields.get(key).is_some())
            });
        }
        schema.insert(
            "description".to_owned(),
            "A command on the cam plates of the receiver, which all of its slaves share: executed at once, or \
             refused."
                .into(),
        );
        schema
    }
}
