//! Mistakes of newcomers. Each ends the tool with one line: where it is, what was received, and what is expected or what
//! to do.

mod command_line;
mod good;
mod in_files;

use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Output};

use command_line::ON_THE_COMMAND_LINE;
use good::{CAM, RECEIVER, SAW, SCENARIO, SENDER};
use in_files::IN_FILES;

fn coaxle(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_coaxle"))
        .current_dir(folder)
        .env_remove("RUST_LOG")
        .args(arguments)
        .output()
        .expect("the tool runs")
}

/// A mistake in a file lasts until the file changes; other failures need not.
const WRONG_FILE: i32 = 78;
const WRONG_ARGUMENT: i32 = 2;
const FAILED: i32 = 1;

/// Lines of the tool that begin with "error: ", without that prefix. The tool must end with this code.
fn said(folder: &Path, arguments: &[&str], code: i32) -> Vec<String> {
    let output = coaxle(folder, arguments);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
    assert!(!text.contains("panicked"), "{text}");
    let lines = text.lines().filter_map(|line| line.strip_prefix("error: "));
    lines.map(str::to_owned).collect()
}

/// True if a line is the expected one, in which `…` stands for anything.
fn is(line: &str, expected: &str) -> bool {
    match expected.split_once('…') {
        Some((begin, end)) => line.starts_with(begin) && line.ends_with(end),
        None => line == expected,
    }
}

/// A file and how it is checked.
struct Kind {
    file: &'static str,
    good: &'static str,
    check: &'static [&'static str],
    /// Exit code of the tool with a mistake in it.
    code: i32,
}

const KINDS: [Kind; 5] = [
    Kind {
        file: "s.toml",
        good: SENDER,
        check: &["sender", "s.toml", "--check"],
        code: WRONG_FILE,
    },
    Kind {
        file: "r.toml",
        good: RECEIVER,
        check: &["receiver", "r.toml", "--check"],
        code: WRONG_FILE,
    },
    Kind {
        file: "x.toml",
        good: SCENARIO,
        check: &["run", "x.toml", "--out", "out"],
        code: WRONG_FILE,
    },
    Kind {
        file: "cam.toml",
        good: CAM,
        check: &["cam", "values", "cam.toml"],
        code: WRONG_FILE,
    },
    Kind {
        file: "saw.toml",
        good: SAW,
        check: &["saw", "plan", "saw.toml"],
        code: WRONG_FILE,
    },
];

#[test]
fn a_mistake_in_a_file_is_told_in_one_line() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let mut wrong = Vec::new();
    for (file, from, to, expected) in IN_FILES {
        let kind = KINDS
            .iter()
            .find(|kind| kind.file == *file)
            .expect("a kind");
        let changed = kind.good.replacen(from, to, 1);
        assert_ne!(changed, kind.good, "{from}");
        std::fs::write(folder.path().join(file), changed).expect("a file");
        let lines = said(folder.path(), kind.check, kind.code);
        if !matches!(&lines[..], [line] if is(line, expected)) {
            wrong.push(format!(
                "{file} with {to:?}:\n  {}\nnot\n  {expected}",
                lines.join("\n  ")
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_mistake_on_the_command_line_is_told_in_one_line() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    for kind in &KINDS {
        std::fs::write(folder.path().join(kind.file), kind.good).expect("a file");
    }
    std::fs::write(folder.path().join("binary.toml"), b"name = '\xff'\n").expect("a file");
    std::fs::write(folder.path().join("taken.mcap"), "").expect("a file");
    for (arguments, code, expected) in ON_THE_COMMAND_LINE {
        let arguments: Vec<_> = arguments.split(' ').collect();
        let lines = said(folder.path(), &arguments, *code);
        assert!(
            matches!(&lines[..], [line] if is(line, expected)),
            "{lines:#?}\nnot\n{expected}"
        );
    }
}

#[test]
fn what_the_mistakes_are_made_of_is_good() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    for kind in &KINDS {
        std::fs::write(folder.path().join(kind.file), kind.good).expect("a file");
        let output = coaxle(folder.path(), kind.check);
        assert!(output.status.success(), "{}: {output:?}", kind.file);
    }
}

#[test]
fn all_fields_that_are_missing_or_unknown_are_told_at_once() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let text = SENDER
        .replace("name = 'conveyor'\n", "")
        .replace("spin-us", "spni-us")
        .replace(", jerk = 10", "")
        .replace("acceleration = 10", "aceleration = 10");
    std::fs::write(folder.path().join("s.toml"), text).expect("a file");
    let lines = said(folder.path(), &["sender", "s.toml", "--check"], WRONG_FILE);
    let places: Vec<_> = lines
        .iter()
        .map(|line| line.splitn(3, ": ").take(2).collect::<Vec<_>>().join(" "))
        .collect();
    assert_eq!(
        places,
        [
            "s.toml name",
            "s.toml:5:1 real-time.spni-us",
            "s.toml:12:10 axis \"belt\".program.limits.jerk",
            "s.toml:12:27 axis \"belt\".program.limits.aceleration",
        ],
        "{lines:#?}"
    );
}

#[test]
fn a_port_that_is_in_use_is_named() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    std::fs::write(folder.path().join("s.toml"), SENDER).expect("a file");
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let endpoint = format!("tcp/{}", taken.local_addr().expect("its address"));
    let lines = said(
        folder.path(),
        &["sender", "s.toml", "--for", "1s", "--listen", &endpoint],
        FAILED,
    );
    let [line] = &lines[..] else {
        panic!("{lines:#?}");
    };
    assert!(
        line.contains(&endpoint)
            && line.contains("Address already in use")
            && line.contains("or listen on another port, such as --listen tcp/127.0.0.1:"),
        "{line}"
    );
}

#[test]
fn a_page_where_another_one_is_is_named() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    std::fs::write(folder.path().join("s.toml"), SENDER).expect("a file");
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = taken.local_addr().expect("its address").to_string();
    let lines = said(
        folder.path(),
        &["sender", "s.toml", "--for", "1s", "--page", &address],
        FAILED,
    );
    assert!(
        lines[0].contains(&address) && lines[0].ends_with("has that port: name another one"),
        "{lines:?}"
    );
}

#[test]
fn a_report_for_continuous_integration_says_what_cannot_be_run() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let text = SCENARIO.replace("duration-s = 1", "duration-s = -1");
    std::fs::write(folder.path().join("x.toml"), text).expect("a file");
    for command in ["run", "sweep"] {
        let lines = said(
            folder.path(),
            &[command, "x.toml", "--junit", "junit.xml"],
            WRONG_FILE,
        );
        assert!(lines[0].contains("received -1"), "{lines:?}");
        let path = folder.path().join("junit.xml");
        let report = std::fs::read_to_string(&path).expect("a report");
        assert!(
            report.contains("errors=\"1\"") && report.contains("received -1"),
            "{report}"
        );
        std::fs::remove_file(path).expect("it was there");
    }
}

#[test]
fn a_file_of_another_kind_is_named_with_the_command_for_it() {
    let names = [
        ("the config of a sender", "coaxle sender"),
        ("the config of a receiver", "coaxle receiver"),
        ("a scenario", "coaxle run"),
        ("a cam file", "coaxle cam check"),
        ("a saw file", "coaxle saw plan"),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    for (expected, (words, _)) in KINDS.iter().zip(names) {
        for (received, (name, command)) in KINDS.iter().zip(names) {
            if expected.file == received.file {
                continue;
            }
            let file = expected.file;
            std::fs::write(folder.path().join(file), received.good).expect("a file");
            let lines = said(folder.path(), expected.check, expected.code);
            let line = format!(
                "{file}: received {name}, expected {words}; for this one: {command} {file}"
            );
            assert_eq!(lines, [line], "{:?}", expected.check);
        }
    }
}
