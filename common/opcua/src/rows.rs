//! Newest values of a node, from the pieces of its rows.

use coaxle_recording::{Item, ReadTable, Reader, Value};

/// Values of one cycle of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct CycleValues {
    /// Signals of the values.
    pub table: ReadTable,
    /// Ideal start of the cycle, ns since 1970 by the time of day of the node's PC.
    pub unix_ns: i64,
    /// Values of the columns; none for unknown ones.
    pub values: Vec<Option<Value>>,
}

/// Newest cycle in a piece; none of a piece that is malformed or has no row.
#[must_use]
pub fn newest_cycle(piece: &[u8]) -> Option<CycleValues> {
    let mut reader = Reader::new(piece);
    let (mut offset_ns, mut newest) = (0_i64, None);
    for item in reader.by_ref() {
        // A damaged piece is left out as a whole: the next one comes in 50 ms.
        match item.ok()? {
            Item::Facts(facts) => {
                let offset = facts.get("clock-offset-ns");
                offset_ns = offset.and_then(|ns| ns.parse().ok()).unwrap_or(offset_ns);
            }
            Item::Row(row) => newest = Some(row),
            _ => {}
        }
    }
    let row = newest?;
    Some(CycleValues {
        table: reader.tables().get(row.table)?.clone(),
        unix_ns: row.at_ns.saturating_add(offset_ns),
        values: row.values,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::signal::Instance;
    use coaxle_recording::{Facts, RowEncoder, Table, Writer};

    coaxle_node::signals! {
        /// A kettle.
        pub struct KettleSignals of Node {
            /// Temperature of the water.
            temperature: Option<f64> ["°C"],
        }
    }

    #[test]
    fn the_newest_row_counts_dated_by_the_time_of_day() {
        let table = Table {
            name: "kettle".to_owned(),
            role: "kettle".to_owned(),
            instances: vec![Instance::of::<KettleSignals>("")],
        };
        let mut encoder = RowEncoder::of(&table);
        let mut writer = Writer::create(Vec::new(), &[table], &Facts::new(), 1000).unwrap();
        for (at, temperature) in [(1, None), (2, Some(80.5))] {
            let row = KettleSignals { temperature };
            let row = encoder.encode(at, at, &row).unwrap();
            writer.row(0, &row).unwrap();
        }
        let piece = writer.finish().unwrap();
        let newest = newest_cycle(&piece).unwrap();
        assert_eq!(
            (newest.unix_ns, newest.table.columns[0].unit.as_str()),
            (1002, "°C")
        );
        assert_eq!(newest.values, [Some(Value::Number(80.5))]);
        assert_eq!(newest_cycle(b"nonsense"), None);
    }
}
