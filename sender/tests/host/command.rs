//! The command line of the sender, without a network.

use std::path::{Path, PathBuf};

use clap::Parser;
use coaxle_sender::run::{Args, run};

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    args: Args,
}

fn check(file: &Path) -> Result<(), String> {
    let cli = Cli::try_parse_from(["sender".as_ref(), file.as_os_str(), "--check".as_ref()]);
    let ended = run(&cli.expect("valid arguments").args);
    ended.map(|_| ()).map_err(|error| format!("{error:#}"))
}

fn written(folder: &Path, text: &str) -> PathBuf {
    let file = folder.join("s.toml");
    std::fs::write(&file, text).expect("the folder can be written");
    file
}

#[test]
fn every_config_that_is_shipped_is_valid() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let files: Vec<_> = std::fs::read_dir(folder).unwrap().collect();
    assert!(!files.is_empty());
    for file in files {
        assert_eq!(check(&file.unwrap().path()), Ok(()));
    }
}

#[test]
fn a_check_finds_what_is_wrong_and_names_file_and_field() {
    let folder = tempfile::tempdir().unwrap();
    let head = "name = 's'\ncycle-time-us = 1000\n";
    let axis = "[[axis]]\nid = 1\nname = 'a'\nprogram = { limits = { velocity = 1, acceleration = \
                1, jerk = 1 } }\n";
    std::fs::write(folder.path().join("empty.csv"), "time_s,position\n").unwrap();
    for (text, expected) in [
        (
            head.replace("1000", "20") + axis,
            "cycle-time-us: received 20, expected 100 to 100000 µs",
        ),
        (
            format!("{head}show-axes = [3]\n{axis}"),
            "show-axes: received id 3, expected ids of the sender's axes: [1]",
        ),
        (
            format!("{head}transport = {{ connect = ['192.168.1.10'] }}\n{axis}"),
            "transport.connect: \"192.168.1.10\": is no endpoint",
        ),
        (
            format!("{head}[[axis]]\nid = 1\nname = 'taught'\nreplay = {{ file = 'no.csv' }}"),
            "axis \"taught\".replay.file: ",
        ),
        (
            format!("{head}[[axis]]\nid = 1\nname = 'empty'\nreplay = {{ file = 'empty.csv' }}"),
            "axis \"empty\".replay.file: ",
        ),
    ] {
        let file = written(folder.path(), text.as_str());
        let message = check(&file).unwrap_err();
        let place = format!("{}:", file.display());
        assert!(message.starts_with(&place), "{message}");
        assert_eq!(message.matches(expected).count(), 1, "{message}");
    }
    let good = written(folder.path(), &format!("{head}{axis}"));
    assert_eq!(check(&good), Ok(()));
    let missing = check(&folder.path().join("none.toml")).unwrap_err();
    assert!(missing.contains("none.toml: cannot be read"), "{missing}");
}

#[test]
fn a_trace_that_cannot_be_written_stops_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/conveyor.toml");
    let trace = folder.path().join("no/folder.csv");
    let cli = Cli::try_parse_from([
        "sender".as_ref(),
        config.as_os_str(),
        "--trace".as_ref(),
        trace.as_os_str(),
    ]);
    let error = run(&cli.unwrap().args).unwrap_err();
    assert!(format!("{error:#}").contains("no/folder.csv"), "{error:#}");
}
