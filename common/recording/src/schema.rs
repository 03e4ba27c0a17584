//! The schema of a group of signals, as a message description of Protocol Buffers: a `FileDescriptorSet`.

use coaxle_node::signal::{Group, Instance, Kind, Signal};

use crate::protobuf::{
    InvalidMessage, MessageFields, WireValue, put_bytes, put_count, put_message, put_varint,
};
use crate::records::MOST_SIGNALS;

/// A schema, by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Schema {
    /// Package and message: `coaxle.receiver.FarNode`.
    pub(crate) name: String,
    /// The `FileDescriptorSet`.
    pub(crate) data: Vec<u8>,
}

/// A field of a message in its schema.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SchemaField {
    pub(crate) number: u32,
    pub(crate) name: String,
    pub(crate) kind: Kind,
}

// The types of fields, by their numbers in descriptors.
const DOUBLE: u64 = 1;
const UINT64: u64 = 4;
const BOOL: u64 = 8;
const STRING: u64 = 9;
pub(crate) const FIXED32: u64 = 7;
pub(crate) const MESSAGE: u64 = 11;
pub(crate) const ENUM: u64 = 14;
pub(crate) const INT32: u64 = 5;
pub(crate) const INT64: u64 = 3;
pub(crate) const TEXT: u64 = STRING;
pub(crate) const BYTES: u64 = 12;
const SINT64: u64 = 18;

const fn type_of(kind: Kind) -> u64 {
    match kind {
        Kind::Number => DOUBLE,
        Kind::Count => UINT64,
        Kind::Integer => SINT64,
        Kind::Flag => BOOL,
        Kind::Text => STRING,
    }
}

const fn kind_of(type_: u64) -> Option<Kind> {
    Some(match type_ {
        DOUBLE => Kind::Number,
        UINT64 => Kind::Count,
        SINT64 => Kind::Integer,
        BOOL => Kind::Flag,
        STRING => Kind::Text,
        _ => return None,
    })
}

const fn message_name(group: Group) -> &'static str {
    match group {
        Group::Node => "Node",
        Group::Axis => "Axis",
        Group::FarNode => "FarNode",
        Group::FarAxis => "FarAxis",
        Group::VirtualAxis => "VirtualAxis",
        Group::Slave => "Slave",
        Group::Truth => "Truth",
    }
}

impl Schema {
    /// Makes the schema of an instance of a node of this role; `variant` distinguishes schemas with other
    /// signals that would have equal names.
    pub(crate) fn of(instance: &Instance, role: &str, variant: usize) -> Self {
        let package = format!("coaxle.{}", identifier(role));
        let mut message = message_name(instance.group).to_owned();
        if variant > 0 {
            // The first has no number, so that the usual case of one variant has the plain name.
            message += &(variant + 1).to_string();
        }
        let mut data = Vec::new();
        put_message(&mut data, 1, |file| {
            let path = format!("{}/{message}.proto", package.replace('.', "/"));
            put_bytes(file, 1, path.as_bytes());
            put_bytes(file, 2, package.as_bytes());
            put_message(file, 4, |out| put_signals(out, &message, instance.signals));
            put_message(file, 9, |out| put_meanings(out, instance.signals));
            // FileDescriptorProto: 1 name, 2 package, 4 message, 9 comments, 12 syntax.
            put_bytes(file, 12, b"proto3");
        });
        let name = format!("{package}.{message}");
        Self { name, data }
    }
}

/// Converts a text to a name in a schema: only letters and digits are kept.
fn identifier(text: &str) -> String {
    let is_fine = |c: char| c.is_ascii_alphanumeric();
    text.chars()
        .map(|c| if is_fine(c) { c } else { '_' })
        .collect()
}

/// Writes the signals as `optional` fields, so that unknown values differ from 0. In proto3 each of them
/// is followed by a `oneof` of its own.
fn put_signals(out: &mut Vec<u8>, name: &str, signals: &[Signal]) {
    put_bytes(out, 1, name.as_bytes());
    for (n, signal) in (0..).zip(signals) {
        put_message(out, 2, |field| {
            // Field numbers begin at 1; 0 is not permitted.
            put_field(field, n + 1, signal.name, type_of(signal.kind), None);
            // 9 is the index of its `oneof`, 17 marks it as `optional`: readers need both to report presence.
            put_count(field, 9, u64::from(n));
            put_count(field, 17, 1);
        });
    }
    for signal in signals {
        put_message(out, 8, |oneof| {
            put_bytes(oneof, 1, format!("_{}", signal.name).as_bytes());
        });
    }
}

/// Writes a field that is present at most once.
pub(crate) fn put_field(
    out: &mut Vec<u8>,
    number: u32,
    name: &str,
    type_: u64,
    type_name: Option<&str>,
) {
    put_bytes(out, 1, name.as_bytes());
    put_count(out, 3, u64::from(number));
    // FieldDescriptorProto: 3 number, 4 label (1 is at most once), 5 type, 6 name of the type.
    put_count(out, 4, 1);
    put_count(out, 5, type_);
    if let Some(type_name) = type_name {
        put_bytes(out, 6, type_name.as_bytes());
    }
}

/// Writes the meaning of each signal, as the comment of its field.
fn put_meanings(out: &mut Vec<u8>, signals: &[Signal]) {
    for (n, signal) in (0..).zip(signals) {
        put_message(out, 1, |location| {
            // The n-th field (2) of the first message (4).
            put_message(location, 1, |path| {
                for part in [4, 0, 2, n] {
                    put_varint(path, part);
                }
            });
            // A span is required, but there is no text to which it could refer.
            put_message(location, 2, |span| span.extend([0, 0, 0]));
            let meaning = match signal.unit {
                "" => format!(" {}\n", signal.meaning()),
                unit => format!(" {} [{unit}]\n", signal.meaning()),
            };
            put_bytes(location, 3, meaning.as_bytes());
        });
    }
}

/// Returns the fields of the message `name`, in the order of their numbers, in a schema of a file. Fields
/// of types that no signal has are left out.
pub(crate) fn fields_of(name: &str, data: &[u8]) -> Result<Vec<SchemaField>, InvalidMessage> {
    for file in inner(data, 1) {
        let file = file?;
        let package = text_in(file, 2)?.unwrap_or_default();
        for message in inner(file, 4) {
            let message = message?;
            let own = text_in(message, 1)?.unwrap_or_default();
            if [package, own].join(".") == name {
                return signals_of(message);
            }
        }
    }
    Err(InvalidMessage)
}

fn signals_of(message: &[u8]) -> Result<Vec<SchemaField>, InvalidMessage> {
    let mut fields = Vec::new();
    for field in inner(message, 2) {
        // The caller refuses one too many, so that no more are read.
        if fields.len() > MOST_SIGNALS {
            break;
        }
        let field = field?;
        let kind = count_in(field, 5)?.and_then(kind_of);
        let number = count_in(field, 3)?.and_then(|number| u32::try_from(number).ok());
        if let (Some(number), Some(name), Some(kind)) = (number, text_in(field, 1)?, kind) {
            let name = name.to_owned();
            fields.push(SchemaField { number, name, kind });
        }
    }
    // Sorted for the binary search of each value; descriptors may come in any order.
    fields.sort_by_key(|field| field.number);
    Ok(fields)
}

/// Returns the messages in the field with this number.
fn inner(message: &[u8], number: u32) -> impl Iterator<Item = Result<&[u8], InvalidMessage>> {
    MessageFields(message).filter_map(move |field| match field {
        Ok((n, WireValue::Bytes(bytes))) if n == number => Some(Ok(bytes)),
        Ok(_) => None,
        Err(error) => Some(Err(error)),
    })
}

fn text_in(message: &[u8], number: u32) -> Result<Option<&str>, InvalidMessage> {
    let bytes = inner(message, number).next().transpose()?;
    let text = bytes.map(|bytes| str::from_utf8(bytes).map_err(|_| InvalidMessage));
    text.transpose()
}

fn count_in(message: &[u8], number: u32) -> Result<Option<u64>, InvalidMessage> {
    for field in MessageFields(message) {
        if let (n, WireValue::Varint(count)) = field?
            && n == number
        {
            return Ok(Some(count));
        }
    }
    Ok(None)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::example::{BoilerSignals, ValveSignals};

    #[test]
    fn a_schema_says_the_fields_that_it_was_made_of() {
        for instance in [
            Instance::of::<BoilerSignals>(""),
            Instance::of::<ValveSignals>("a"),
        ] {
            let schema = Schema::of(&instance, "boiler room", 0);
            assert!(
                schema.name.starts_with("coaxle.boiler_room."),
                "{}",
                schema.name
            );
            let fields = fields_of(&schema.name, &schema.data).unwrap();
            assert_eq!(fields.len(), instance.signals.len());
            for ((n, field), signal) in (1..).zip(&fields).zip(instance.signals) {
                let expected = (n, signal.name, signal.kind);
                assert_eq!((field.number, field.name.as_str(), field.kind), expected);
            }
        }
    }

    #[test]
    fn a_schema_of_another_message_is_none_of_this_one() {
        let schema = Schema::of(&Instance::of::<BoilerSignals>(""), "boiler", 1);
        assert_eq!(schema.name, "coaxle.boiler.Node2");
        assert_eq!(
            fields_of("coaxle.boiler.Node", &schema.data),
            Err(InvalidMessage)
        );
    }
}
