//! The command line of the receiver, without a network.

use std::path::{Path, PathBuf};

use clap::Parser;
use coaxle_receiver::run::{Args, run};

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    args: Args,
}

fn check(file: &Path) -> Result<(), String> {
    check_with(file, &[])
}

fn check_with(file: &Path, options: &[&str]) -> Result<(), String> {
    let line = ["receiver".as_ref(), file.as_os_str(), "--check".as_ref()];
    let options = options.iter().map(std::ffi::OsStr::new);
    let cli = Cli::try_parse_from(line.into_iter().chain(options));
    let ended = run(&cli.expect("valid arguments").args);
    ended.map(|_| ()).map_err(|error| format!("{error:#}"))
}

fn written(folder: &Path, text: &str) -> PathBuf {
    let file = folder.join("r.toml");
    std::fs::write(&file, text).expect("the folder can be written");
    file
}

#[test]
fn every_config_that_is_shipped_is_valid_and_only_experiments_need_lab() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let files: Vec<_> = std::fs::read_dir(folder).unwrap().collect();
    // An empty folder would pass.
    assert!(files.len() >= 2);
    for file in files {
        let file = file.unwrap();
        let is_experiment = file.file_name().to_string_lossy().starts_with("lab-");
        let without = check(&file.path());
        assert_eq!(without.is_err(), is_experiment, "{without:?}");
        assert_eq!(check_with(&file.path(), &["--lab"]), Ok(()));
    }
}

#[test]
fn a_check_finds_what_is_wrong_and_names_file_and_field() {
    let folder = tempfile::tempdir().unwrap();
    let head = "name = 'r'\ncycle-time-us = 1000\nmaster = { node = 'm' }\n";
    for (rest, expected) in [
        (
            "sync.time-sync.force = true",
            "sync.time-sync.force: unknown field `force`",
        ),
        (
            "sync.time-sync.slope1-denominator = 1.0",
            "sync: 0x4b56: slope1-denominator is 1, expected above 0 and below 1",
        ),
        (
            "sync.time-sync.data-cycle-time-s = 0.0015",
            "sync: 0x4b56: data-cycle-time-s is 0.0015, expected 0, or a whole multiple",
        ),
        ("slave = [{ gear.ratio = 0.0 }]", "slave[0].gear: "),
        (
            "slave = [{ drive.max-velocity = -1.0 }]",
            "slave[0].drive: max-velocity is -1, expected a finite number of at least 0",
        ),
        (
            "transport.listen = ['tcp/0.0.0.0']",
            "transport.listen: \"tcp/0.0.0.0\": has no port",
        ),
        (
            "mode = 'magic'",
            "mode: received \"magic\", expected one of",
        ),
    ] {
        let file = written(folder.path(), &format!("{head}{rest}\n"));
        let message = check(&file).unwrap_err();
        let place = format!("{}:", file.display());
        assert!(message.starts_with(&place), "{message}");
        // The chain of causes does not repeat its text.
        assert_eq!(message.matches(expected).count(), 1, "{message}");
    }
    // The head is valid: each refusal is of the line below it.
    assert_eq!(check(&written(folder.path(), head)), Ok(()));
}

#[test]
fn a_lab_table_is_refused_without_lab_and_says_what_is_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let machine = "name = 'r'\ncycle-time-us = 1000\nmaster = { node = 'm' }\n";
    let lab = "[[lab.far]]\nnode = 'm'\nfaults.loss = 0.1\n[[lab.slave]]\nname = 'slave'\ntool.cuts-every = 360\n";
    let file = written(folder.path(), &format!("{machine}{lab}"));
    let refused = check(&file).unwrap_err();
    let expected = "lab: received lab.far \"m\".faults.loss = 0.1, lab.slave \"slave\".tool.cuts-every = 360, expected no [lab] table";
    assert!(refused.contains(expected), "{refused}");
    assert_eq!(check_with(&file, &["--lab"]), Ok(()));
}
