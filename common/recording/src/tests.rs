//! Recordings written and read again, intact and damaged.

mod pieces;

use std::collections::BTreeMap;

use proptest::prelude::*;

use crate::example::{BoilerRow, BoilerSignals, boiler, row};
use crate::format::{BARE_INPUTS, TABLE};
use crate::protobuf::{MessageFields, WireValue};
use crate::{Facts, Item, Level, LogLine, Reader, Row, RowEncoder, Table, Value, Writer, recover};

/// Time between two rows of the example, ns.
const CYCLE_NS: i64 = 10_000_000;

/// Makes a recording of this number of rows, and its length after each flush.
fn recording(tables: &[Table], rows: u64) -> Vec<u8> {
    let facts = Facts::from([("scenario".to_owned(), "beat".to_owned())]);
    // An offset other than 0, which reading has to take off again.
    let mut writer = Writer::create(Vec::new(), tables, &facts, 1_000).unwrap();
    writer
        .attach("boiler.toml", "application/toml", b"name = 'b'")
        .unwrap();
    for (n, table) in tables.iter().enumerate() {
        let mut encoder = RowEncoder::of(table);
        for k in 0..rows {
            let at = k as i64 * CYCLE_NS;
            let encoded = encoder.encode(at, at + 7, &row(k)).unwrap();
            writer.row(n, &encoded).unwrap();
        }
        writer.log(n, &line(5)).unwrap();
        writer.status(n, 6, r#"{"health":"ok"}"#).unwrap();
    }
    writer.finish().unwrap()
}

#[test]
fn the_messages_of_every_kind_are_numbered_from_0() {
    let mut writer = Writer::create(Vec::new(), &[boiler()], &Facts::new(), 0).unwrap();
    let mut encoder = RowEncoder::of(&boiler());
    for k in 0..2 {
        let at = k as i64 * CYCLE_NS;
        let encoded = encoder.encode(at, at, &row(k)).unwrap();
        writer.row(0, &encoded).unwrap();
        writer.log(0, &line(at)).unwrap();
        writer.status(0, at, "{}").unwrap();
        writer.inputs(0, at, at, b"scan").unwrap();
    }
    let file = writer.finish().unwrap();
    let mut numbers = BTreeMap::<String, Vec<u32>>::new();
    for message in mcap::MessageStream::new(&file).unwrap() {
        let message = message.unwrap();
        let of_topic = numbers.entry(message.channel.topic.clone()).or_default();
        of_topic.push(message.sequence);
    }
    assert!(numbers.len() >= 4, "{numbers:?}");
    assert!(
        numbers.values().all(|of_topic| of_topic == &[0, 1]),
        "{numbers:?}"
    );
}

/// PlotJuggler before 3.17 throws at a channel without a schema, and no version looks at the presence of a field.
#[test]
fn every_channel_has_a_schema_and_an_unknown_number_is_a_gap() {
    let mut writer = Writer::create(Vec::new(), &[boiler()], &Facts::new(), 0).unwrap();
    let unknown = BoilerRow {
        node: BoilerSignals {
            temperature: None,
            ..row(0).node
        },
        ..row(0)
    };
    let encoded = RowEncoder::of(&boiler()).encode(0, 0, &unknown).unwrap();
    writer.row(0, &encoded).unwrap();
    writer.log(0, &line(0)).unwrap();
    writer.status(0, 0, "{}").unwrap();
    writer.inputs(0, 0, 7, b"scan").unwrap();
    writer.audit(0, 0, "{}").unwrap();
    let file = writer.finish().unwrap();
    let mut temperature = None;
    for message in mcap::MessageStream::new(&file).unwrap() {
        let message = message.unwrap();
        assert!(
            message.channel.schema.is_some(),
            "{}",
            message.channel.topic
        );
        if message.channel.topic == "boiler" {
            let first = MessageFields(&message.data).next();
            temperature = first.and_then(|first| match first {
                Ok((1, WireValue::Fixed64(bits))) => Some(f64::from_bits(bits)),
                _ => None,
            });
        }
    }
    assert!(temperature.is_some_and(f64::is_nan), "{temperature:?}");
    // Here it is unknown again.
    let (items, _) = read(&file);
    assert_eq!(rows(&items)[0].values, values(&unknown));
    let inputs = Item::Inputs {
        table: "boiler".to_owned(),
        at_ns: 0,
        woke_ns: 7,
        bytes: b"scan".to_vec(),
    };
    assert!(items.contains(&inputs));
}

#[test]
fn inputs_of_earlier_versions_are_read() {
    let mut writer = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    let metadata = BTreeMap::from([(TABLE.to_owned(), "boiler".to_owned())]);
    let channel = writer.add_channel(0, "boiler/inputs", BARE_INPUTS, &metadata);
    let header = mcap::records::MessageHeader {
        channel_id: channel.unwrap(),
        sequence: 0,
        log_time: 5,
        publish_time: 6,
    };
    writer.write_to_known_channel(&header, b"scan").unwrap();
    writer.finish().unwrap();
    let (items, damage) = read(writer.into_inner().get_ref());
    let inputs = Item::Inputs {
        table: "boiler".to_owned(),
        at_ns: 5,
        woke_ns: 6,
        bytes: b"scan".to_vec(),
    };
    assert_eq!((items, damage), (vec![inputs], 0));
}

fn line(at_ns: i64) -> LogLine {
    LogLine {
        at_ns,
        level: Level::Warning,
        name: "boiler".to_owned(),
        text: "cold".to_owned(),
    }
}

fn values(row: &BoilerRow) -> Vec<Option<Value>> {
    let word = |flame: &crate::example::Flame| match flame {
        crate::example::Flame::Off => Value::Text("off".to_owned()),
        crate::example::Flame::BurnsWell => Value::Text("burns-well".to_owned()),
    };
    let node = &row.node;
    let mut values = vec![
        node.temperature.map(Value::Number),
        Some(Value::Count(node.offs)),
        Some(word(&node.flame)),
    ];
    for valve in &row.valves {
        values.extend([
            Some(Value::Number(valve.position)),
            valve.steps.map(|steps| Value::Integer(steps.into())),
            valve.open.map(Value::Flag),
            valve.flame.as_ref().map(word),
        ]);
    }
    values
}

/// Returns the valid items, and number of damages reported.
fn read(file: &[u8]) -> (Vec<Item>, usize) {
    let mut damage = 0;
    let mut items = Vec::new();
    for item in Reader::new(file) {
        match item {
            Ok(item) => items.push(item),
            Err(_) => damage += 1,
        }
    }
    (items, damage)
}

fn rows(items: &[Item]) -> Vec<&Row> {
    let rows = items.iter().filter_map(|item| match item {
        Item::Row(row) => Some(row),
        _ => None,
    });
    rows.collect()
}

/// Checks that these are the first rows of the example, or some of them in their order.
fn assert_some_of_the_example(rows: &[&Row]) {
    let mut before = -1;
    for read in rows {
        assert!(read.at_ns > before, "{} after {before}", read.at_ns);
        before = read.at_ns;
        let expected = row((read.at_ns / CYCLE_NS) as u64);
        assert_eq!(read.values, values(&expected));
    }
}

#[test]
fn records_of_the_audit_have_a_channel_of_their_own() {
    let tables = ["boiler", "stove"].map(|name| Table {
        name: name.to_owned(),
        ..boiler()
    });
    let mut writer = Writer::create(Vec::new(), &tables, &Facts::new(), 1_000).unwrap();
    for (table, at_ns, json) in [
        (0, 5, "{\"number\":1}"),
        (1, 6, "{}"),
        (0, 7, "{\"number\":2}"),
    ] {
        writer.audit(table, at_ns, json).unwrap();
    }
    let (items, damage) = read(&writer.finish().unwrap());
    assert_eq!(damage, 0);
    let noted: Vec<_> = items
        .iter()
        .filter_map(|item| match item {
            Item::Audit { table, at_ns, json } => Some((table.as_str(), *at_ns, json.as_str())),
            _ => None,
        })
        .collect();
    let expected = [
        ("boiler", 5, "{\"number\":1}"),
        ("stove", 6, "{}"),
        ("boiler", 7, "{\"number\":2}"),
    ];
    assert_eq!(noted, expected);
}

#[test]
fn everything_comes_back() {
    let file = recording(&[boiler()], 60);
    let mut reader = Reader::new(file.as_slice());
    let items: Vec<_> = reader.by_ref().collect::<Result<_, _>>().unwrap();
    let Item::Facts(facts) = &items[0] else {
        panic!("{:?}", items[0])
    };
    assert_eq!(facts["scenario"], "beat");
    assert_eq!(facts["clock-offset-ns"], "1000");
    assert!(matches!(&items[1], Item::Attachment { name, data, .. }
        if name == "boiler.toml" && data == b"name = 'b'"));
    let rows = rows(&items);
    assert_eq!(rows.len(), 60);
    assert_eq!(rows[59].woke_ns, 59 * CYCLE_NS + 7);
    assert_some_of_the_example(&rows);
    assert!(items.contains(&Item::Log(line(5))));
    assert!(
        matches!(items.last(), Some(Item::Status { table, at_ns: 6, json })
        if table == "boiler" && json == r#"{"health":"ok"}"#)
    );
    let [table] = reader.tables() else { panic!() };
    let columns: Vec<_> = table.columns.iter().map(|c| c.name()).collect();
    let expected: Vec<_> = boiler()
        .instances
        .iter()
        .flat_map(|i| i.columns())
        .collect();
    assert_eq!(columns, expected);
    assert_eq!(
        (
            table.columns[0].unit.as_str(),
            table.columns[3].unit.as_str()
        ),
        ("°C", "u")
    );
    assert_eq!(reader.incomplete_rows(), 0);
}

#[test]
fn the_same_rows_give_the_same_bytes() {
    let tables = [
        boiler(),
        Table {
            name: "second".to_owned(),
            ..boiler()
        },
    ];
    assert!(recording(&tables, 60) == recording(&tables, 60));
}

#[test]
fn tables_are_told_apart_even_where_their_instances_have_the_same_names() {
    let second = Table {
        name: "second".to_owned(),
        ..boiler()
    };
    let (items, damage) = read(&recording(&[boiler(), second], 3));
    assert_eq!(damage, 0);
    let tables: Vec<_> = rows(&items).iter().map(|row| row.table).collect();
    assert_eq!(tables, [0, 0, 0, 1, 1, 1]);
}

#[test]
fn what_was_flushed_is_there_whatever_becomes_of_the_rest() {
    let whole = recording(&[boiler()], 100);
    let all = rows(&read(&whole).0).len();
    assert_eq!(all, 100);
    let mut kept = Vec::new();
    // Any place of a power cut; 7 is a compromise with the time that each takes.
    for end in (0..whole.len()).step_by(7) {
        let (items, damage) = read(&whole[..end]);
        let rows = rows(&items);
        assert_some_of_the_example(&rows);
        assert!(damage == 1 || rows.len() == all, "{end}: {damage}");
        kept.push(rows.len());
    }
    assert!(kept.is_sorted());
    // A piece every 250 ms: 25 rows, and the row with which this time is over.
    kept.dedup();
    assert_eq!(kept, [0, 26, 51, 76, 100]);
}

#[test]
fn what_is_recovered_is_finished_and_the_same() {
    let whole = recording(&[boiler()], 100);
    let broken = &whole[..whole.len() * 2 / 3];
    let mut finished = Vec::new();
    let recovered = recover(broken, &mut finished).unwrap();
    assert!(!recovered.was_whole());
    assert_eq!(recovered.lost, 0);
    let (items, damage) = read(&finished);
    assert_eq!(damage, 0);
    assert_eq!(items, read(broken).0);
    // A row is three messages: the boiler and two valves.
    let of_rows = 3 * rows(&items).len() as u64;
    assert!(of_rows >= 3 * 51 && recovered.messages == of_rows);
    let again = recover(finished.as_slice(), Vec::new()).unwrap();
    assert!(again.was_whole());
    // Other readers look for the summary.
    assert!(mcap::Summary::read(&finished).unwrap().is_some());
}

#[test]
fn of_a_damaged_piece_nothing_is_used_and_all_that_follows() {
    let mut file = recording(&[boiler()], 100);
    // Inside a compressed chunk, whose check sum then fails.
    let middle = file.len() / 2;
    file[middle] ^= 0xff;
    let (items, damage) = read(&file);
    let rows = rows(&items);
    assert_some_of_the_example(&rows);
    assert!(damage >= 1 && rows.len() < 100);
    assert_eq!(rows.last().unwrap().at_ns, 99 * CYCLE_NS);
}

#[test]
fn what_is_no_recording_is_said_to_be_none() {
    for bytes in [&b""[..], b"at_ns,woke_ns\n", &[0; 100]] {
        let errors: Vec<_> = Reader::new(bytes)
            .map(|item| item.unwrap_err().to_string())
            .collect();
        assert_eq!(
            errors,
            ["byte 0: received other bytes, expected those that an MCAP file begins with"]
        );
    }
}

proptest! {
    #[test]
    fn rows_of_any_values_come_back(
        temperature in proptest::option::of(any::<f64>()),
        offs: u64,
        position: f64,
        steps in proptest::option::of(any::<i32>()),
        open in proptest::option::of(any::<bool>()),
        // Before the wall clock's zero by the offset at most, since a file has no earlier time.
        at in -1_000_i64..1 << 60,
    ) {
        let mut row = row(1);
        row.node.temperature = temperature;
        row.node.offs = offs;
        row.valves[1].position = position;
        row.valves[1].steps = steps;
        row.valves[1].open = open;
        let mut encoder = RowEncoder::of(&boiler());
        let mut writer = Writer::create(Vec::new(), &[boiler()], &Facts::new(), 1_000).unwrap();
        writer.row(0, &encoder.encode(at, at, &row).unwrap()).unwrap();
        let (items, damage) = read(&writer.finish().unwrap());
        prop_assert_eq!(damage, 0);
        let read = rows(&items);
        prop_assert_eq!(read.len(), 1);
        prop_assert_eq!(read[0].at_ns, at);
        // As texts: NaN is not equal to itself.
        prop_assert_eq!(format!("{:?}", read[0].values), format!("{:?}", values(&row)));
    }

    #[test]
    fn broken_files_are_read_as_far_as_they_go(
        end in any::<prop::sample::Index>(),
        flips in proptest::collection::vec((any::<prop::sample::Index>(), 1_u8..), 0..6),
    ) {
        let mut file = recording(&[boiler()], 40);
        file.truncate(1 + end.index(file.len()));
        for (place, flip) in flips {
            let place = place.index(file.len());
            file[place] ^= flip;
        }
        let (items, _) = read(&file);
        let mut finished = Vec::new();
        let _ = recover(file.as_slice(), &mut finished).unwrap();
        let (again, damage) = read(&finished);
        prop_assert!(damage == 0 || damage <= items.len() + 2);
        // Damage never makes rows.
        prop_assert!(rows(&again).len() <= 40);
    }
}
