//! `docs/WIRE.md` against the code: its worked example is read out of the very file, once by the
//! rules the document gives, written down again here, and once by the crate.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use coaxle_clock::{CycleIndex, CycleTime, Span};
use coaxle_motion::axis::{AxisState, CoupleState, NcToPlcAxis, StateWord};
use coaxle_node::Rejection;
use coaxle_node::frame::{self, FrameHeader, body_capacity, encode_body, sender_id};
use coaxle_node::keys::NodeName;

const DOCUMENT: &str = include_str!("../../../docs/WIRE.md");
const KEY: &str = "coaxle/press/axes";

/// One line of the example's table.
struct Row {
    offset: usize,
    bytes: Vec<u8>,
    type_name: &'static str,
    field: &'static str,
    value: &'static str,
}

fn section(heading: &str) -> &'static str {
    let (_, after) = DOCUMENT.split_once(heading).unwrap();
    after.split("\n## ").next().unwrap()
}

fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect()
}

fn example_dump() -> Vec<u8> {
    let (_, after) = section("## Worked example").split_once("```hex").unwrap();
    hex(after.split("```").next().unwrap())
}

fn example_rows() -> Vec<Row> {
    section("## Worked example")
        .lines()
        .filter_map(|line| {
            let cells: Vec<_> = line.split('|').map(str::trim).collect();
            let [_, offset, bytes, type_name, field, value, _] = cells[..] else {
                return None;
            };
            Some(Row {
                offset: offset.parse().ok()?,
                bytes: hex(bytes.trim_matches('`')),
                type_name,
                field,
                value,
            })
        })
        .collect()
}

fn varint(bytes: &mut &[u8]) -> u64 {
    let (mut number, mut shift) = (0, 0);
    loop {
        let (byte, rest) = bytes.split_first().unwrap();
        *bytes = rest;
        number |= u64::from(byte & 0x7f) << shift;
        shift += 7;
        if *byte < 0x80 {
            return number;
        }
    }
}

fn zigzag(bytes: &mut &[u8]) -> i64 {
    let z = varint(bytes);
    if z.is_multiple_of(2) {
        (z / 2) as i64
    } else {
        -((z / 2) as i64) - 1
    }
}

/// A field's bytes, read by the document's rules, as the document writes values.
fn by_the_rules(type_name: &str, mut bytes: &[u8]) -> String {
    let rest = &mut bytes;
    let value = match type_name {
        "u8" => {
            let value = rest[0].to_string();
            *rest = &rest[1..];
            value
        }
        "u16" | "u32" | "u64" => varint(rest).to_string(),
        "i32" => zigzag(rest).to_string(),
        "option i64" => {
            assert_eq!(rest[0], 1, "the example has a send stamp");
            *rest = &rest[1..];
            zigzag(rest).to_string()
        }
        "f64" => {
            let value = f64::from_le_bytes(rest[..8].try_into().unwrap());
            *rest = &rest[8..];
            format!("{value:?}")
        }
        "crc" => {
            let value = u32::from_le_bytes(rest[..4].try_into().unwrap());
            *rest = &rest[4..];
            format!("0x{value:08X}")
        }
        other => panic!("{other} is no type of the document"),
    };
    assert!(bytes.is_empty(), "{type_name} has bytes left over");
    value
}

/// CRC-32 bit by bit, straight from its definition.
fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = 0xFFFF_FFFF_u32;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            let reflected_polynomial = 0x04C1_1DB7_u32.reverse_bits();
            crc = (crc >> 1) ^ (reflected_polynomial * (crc & 1));
        }
    }
    !crc
}

fn documented_header() -> FrameHeader {
    FrameHeader {
        sender: sender_id(&NodeName::new("press").unwrap()),
        epoch: 0x0123_4567_89ab_cdef,
        index: CycleIndex(4_464),
        count: 70_000,
        cycle_time: CycleTime::new(Span::from_millis(2)).unwrap(),
        send_stamp: Some(Span::from_nanos(53_250)),
    }
}

fn documented_axis() -> NcToPlcAxis {
    NcToPlcAxis {
        state_word: StateWord::OPERATIONAL
            | StateWord::HOMED
            | StateWord::HAS_JOB
            | StateWord::POSITIVE_DIRECTION
            | StateWord::CONSTANT_VELOCITY
            | StateWord::CONTROL_LOOP_CLOSED,
        error_code: 17_217,
        axis_state: AxisState::ConstantVelocity,
        axis_mode: 1,
        calibration_state: 2,
        couple_state: CoupleState::Master,
        svb_entries: 4,
        saf_entries: 5,
        axis_id: 300,
        op_mode: 65_545,
        active_control_loop: 6,
        control_loop: 7,
        actual_position: 1234.5,
        modulo_actual_position: 154.5,
        modulo_actual_turns: 3,
        actual_velocity: 499.75,
        following_error: -0.125,
        set_position: 1234.375,
        set_velocity: 500.0,
        set_acceleration: -2.5,
        target_position: 2000.0,
        modulo_set_position: 154.375,
        modulo_set_turns: -3,
        command_number: 1_000,
        command_state: 8,
    }
}

#[test]
fn the_table_covers_the_dump_byte_by_byte() {
    let mut covered = Vec::new();
    for row in example_rows() {
        assert_eq!(row.offset, covered.len(), "{}", row.field);
        covered.extend(row.bytes);
    }
    assert_eq!(covered, example_dump());
}

#[test]
fn the_rules_of_the_document_give_the_values_of_the_table() {
    let rows = example_rows();
    assert_eq!(rows.len(), 7 + 25 + 2, "header, axis, stamp and check sum");
    for row in rows {
        let value = by_the_rules(row.type_name, &row.bytes);
        assert_eq!(value, row.value, "{}", row.field);
    }
}

#[test]
fn the_table_names_the_fields_of_an_axis_in_their_order() {
    let described = section("### An axis").lines().filter_map(|line| {
        let cells: Vec<_> = line.split('|').map(str::trim).collect();
        let [_, number, field, type_name, _, _] = cells[..] else {
            return None;
        };
        number.parse::<u32>().ok().map(|_| (field, type_name))
    });
    let rows = example_rows();
    let shown = rows[7..32].iter().map(|row| (row.field, row.type_name));
    assert!(shown.eq(described));
}

#[test]
fn the_crate_reads_the_documented_values() {
    let mut axes = Vec::new();
    let header = frame::decode(KEY, &example_dump(), |axis| axes.push(*axis));
    assert_eq!(header, Ok(documented_header()));
    assert_eq!(axes, [documented_axis()]);
}

#[test]
fn the_crate_writes_the_documented_bytes() {
    let header = documented_header();
    let mut body = vec![0; body_capacity(1)];
    let len = encode_body(&header, &[documented_axis()], &mut body).unwrap();
    let mut payload = Vec::new();
    frame::seal(KEY, &body[..len], header.send_stamp, &mut payload);
    assert_eq!(payload, example_dump());
}

#[test]
fn the_check_sum_is_the_one_that_is_defined() {
    assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    assert_eq!(crc32(b"press"), 0x7DC4_7CBD);
    let dump = example_dump();
    let (content, checksum) = dump.split_last_chunk().unwrap();
    let summed = [KEY.as_bytes(), content].concat();
    assert_eq!(crc32(&summed), u32::from_le_bytes(*checksum));
    for number in ["0xCBF43926", "0x7DC47CBD"] {
        assert!(section("## The check sum").contains(number));
    }
}

#[test]
fn every_reason_to_refuse_a_frame_is_described() {
    for reason in Rejection::ALL {
        let name = format!("`{}`", reason.name());
        assert!(
            section("## What a receiver refuses").contains(&name),
            "{name}"
        );
    }
}
