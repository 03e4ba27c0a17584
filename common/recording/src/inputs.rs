//! Inputs of a node before a scan, as messages with a schema.
//!
//! The bytes describe themselves to `coaxle replay` only. They have a schema nevertheless, as PlotJuggler before 3.17
//! reads nothing of a file with a channel without one.

use crate::format::{INPUTS_SCHEMA, SCAN_FIELD};
use crate::protobuf::{InvalidMessage, MessageFields, WireValue, put_bytes, put_message};
use crate::schema::{BYTES, Schema, put_field};

/// Returns the schema.
pub(crate) fn schema() -> Schema {
    let mut data = Vec::new();
    put_message(&mut data, 1, |file| {
        // FileDescriptorProto: 1 name, 2 package, 4 message, 12 syntax.
        put_bytes(file, 1, b"coaxle/Inputs.proto");
        put_bytes(file, 2, b"coaxle");
        put_message(file, 4, |message| {
            put_bytes(message, 1, b"Inputs");
            put_message(message, 2, |field| {
                put_field(field, SCAN_FIELD, "scan", BYTES, None);
            });
        });
        put_bytes(file, 12, b"proto3");
    });
    let name = INPUTS_SCHEMA.to_owned();
    Schema { name, data }
}

/// Writes the message of a scan.
pub(crate) fn put(out: &mut Vec<u8>, scan: &[u8]) {
    put_bytes(out, SCAN_FIELD, scan);
}

/// Returns the scan in a message; empty without one.
pub(crate) fn scan_in(message: &[u8]) -> Result<&[u8], InvalidMessage> {
    let mut scan = &[][..];
    for field in MessageFields(message) {
        if let (SCAN_FIELD, WireValue::Bytes(bytes)) = field? {
            scan = bytes;
        }
    }
    Ok(scan)
}
