//! The receiver's own program, killed while it records.

use std::fs::File;
use std::path::Path;
use std::process::Command;

use coaxle_recording::{FLUSH_PERIOD_NS, Item, Reader, Row, recover};
use coaxle_test_process::{Process, until};

/// More than two flush periods of cycles of 2 ms.
const ROWS: usize = 300;

const CONFIG: &str = "
name = 'saw'
cycle-time-us = 2000
master = { node = 'nobody' }
[transport]
connect = []
listen = ['tcp/127.0.0.1:0']
[[slave]]
name = 'carriage'
";

fn start(folder: &Path) -> Process {
    let config = folder.join("r.toml");
    std::fs::write(&config, CONFIG).expect("the folder can be written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-receiver"));
    command
        .arg(&config)
        .args(["--record".as_ref(), folder.join("saw.mcap").as_os_str()]);
    Process::start("saw", &mut command, &folder.join("log"))
}

/// The intact items of a recording, and the reported damage.
fn read(path: &Path) -> (Vec<Item>, Vec<String>) {
    let (mut items, mut wrong) = (Vec::new(), Vec::new());
    let Ok(file) = File::open(path) else {
        return (items, wrong);
    };
    for item in Reader::new(file) {
        match item {
            Ok(item) => items.push(item),
            Err(damage) => wrong.push(damage.to_string()),
        }
    }
    (items, wrong)
}

fn rows(items: &[Item]) -> Vec<&Row> {
    let rows = items.iter().filter_map(|item| match item {
        Item::Row(row) => Some(row),
        _ => None,
    });
    rows.collect()
}

#[test]
fn what_a_killed_node_had_flushed_is_kept_and_can_be_recovered() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("saw.mcap");
    let node = start(folder.path());
    let mut seen = 0;
    until("rows are written out", || {
        seen = rows(&read(&recording).0).len();
        seen > ROWS
    });
    node.kill();

    let (items, wrong) = read(&recording);
    let kept = rows(&items);
    // Another piece may be written between the last look and the end.
    assert!(kept.len() >= seen, "{} of {seen}", kept.len());
    // Nothing but its end is missing.
    assert!(matches!(wrong.as_slice(), [unfinished] if unfinished.contains("the file ends")));
    let is_config = |item: &Item| {
        matches!(item, Item::Attachment { name, data, .. }
            if name == "r.toml" && data == CONFIG.as_bytes())
    };
    assert!(items.iter().any(is_config));
    assert!(
        items
            .iter()
            .any(|item| matches!(item, Item::Status { table, json, .. }
        if table == "saw" && json.contains("\"recording_dropped\":0")))
    );
    // Written out in pieces of a quarter of a second, in the order of their cycles.
    let first_piece = kept
        .iter()
        .take_while(|row| row.at_ns - kept[0].at_ns < FLUSH_PERIOD_NS);
    // Several pieces, so that their order is judged too.
    assert!(first_piece.count() < kept.len());
    assert!(kept.is_sorted_by_key(|row| row.at_ns));

    let finished = folder.path().join("finished.mcap");
    let to = File::create(&finished).expect("the folder can be written");
    let recovered = recover(File::open(&recording).expect("it is there"), to);
    assert!(!recovered.expect("it can be written").was_whole());
    let (again, wrong) = read(&finished);
    assert_eq!(wrong, [""; 0]);
    // A recovery loses nothing that could be read.
    assert_eq!(again, items);
}

#[test]
fn a_node_that_is_ended_finishes_its_recording() {
    let folder = tempfile::tempdir().expect("a folder");
    let config = folder.path().join("r.toml");
    std::fs::write(&config, CONFIG).expect("the folder can be written");
    let recording = folder.path().join("saw.mcap");
    let ended = Command::new(env!("CARGO_BIN_EXE_coaxle-receiver"))
        .arg(&config)
        .args(["--for", "500ms", "--record"])
        .arg(&recording)
        .status();
    // The followed node does not exist: no data arrived.
    assert_eq!(ended.expect("the receiver starts").code(), Some(5));
    let (items, wrong) = read(&recording);
    assert_eq!(wrong, [""; 0]);
    assert!(!rows(&items).is_empty());
}
