//! Tests with both ends of the memory in one process.

use std::path::{Path, PathBuf};

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use coaxle_axis::drive::{Drive, DriveFault, DriveState, ProcessDriveParameters};
use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use proptest::prelude::*;

use super::layout::{FIELDS, SIZE};
use super::*;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

const PARAMETERS: ProcessDriveParameters = ProcessDriveParameters {
    // Small, so that the tests reach the limits within a few steps.
    max_silent_cycles: 5,
    switch_on_cycles: 50,
    following_error_window: 10.0,
    following_error_time: 0.0,
};

fn create(path: &std::path::Path) -> Result<SharedMemoryDrive, String> {
    let identity = DriveIdentity {
        run: 77,
        slave_id: 3,
        slave: "carriage",
        cycle_time: CycleTime::new(Span::from_millis(1)).expect("in range"),
    };
    SharedMemoryDrive::create(path, &identity, PARAMETERS).map_err(|error| error.to_string())
}

fn attach(path: &std::path::Path) -> Result<DriveProcess, String> {
    DriveProcess::attach(path).map_err(|error| error.to_string())
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn file(&self) -> PathBuf {
        self.0.path().join("drive")
    }
}

fn step(drive: &mut SharedMemoryDrive, position: f64) {
    let set = Kinematics {
        position,
        velocity: 2.0,
        acceleration: 3.0,
    };
    drive.step(&set, Seconds(1e-3));
}

/// A process whose drive is at its set position.
fn answer(process: &mut DriveProcess) {
    let set = process.set_values().expect("nobody writes just now");
    let values = if set.enable {
        ProcessValues::following(set.position, set.velocity)
    } else {
        ProcessValues::off(set.position)
    };
    process.answer(&values.of(&set));
}

#[test]
fn what_one_end_writes_the_other_reads() {
    let folder = Folder::new();
    let mut drive = create(&folder.file()).unwrap();
    let mut process = attach(&folder.file()).unwrap();
    assert_eq!(process.slave(), ("carriage".to_owned(), 3));
    assert_eq!(process.cycle_time(), Span::from_millis(1));
    step(&mut drive, 1.5);
    let set = process.set_values().unwrap();
    assert_eq!((set.counter, set.enable), (1, false));
    assert_eq!(
        (set.position, set.velocity, set.acceleration),
        (1.5, 2.0, 3.0)
    );
    // Within a minute: the instant is from the machine's clock at all, and not from another one.
    assert!((coaxle_os::machine::now() - set.ideal_start).abs() < Span::from_secs(60));

    drive.power_on(1.5, 0.0);
    for _ in 0..3 {
        answer(&mut process);
        step(&mut drive, 1.5);
    }
    assert!(process.set_values().unwrap().enable);
    answer(&mut process);
    step(&mut drive, 1.5);
    let actual = drive.actual();
    assert_eq!(
        (actual.state, actual.position),
        (DriveState::Following, 1.5)
    );
    assert!(actual.attachment.unwrap().attached);

    // The process detaches: the node trips after a few cycles.
    drop(process);
    for _ in 0..6 {
        step(&mut drive, 1.5);
    }
    // The sixth silent cycle is the first beyond `max_silent_cycles` of 5.
    let silent = DriveFault::Silent { cycles: 6, most: 5 };
    assert_eq!(drive.actual().fault, Some(silent));
}

#[test]
fn a_cycle_does_not_allocate() {
    let folder = Folder::new();
    let mut drive = create(&folder.file()).unwrap();
    let mut process = attach(&folder.file()).unwrap();
    drive.power_on(0.0, 0.0);
    let mut followed = 0;
    assert_no_alloc(|| {
        for k in 0..10_000 {
            // Nine tenths of the cycles are answered but for every seventh, which the limit of 5 silent cycles bears.
            step(&mut drive, f64::from(k) * 1e-3);
            // Sometimes the process is late, or gone.
            if k % 7 != 0 && k % 1_000 < 900 {
                answer(&mut process);
            }
            let actual = drive.actual();
            followed += u32::from(actual.state == DriveState::Following);
            if actual.state == DriveState::Tripped {
                drive.reset();
                drive.power_on(actual.position, 0.0);
            }
        }
    });
    assert!(followed > 8_000, "{followed}");
}

/// Leaves a file with the rights that a node gives it, whatever rights new files have here.
fn leave_behind(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).unwrap();
    let rights = std::os::unix::fs::PermissionsExt::from_mode(0o660);
    std::fs::set_permissions(path, rights).unwrap();
}

#[test]
fn the_file_is_removed_at_the_end_and_one_left_behind_is_taken_over() {
    let folder = Folder::new();
    let path = folder.file();
    let drive = create(&path).unwrap();
    let crashed = std::fs::read(&path).unwrap();
    assert_eq!(crashed.len(), SIZE);
    let mode = std::os::unix::fs::PermissionsExt::mode(&path.metadata().unwrap().permissions());
    assert_eq!(mode & 0o007, 0, "nothing for others: {mode:o}");
    let process = attach(&path).unwrap();
    drop(drive);
    assert!(!path.exists());
    assert!(!process.is_attached(), "it can see that the node has ended");
    assert_eq!(process.set_values(), None);
    drop(process);
    leave_behind(&path, &crashed);
    let mut drive = create(&path).unwrap();
    let mut process = attach(&path).unwrap();
    step(&mut drive, 0.0);
    answer(&mut process);
    drop(drive);
    // A file that another process has put there meanwhile must not be removed.
    let drive = create(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    std::fs::write(&path, "else").unwrap();
    drop(drive);
    assert_eq!(std::fs::read(&path).unwrap(), b"else");
}

#[test]
fn a_file_that_cannot_be_is_refused_with_what_was_found_and_expected() {
    let folder = Folder::new();
    let path = folder.file();
    let at = |text: &str| format!("{}: {text}", path.display());
    assert_eq!(
        attach(&path).unwrap_err(),
        at("is not there, expected the file of a running node: start the receiver first")
    );
    let drive = create(&path).unwrap();
    let other = create(&path).unwrap_err();
    let pid = std::process::id();
    assert!(other.starts_with(&at(&format!(
        "is used by another node (process {pid}), expected"
    ))));
    let bytes = std::fs::read(&path).unwrap();
    drop(drive);

    let with = |offset: usize, word: u64| {
        let mut bytes = bytes.clone();
        bytes[offset..offset + 8].copy_from_slice(&word.to_ne_bytes());
        bytes
    };
    for (found, expected) in [
        // Offsets of the layout: 24 is the run, 8 the version, 16 the size.
        (with(24, 0), "was left behind by a node that has ended"),
        (
            b"hello".to_vec(),
            "received a file that begins with \"hello\", expected \"COAXLEDR\"",
        ),
        (with(8, 2), "received layout version 2, expected 1"),
        (with(16, 400), "received 400 bytes, expected 384"),
        (bytes[..200].to_vec(), "received 200 bytes, expected 384"),
        (Vec::new(), "received a file that begins with \"\""),
    ] {
        leave_behind(&path, &found);
        let error = attach(&path).unwrap_err();
        assert!(error.starts_with(&at(expected)), "{error}");
        // A crashed node leaves a whole file, and a failed reservation an empty one: a node takes over both.
        let is_left_behind = expected.starts_with("was left") || found.is_empty();
        match create(&path) {
            Ok(_) => assert!(is_left_behind, "{expected}"),
            Err(error) => assert!(error.starts_with(&at(expected)), "{error}"),
        }
        let _ = std::fs::remove_file(&path);
    }
    std::fs::write(&path, &bytes).unwrap();
    let set_mode = |mode| {
        let mode = std::os::unix::fs::PermissionsExt::from_mode(mode);
        std::fs::set_permissions(&path, mode).unwrap();
    };
    // Whatever others may do: one who may only read can hold the node's lock.
    for mode in [0o666, 0o664, 0o662, 0o661, 0o604, 0o770] {
        set_mode(mode);
        let error = create(&path).unwrap_err();
        let expected = format!("received mode {mode:o}, expected 660 or less");
        assert!(error.starts_with(&at(&expected)), "{error}");
    }
    for mode in [0o660, 0o600, 0o640] {
        set_mode(mode);
        assert!(create(&path).is_ok(), "{mode:o}");
        std::fs::write(&path, &bytes).unwrap();
    }
    std::fs::remove_file(&path).unwrap();
    std::fs::create_dir(&path).unwrap();
    for error in [attach(&path).unwrap_err(), create(&path).unwrap_err()] {
        assert_eq!(
            error,
            at("received a folder, expected a regular file or none")
        );
    }
    let nowhere = folder.0.path().join("no/where");
    let error = create(&nowhere).unwrap_err();
    assert!(
        error.contains("cannot be opened for reading and writing: No such file"),
        "{error}"
    );
}

#[test]
fn what_the_document_says_of_the_bytes_is_so() {
    let document = include_str!("../../../docs/DRIVE.md");
    let rows = document.lines().filter_map(|line| {
        let mut cells = line.strip_prefix("| ")?.split(" | ");
        let (offset, kind, name) = (cells.next()?, cells.next()?, cells.next()?);
        let offset = offset.parse::<usize>().ok()?;
        Some((name.trim_matches('`').to_owned(), offset, kind.to_owned()))
    });
    let told: Vec<_> = rows.collect();
    let fields: Vec<_> = FIELDS
        .iter()
        .map(|(name, offset, kind)| {
            let name = name.trim_end_matches("_FIELD").to_lowercase();
            (name, *offset, (*kind).to_owned())
        })
        .collect();
    assert_eq!(told, fields);
    assert!(
        FIELDS
            .iter()
            .all(|(_, offset, _)| offset % 8 == 0 && *offset < SIZE)
    );
    assert!(document.contains(&format!("{SIZE} bytes")));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Any bytes are rejected or, if they form a node's file, read as values.
    #[test]
    fn garbage_never_panics(
        garbage in proptest::collection::vec(any::<u8>(), 0..2 * SIZE),
        // Nothing, the magic, the version, the size, or the whole header is genuine.
        keep in prop_oneof![Just(0_usize), Just(8), Just(16), Just(24), Just(128)],
    ) {
        let folder = Folder::new();
        let path = folder.file();
        let mut drive = create(&path).unwrap();
        let mut bytes = garbage;
        let real = std::fs::read(&path).unwrap();
        let keep = keep.min(bytes.len());
        bytes[..keep].copy_from_slice(&real[..keep]);
        // Changed without the node's knowledge, too: both blocks hold any bytes.
        let length = bytes.len().min(SIZE);
        std::os::unix::fs::FileExt::write_all_at(
            &std::fs::OpenOptions::new().write(true).open(&path).unwrap(), &bytes[..length], 0,
        ).unwrap();
        drive.power_on(0.0, 0.0);
        // More cycles than `switch_on_cycles` of 50: every state of the drive is reached with garbage.
        for _ in 0..60 {
            step(&mut drive, 0.0);
        }
        let _ = drive.actual();
        if let Ok(process) = attach(&path) {
            let _ = (process.set_values(), process.slave(), process.cycle_time());
        }
        drop(drive);
        std::fs::write(&path, &bytes).unwrap();
        // With fewer than 24 bytes kept, the size in the header is garbage.
        if bytes.len() != SIZE || keep < 24 {
            prop_assert!(attach(&path).is_err());
        }
        let _ = create(&path);
    }
}
