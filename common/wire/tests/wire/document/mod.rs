//! `docs/WIRE.md` for tests, with a second implementation of its rules.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]
#![allow(dead_code, reason = "each test file takes what it needs")]

const DOCUMENT: &str = include_str!("../../../../../docs/WIRE.md");

/// Line of the example's table.
pub(crate) struct Row {
    pub(crate) offset: usize,
    pub(crate) bytes: Vec<u8>,
    pub(crate) type_name: &'static str,
    pub(crate) field: &'static str,
    pub(crate) value: &'static str,
}

pub(crate) fn section(heading: &str) -> &'static str {
    let (_, after) = DOCUMENT.split_once(heading).unwrap();
    after.split("\n## ").next().unwrap()
}

/// Returns the cells of each line of a table that begins with something in code.
pub(crate) fn table(heading: &str) -> Vec<Vec<&'static str>> {
    let (_, after) = section("\n## Commands\n").split_once(heading).unwrap();
    let lines = after.lines().skip_while(|line| !line.starts_with("| `"));
    lines
        .take_while(|line| line.starts_with("| `"))
        .map(|line| line.split('|').map(|cell| cell.trim().trim_matches('`')))
        .map(|cells| cells.skip(1).collect())
        .collect()
}

fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect()
}

/// Returns the bytes of the example under a heading.
pub(crate) fn example_dump(heading: &str) -> Vec<u8> {
    let (_, after) = section(heading).split_once("```hex").unwrap();
    hex(after.split("```").next().unwrap())
}

/// Returns the lines of its table.
pub(crate) fn example_rows(heading: &str) -> Vec<Row> {
    section(heading)
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

/// Reads a field's bytes by the document's rules, as the document writes values.
pub(crate) fn by_the_rules(type_name: &str, mut bytes: &[u8]) -> String {
    let rest = &mut bytes;
    let value = match type_name {
        "u8" => {
            let value = rest[0].to_string();
            *rest = &rest[1..];
            value
        }
        "u16" | "u32" | "u64" => varint(rest).to_string(),
        "i32" | "i64" => zigzag(rest).to_string(),
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

/// Computes CRC-32 bit by bit, straight from its definition.
pub(crate) fn crc32(bytes: &[u8]) -> u32 {
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

/// Checks that the table of an example covers its dump byte by byte, and that the rules give its values.
pub(crate) fn assert_consistent(heading: &str) {
    let mut covered = Vec::new();
    for row in example_rows(heading) {
        assert_eq!(row.offset, covered.len(), "{}", row.field);
        let value = by_the_rules(row.type_name, &row.bytes);
        assert_eq!(value, row.value, "{}", row.field);
        covered.extend(row.bytes);
    }
    assert_eq!(covered, example_dump(heading));
}
