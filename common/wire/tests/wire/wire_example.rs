//! `docs/WIRE.md` against the code: its worked example is read out of the very file, once by the
//! rules the document gives, written down again here, and once by the crate.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use crate::document;
use crate::document::{assert_consistent, crc32, section};
use coaxle_axis::{AxisState, CoupleState, NcToPlcAxis, StateWord};
use coaxle_clock::{CycleIndex, CycleTime, Span};
use coaxle_wire::Rejection;
use coaxle_wire::frame::{self, FrameHeader, body_capacity, encode_body, sender_id};
use coaxle_wire::keys::NodeName;

const KEY: &str = "coaxle/press/axes";
const EXAMPLE: &str = "## Worked example";

fn example_dump() -> Vec<u8> {
    document::example_dump(EXAMPLE)
}

fn documented_header() -> FrameHeader {
    FrameHeader {
        sender: sender_id(&NodeName::new("press").unwrap()),
        epoch: 0x0123_4567_89ab_cdef,
        index: CycleIndex(4_464),
        count: 70_000,
        cycle_time: CycleTime::new(Span::from_millis(2)).unwrap(),
        present_after: None,
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
fn the_table_covers_the_dump_and_the_rules_give_its_values() {
    assert_consistent(EXAMPLE);
    let rows = document::example_rows(EXAMPLE);
    assert_eq!(rows.len(), 7 + 25 + 2, "header, axis, stamp and check sum");
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
    let rows = document::example_rows(EXAMPLE);
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
