//! Readers of files with little memory: of files that claim much, and of the largest ones, none ends by an allocation.

use crate::root;

use crate::{Bench, ToolEnd, program_memory, run_with};

/// Memory of a reader beside that of the program itself, KiB of addresses: 460 MiB.
const READER_MEMORY: u64 = 460 << 10;
const MIB: usize = 1 << 20;

/// A file of the repository.
pub(crate) fn shipped(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).expect("a shipped file")
}

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
// Opcodes of https://mcap.dev/spec.
const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const ATTACHMENT: u8 = 9;
const METADATA: u8 = 12;

/// A recording whose first record claims this length.
pub(crate) fn record_of(length: u64) -> Vec<u8> {
    [MAGIC, &[METADATA], &length.to_le_bytes()].concat()
}

fn record(opcode: u8, data: &[u8]) -> Vec<u8> {
    let length = (data.len() as u64).to_le_bytes();
    [&[opcode], &length[..], data].concat()
}

fn text(text: &str) -> Vec<u8> {
    claimed(text.len() as u32, text)
}

/// A text that claims this length.
fn claimed(length: u32, text: &str) -> Vec<u8> {
    [&length.to_le_bytes(), text.as_bytes()].concat()
}

/// A chunk without a check sum that claims this length.
fn chunk(records: &[u8], claimed: u64, compression: &str) -> Vec<u8> {
    let stored = records.len() as u64;
    let parts = [
        &[0; 16][..],
        &claimed.to_le_bytes(),
        &[0; 4],
        &text(compression),
        &stored.to_le_bytes(),
        records,
    ];
    record(CHUNK, &parts.concat())
}

/// Recordings that claim much, each with a part of what is said of it.
fn recordings() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let of = |records: &[Vec<u8>]| [MAGIC, &records.concat()].concat();
    let huge = claimed(0x7fff_ffff, "coaxle");
    let all = u32::MAX;
    let empty_message = record(MESSAGE, &[0; 22]);
    let messages = empty_message.repeat(63 * MIB / empty_message.len());
    let schemas: Vec<_> = (1..40_u16)
        .map(|id| {
            let parts = [
                &id.to_le_bytes()[..],
                &text("s"),
                &text("e"),
                &text(&"x".repeat(4 * MIB)),
            ];
            record(SCHEMA, &parts.concat())
        })
        .collect();
    vec![
        (
            "a text of 2 GiB in metadata",
            of(&[record(METADATA, &huge)]),
            "received a text of 2147483647 bytes, expected at most 6, the rest of its record",
        ),
        (
            "a text of 2 GiB in a schema",
            of(&[record(SCHEMA, &[&[1, 0], &huge[..]].concat())]),
            "received a text of 2147483647 bytes, expected at most 6",
        ),
        (
            "a list of texts of 4 GiB in a channel",
            of(&[record(
                CHANNEL,
                &[
                    &[1, 0, 0, 0],
                    &text("t")[..],
                    &text("e"),
                    &all.to_le_bytes(),
                ]
                .concat(),
            )]),
            "received a list of texts of 4294967295 bytes, expected at most 0",
        ),
        (
            "an attachment of 2^63 bytes",
            of(&[record(
                ATTACHMENT,
                &[
                    &[0; 16],
                    &text("n")[..],
                    &text("t"),
                    &(1_u64 << 63).to_le_bytes(),
                    &[0; 4],
                ]
                .concat(),
            )]),
            "received a file of 9223372036854775808 bytes, expected at most 4",
        ),
        (
            "a text of 2 GiB in a chunk",
            of(&[chunk(&record(METADATA, &huge), 9 + huge.len() as u64, "")]),
            "received a text of 2147483647 bytes, expected at most 6",
        ),
        (
            "a chunk of 2^62 bytes",
            of(&[chunk(&empty_message, 1 << 62, "zstd")]),
            "byte 8: ",
        ),
        (
            "a chunk of 64 MiB that is not there",
            of(&[chunk(&empty_message, 64 << 20, "lz4")]),
            "byte 8: ",
        ),
        (
            "a record of 64 MiB that is not there",
            record_of(64 << 20),
            "the file ends within a record",
        ),
        (
            "a chunk of small messages",
            of(&[chunk(&messages, messages.len() as u64, "")]),
            "",
        ),
        (
            "schemas of 156 MiB in all",
            of(&schemas),
            "received descriptions of more than 67108864 bytes",
        ),
        (
            "a long name in many columns",
            of(&long_name()),
            "received descriptions of more than 67108864 bytes",
        ),
    ]
}

/// A channel with a name of a MiB, and with ten thousand signals.
fn long_name() -> [Vec<u8>; 2] {
    // Fields of Protocol Buffers: number and kind in a byte, and a length.
    let bytes = |number: u8, content: &[u8]| {
        let mut length = content.len();
        let mut field = vec![number << 3 | 2];
        while length >= 0x80 {
            field.push(length as u8 | 0x80);
            length >>= 7;
        }
        field.push(length as u8);
        [&field, content].concat()
    };
    // Name, number and type (1: double) of a signal.
    let signal = bytes(
        2,
        &[&bytes(1, b"x")[..], &[3 << 3, 1], &[5 << 3, 1]].concat(),
    );
    let message = [bytes(1, b"m"), signal.repeat(10_000)].concat();
    let file = [bytes(2, b"p"), bytes(4, &message)].concat();
    let schema = bytes(1, &file);
    let length = (schema.len() as u32).to_le_bytes();
    let schema = [
        &[1, 0][..],
        &text("p.m"),
        &text("protobuf"),
        &length,
        &schema,
    ]
    .concat();
    let name = "n".repeat(MIB);
    let pairs = [
        ("table", "t"),
        ("role", "r"),
        ("instance", name.as_str()),
        ("place", "0"),
        ("instances", "1"),
    ];
    let pairs: Vec<u8> = pairs
        .iter()
        .flat_map(|(key, value)| [text(key), text(value)].concat())
        .collect();
    let length = (pairs.len() as u32).to_le_bytes();
    let channel = [
        &[1, 0, 1, 0][..],
        &text("t"),
        &text("protobuf"),
        &length,
        &pairs,
    ]
    .concat();
    [record(SCHEMA, &schema), record(CHANNEL, &channel)]
}

fn with_little_memory(words: &[&str]) -> Option<ToolEnd> {
    run_with(&[("-v", program_memory()? + READER_MEMORY)], words)
}

#[test]
fn recordings_that_claim_much_are_refused_in_little_memory() {
    let bench = Bench::new();
    for (what, bytes, says) in recordings() {
        let file = bench.file("r.mcap", bytes);
        for words in [
            &["info"][..],
            &["recover"],
            &["export", "csv"],
            &["export", "parquet"],
            &["replay"],
        ] {
            let Some(end) = with_little_memory(&[words, &[file.as_str()]].concat()) else {
                return;
            };
            end.has_not_crashed();
            // The replay has no receiver's config to begin with, and says that; columns are no matter of the recovery.
            let is_other = words == ["replay"] || words == ["recover"] && what.ends_with("columns");
            assert!(
                end.says(says) || is_other,
                "{what}: {words:?}: {}",
                end.text
            );
            let _ = std::fs::remove_file(bench.path("r-recovered.mcap"));
        }
        let axis =
            format!("[[axis]]\nid = 1\nname = 'a'\nreplay = {{ file = '{file}', axis = 'a' }}\n");
        let sender = bench.file(
            "s.toml",
            format!("name = 's'\ncycle-time-us = 1000\n{axis}"),
        );
        if let Some(end) = with_little_memory(&["sender", &sender, "--check"]) {
            end.is_refused("r.mcap");
        }
    }
}

/// The text, with as many copies of `element` as fit into this length.
fn full(head: &str, element: &str, tail: &str, bytes: usize) -> String {
    let copies = (bytes - head.len() - tail.len()) / element.len();
    format!("{head}{}{tail}", element.repeat(copies))
}

#[test]
fn the_longest_files_are_read_in_little_memory() {
    let bench = Bench::new();
    let nested = "[".repeat(400_000);
    let texts = [
        ("an array of empty arrays", full("x = [", "[],", "]\n", MIB)),
        ("tables without end", full("", "[[a]]\n", "", MIB)),
        ("inline tables", full("x = [", "{a=1},", "]\n", MIB)),
        ("a key of very many parts", full("a", ".a", " = 1\n", MIB)),
        ("brackets without end", format!("x = {nested}")),
        ("a text without end", full("x = '", "x", "", MIB)),
    ];
    for (what, text) in &texts {
        let file = bench.file("t.toml", text);
        for words in [
            &["sender", "FILE", "--check"][..],
            &["receiver", "FILE", "--check"],
            &["gateway", "FILE", "--check"],
            &["check", "FILE"],
            &["cam", "check", "FILE"],
            &["saw", "plan", "FILE"],
            &["gear", "plan", "FILE"],
            &["cam", "import", "FILE", "--format", "csv"],
            &["cam", "import", "FILE", "--format", "plc"],
        ] {
            let words: Vec<_> = words
                .iter()
                .map(|word| if *word == "FILE" { file.as_str() } else { word })
                .collect();
            let Some(end) = with_little_memory(&words) else {
                return;
            };
            assert!(!end.says("ok,"), "{what}: {}", end.text);
            end.has_not_crashed();
        }
    }
    let cam = full("", "[[point]]\nmaster=0\nslave=0\n", "", 4 * MIB);
    // Some 760 bytes of memory for a row.
    let rows = full("0,0\n", "1,1\n", "", 1_600_000);
    let array = "Cam : ARRAY[1..2000000000] OF MC_MotionFunctionPoint := [2000000000(( MasterPos := 1 ))];\n";
    let config = full(
        "name = 's'\ncycle-time-us = 1000\n",
        "[[axis]]\nid=1\nname='a'\n",
        "",
        MIB,
    );
    for (name, text, words) in [
        ("c.toml", cam.as_str(), &["cam", "check", "FILE"][..]),
        ("p.csv", &rows, &["cam", "import", "FILE"]),
        ("p.st", array, &["cam", "import", "FILE"]),
        ("s.toml", &config, &["sender", "FILE", "--check"]),
        (
            "a.csv",
            &rows,
            &["record-arrivals", "--out", "o", "--from", "FILE"],
        ),
    ] {
        let file = bench.file(name, text);
        let words: Vec<_> = words
            .iter()
            .map(|word| if *word == "FILE" { file.as_str() } else { word })
            .collect();
        if let Some(end) = with_little_memory(&words) {
            end.has_not_crashed();
        }
    }
    let large = bench.zeros("large.csv", (64 << 20) - 1);
    for words in [
        &["cam", "import"][..],
        &["record-arrivals", "--out", "o", "--from"],
    ] {
        if let Some(end) = with_little_memory(&[words, &[large.as_str()]].concat()) {
            end.is_refused("large.csv");
        }
    }
}
