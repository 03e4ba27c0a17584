//! Tables of rows, and the encoder of their messages.

use coaxle_node::signal::Instance;
use serde::Serialize;

use crate::encoded_row::{EncodedRow, RowError, Slot};
use crate::row_serializer::RowSerializer;

/// Table of a node, or of another source of one row at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// Name: the node's.
    pub name: String,
    /// Role: `sender`, `receiver`.
    pub role: String,
    /// Instances with signals, in the order of a row.
    pub instances: Vec<Instance>,
}

/// Encodes rows as messages.
#[derive(Clone, Debug)]
pub struct RowEncoder {
    slots: Vec<Slot>,
    columns: Vec<String>,
    /// Bytes of the longest row so far.
    bytes: usize,
}

impl RowEncoder {
    /// Makes an encoder for the rows of a table.
    #[must_use]
    pub fn of(table: &Table) -> Self {
        let slots = table.instances.iter().flat_map(|instance| {
            let count = instance.signals.len() as u32;
            // Numbers restart with each instance, which is a message of its own.
            (1..)
                .zip(instance.signals)
                .map(move |(number, signal)| Slot {
                    number,
                    kind: signal.kind,
                    is_last: number == count,
                })
        });
        Self {
            slots: slots.collect(),
            columns: table.instances.iter().flat_map(Instance::columns).collect(),
            bytes: 0,
        }
    }

    /// Encodes the row of a cycle that ideally began at `at_ns` and really at `woke_ns`, ns of any clock:
    /// a structure with the signals of the table as fields, in their order.
    ///
    /// # Errors
    /// [`RowError`] for other fields.
    pub fn encode(
        &mut self,
        at_ns: i64,
        woke_ns: i64,
        row: &impl Serialize,
    ) -> Result<EncodedRow, RowError> {
        let mut encoded = EncodedRow::new(at_ns, woke_ns, self.bytes);
        let mut serializer = RowSerializer::new(&self.slots, &self.columns, &mut encoded);
        row.serialize(&mut serializer)?;
        serializer.finish()?;
        self.bytes = self.bytes.max(encoded.length());
        Ok(encoded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::{boiler, row};

    #[test]
    fn a_row_has_a_message_per_instance() {
        let mut encoder = RowEncoder::of(&boiler());
        let encoded = encoder.encode(5, 6, &row(0)).unwrap();
        let lengths: Vec<_> = encoded.messages().map(<[u8]>::len).collect();
        // An unknown number is NaN, other unknown values take no bytes.
        assert_eq!(lengths, [9 + 2 + 5, 9 + 2 + 12, 9 + 2 + 2 + 12]);
    }

    #[test]
    fn what_is_no_row_of_the_table_is_refused_by_name() {
        let mut encoder = RowEncoder::of(&boiler());
        let mut said = |row: &dyn Fn(&mut RowEncoder) -> Result<EncodedRow, RowError>| {
            row(&mut encoder).unwrap_err().to_string()
        };
        let short = said(&|encoder| encoder.encode(0, 0, &(1.0, 2_u8)));
        assert_eq!(short, "received 2 values, expected 11");
        let long = said(&|encoder| encoder.encode(0, 0, &(row(0), 1.0)));
        assert_eq!(long, "received 12 values, expected 11");
        let kind = said(&|encoder| encoder.encode(0, 0, &(1.0, -2_i64)));
        assert_eq!(kind, "offs: received a integer, expected a count");
        let map = std::collections::BTreeMap::from([(1, 2)]);
        let map = said(&|encoder| encoder.encode(0, 0, &map));
        assert!(map.starts_with("received a map, expected"), "{map}");
    }
}
