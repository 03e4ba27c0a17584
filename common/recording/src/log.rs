//! Log lines in the format of `foxglove.Log`, for its viewers.

use crate::protobuf::{MessageFields, WireValue, put_bytes, put_count, put_message};
use crate::schema::{ENUM, FIXED32, INT32, INT64, MESSAGE, Schema, TEXT, put_field};

/// Severity of a line of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Information.
    Info,
    /// Condition to check.
    Warning,
    /// Failure.
    Error,
}

/// A line of the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// Time of writing, ns of the clock of the rows.
    pub at_ns: i64,
    /// Severity of the line.
    pub level: Level,
    /// Name of its node.
    pub name: String,
    /// Text of the line.
    pub text: String,
}

const LEVELS: [(&str, u64); 6] = [
    ("UNKNOWN", 0),
    ("DEBUG", 1),
    ("INFO", 2),
    ("WARNING", 3),
    ("ERROR", 4),
    ("FATAL", 5),
];

impl Level {
    const fn number(self) -> u64 {
        match self {
            Self::Info => 2,
            Self::Warning => 3,
            Self::Error => 4,
        }
    }

    const fn of(number: u64) -> Self {
        match number {
            // Other writers use all six levels of the schema; those without a counterpart go to the nearest one.
            0..=2 => Self::Info,
            3 => Self::Warning,
            _ => Self::Error,
        }
    }
}

const NANOS: u64 = 1_000_000_000;

/// Encodes the line as a message, with its time in the file.
pub(crate) fn encode(line: &LogLine, log_time: u64) -> Vec<u8> {
    let mut out = Vec::new();
    put_message(&mut out, 1, |timestamp| {
        // Field numbers are those of google/protobuf/timestamp.proto and of foxglove/Log.proto.
        put_count(timestamp, 1, log_time / NANOS);
        put_count(timestamp, 2, log_time % NANOS);
    });
    put_count(&mut out, 2, line.level.number());
    put_bytes(&mut out, 3, line.text.as_bytes());
    put_bytes(&mut out, 4, line.name.as_bytes());
    out
}

/// Decodes the line of a message; missing fields are empty.
pub(crate) fn decode(message: &[u8], at_ns: i64) -> LogLine {
    let mut line = LogLine {
        at_ns,
        level: Level::Info,
        name: String::new(),
        text: String::new(),
    };
    // A damaged rest loses its fields only: a line of the log is worth reading even in part.
    for field in MessageFields(message).map_while(Result::ok) {
        match field {
            (2, WireValue::Varint(level)) => line.level = Level::of(level),
            // Text of another program may be no UTF-8, and is still shown.
            (3, WireValue::Bytes(text)) => line.text = String::from_utf8_lossy(text).into_owned(),
            (4, WireValue::Bytes(name)) => line.name = String::from_utf8_lossy(name).into_owned(),
            _ => {}
        }
    }
    line
}

/// Returns the schema as published by Foxglove, preceded by its imports.
pub(crate) fn schema() -> Schema {
    let mut data = Vec::new();
    // FileDescriptorSet: field 1 is a file. An imported file has to come before the one that imports it.
    put_message(&mut data, 1, |file| {
        put_file(file, "google/protobuf/timestamp.proto", "google.protobuf");
        put_message(file, 4, |message| {
            put_bytes(message, 1, b"Timestamp");
            put_message(message, 2, |f| put_field(f, 1, "seconds", INT64, None));
            put_message(message, 2, |f| put_field(f, 2, "nanos", INT32, None));
        });
    });
    put_message(&mut data, 1, |file| {
        put_file(file, "foxglove/Log.proto", "foxglove");
        // FileDescriptorProto: 1 name, 2 package, 3 dependency, 4 message, 12 syntax.
        put_bytes(file, 3, b"google/protobuf/timestamp.proto");
        put_message(file, 4, put_log);
    });
    let name = "foxglove.Log".to_owned();
    Schema { name, data }
}

fn put_file(out: &mut Vec<u8>, name: &str, package: &str) {
    put_bytes(out, 1, name.as_bytes());
    put_bytes(out, 2, package.as_bytes());
    put_bytes(out, 12, b"proto3");
}

fn put_log(message: &mut Vec<u8>) {
    put_bytes(message, 1, b"Log");
    for (number, name, type_, type_name) in [
        (1, "timestamp", MESSAGE, Some(".google.protobuf.Timestamp")),
        (2, "level", ENUM, Some(".foxglove.Log.Level")),
        (3, "message", TEXT, None),
        (4, "name", TEXT, None),
        (5, "file", TEXT, None),
        (6, "line", FIXED32, None),
    ] {
        put_message(message, 2, |f| put_field(f, number, name, type_, type_name));
    }
    // DescriptorProto: 1 name, 2 field, 4 nested enum. An enum has 1 name and 2 value.
    put_message(message, 4, |levels| {
        put_bytes(levels, 1, b"Level");
        for (name, number) in LEVELS {
            put_message(levels, 2, |value| {
                put_bytes(value, 1, name.as_bytes());
                put_count(value, 2, number);
            });
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_comes_back() {
        for level in [Level::Info, Level::Warning, Level::Error] {
            let line = LogLine {
                at_ns: 7_500_000_000,
                level,
                name: "saw".to_owned(),
                text: "synchronised, drift +500 ppm".to_owned(),
            };
            assert_eq!(decode(&encode(&line, 7_500_000_000), line.at_ns), line);
        }
    }
}
