//! Files that cam plates within a config name.

use std::path::Path;

use coaxle_clock::Instant;
use coaxle_node::config::parse;
use coaxle_receiver::{Receiver, ReceiverConfig};

const POINTS: &str = "law,master,slave\npolynom5,0,0\npolynom5,180,40\n,360,0\n";

const TABLE: &str = "master,slave\n0,0\n180,40\n360,0\n";

/// A receiver whose plates, each written in its config, have their rows in files.
const CONFIG: &str = "
name = 'knife'
cycle-time-us = 1000
master = { node = 'belt' }
cams = [
  { table-id = 1, table = { csv = 'table.csv' } },
  { table-id = 2, points = { csv = 'points.csv' } },
  { table-id = 3, table = { rows = [[0, 0], [360, 40]] } },
]
[[slave]]
couple = 'off'
limits = { velocity = 1000, acceleration = 5000, jerk = 100000 }
cams = [{ table-id = 4, points = { csv = 'points.csv' } }]
[[slave.step]]
do = { cam-table-select = { table = 5, plate = { table = { csv = 'table.csv' } } } }
";

fn config_in(folder: &Path) -> ReceiverConfig {
    let mut config: ReceiverConfig = parse("receiver.toml", CONFIG).expect("a config");
    config.relative_to(folder);
    config
}

fn start(config: &ReceiverConfig) -> Result<(), String> {
    let receiver = Receiver::new(config, Instant::EPOCH, 1);
    receiver.map(drop).map_err(|error| error.to_string())
}

#[test]
fn they_are_found_from_the_config_wherever_it_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    for (file, text) in [("points.csv", POINTS), ("table.csv", TABLE)] {
        std::fs::write(folder.path().join(file), text).expect("a file");
    }
    let config = config_in(folder.path());
    assert_eq!(start(&config), Ok(()));
    // A copy of the config elsewhere finds them, too: paths are written as they were resolved.
    let written = toml::to_string(&config).expect("a text");
    let read: ReceiverConfig = parse("copy.toml", &written).expect("a config");
    assert_eq!(start(&read), Ok(()));
}

#[test]
fn a_missing_one_is_named_with_its_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let error = start(&config_in(folder.path())).expect_err("no file");
    let expected = folder.path().join("table.csv").display().to_string();
    assert!(error.starts_with("cams[0]: "), "{error}");
    assert!(error.contains(&expected), "{error}");
}
