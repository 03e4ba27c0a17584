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
    check_with(file, &[])
}

fn check_with(file: &Path, options: &[&str]) -> Result<(), String> {
    let line = ["sender".as_ref(), file.as_os_str(), "--check".as_ref()];
    let options = options.iter().map(std::ffi::OsStr::new);
    let cli = Cli::try_parse_from(line.into_iter().chain(options));
    let ended = run(&cli.expect("valid arguments").args);
    ended.map(|_| ()).map_err(|error| format!("{error:#}"))
}

fn written(folder: &Path, text: &str) -> PathBuf {
    let file = folder.join("s.toml");
    std::fs::write(&file, text).expect("the folder can be written");
    file
}

#[test]
fn every_config_that_is_shipped_is_valid_and_only_experiments_need_lab() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let files: Vec<_> = std::fs::read_dir(folder).unwrap().collect();
    assert!(files.len() >= 2);
    for file in files {
        let file = file.unwrap();
        // By convention, files with a `[lab]` table begin so.
        let is_experiment = file.file_name().to_string_lossy().starts_with("lab-");
        let without = check(&file.path());
        assert_eq!(without.is_err(), is_experiment, "{without:?}");
        assert_eq!(check_with(&file.path(), &["--lab"]), Ok(()));
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
        // Once: an error is not repeated by each level that it passes.
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

#[test]
fn a_lab_table_is_refused_without_lab_and_says_what_is_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let machine = "name = 's'\ncycle-time-us = 1000\naxis = [{ id = 1, name = 'a', program = { limits = \
                   { velocity = 1, acceleration = 1, jerk = 1 } } }]\n";
    let file = written(
        folder.path(),
        &format!("{machine}lab = {{ clock.drift-ppm = 500, seed = 7 }}"),
    );
    let refused = check(&file).unwrap_err();
    // Line 4 of the file, at the value behind `lab = `.
    let expected = "s.toml:4:7: lab: received lab.clock.drift-ppm = 500, lab.seed = 7, expected no [lab] table: no fault is \
                    injected into a machine; take the table out, or start the node with --lab for an experiment";
    assert!(refused.ends_with(expected), "{refused}");
    assert_eq!(check_with(&file, &["--lab"]), Ok(()));
    let file = written(folder.path(), machine);
    assert_eq!(
        (check(&file), check_with(&file, &["--lab"])),
        (Ok(()), Ok(()))
    );
}

#[test]
fn a_lab_table_keeps_a_node_from_starting() {
    let folder = tempfile::tempdir().unwrap();
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/lab-conveyor.toml");
    // It would be written before the first motion.
    let trace = folder.path().join("trace.csv");
    let cli = Cli::try_parse_from([
        "sender".as_ref(),
        config.as_os_str(),
        "--trace".as_ref(),
        trace.as_os_str(),
    ]);
    let error = run(&cli.unwrap().args).unwrap_err();
    assert!(
        format!("{error:#}").contains("lab.clock.drift-ppm = 500"),
        "{error:#}"
    );
    assert!(!trace.exists());
}
