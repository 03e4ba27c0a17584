//! Cases from public reports, and from trying the product: each with the right result, found by other means than this product,
//! beside the invariants of every run. Those in `tests/corpus/cases` may be run by hand, too, once the replays are written beside them.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use coaxle_lab::catalog;
use coaxle_lab::run::{self, Options};
use coaxle_lab::stage::VirtualTime;

const CASES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../corpus/cases");

/// Sources of the cases.
const FOLDERS: [&str; 4] = ["far-axis", "slaves", "cams", "field"];

#[test]
fn every_case_comes_to_what_is_right() {
    let mut wrong = Vec::new();
    for folder in FOLDERS {
        let scratch = tempfile::tempdir().expect("a scratch folder");
        let cases = gather(folder, scratch.path());
        for case in cases {
            let failed = run_case(&scratch.path().join(&case));
            wrong.extend(
                failed
                    .into_iter()
                    .map(|line| format!("{folder}/{case}: {line}")),
            );
        }
    }
    assert!(
        wrong.is_empty(),
        "{} wrong\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

/// Copies the cases of a folder beside the replays that they name, which it writes. Returns their names.
fn gather(folder: &str, to: &Path) -> Vec<String> {
    write_replays(to);
    let entries = fs::read_dir(Path::new(CASES).join(folder)).expect("the corpus");
    let mut names = Vec::new();
    for entry in entries {
        let path = entry.expect("the corpus").path();
        let name = path
            .file_name()
            .expect("a file")
            .to_string_lossy()
            .into_owned();
        fs::copy(&path, to.join(&name)).expect("the scratch folder");
        if path
            .extension()
            .is_some_and(|extension| extension == "toml")
        {
            names.push(name);
        }
    }
    // A folder is read in any order, and failures are to be listed alike on every machine.
    names.sort();
    names
}

/// Faults of a case, a line each.
fn run_case(path: &Path) -> Vec<String> {
    let out = path.with_extension("out");
    let options = Options {
        seed: None,
        overrides: Vec::new(),
        receivers: Vec::new(),
        out,
        trace: None,
    };
    let ran = || {
        let source = catalog::find(&path.to_string_lossy())?;
        let scenario = run::prepare(&source, &options)?;
        run::run(&source.name, &scenario, &options, &VirtualTime, &mut ())
    };
    match ran() {
        Ok(outcome) => outcome.summary.failed().map(ToString::to_string).collect(),
        Err(error) => vec![format!("{error:#}")],
    }
}

/// Masters whose motion is a formula, u and u/s by s, a row per millisecond.
fn write_replays(folder: &Path) {
    // 500 mm/s with 0.5 % of ripple at 5 Hz.
    let turns = std::f64::consts::TAU * 5.0;
    let ripple = |t: f64| {
        // The integral of the velocity 500 + 2.5·sin(ω·t), from 0: a row's velocity has to be the slope of its positions.
        let way = 500.0 * t + 2.5 / turns * (1.0 - (turns * t).cos());
        [way, 500.0 + 2.5 * (turns * t).sin()]
    };
    let jump = |t: f64| {
        // Ten seconds of travel ahead at once, and later more than fifteen back.
        let by = if t >= 6.0 { 5_000.0 } else { 0.0 } - if t >= 9.0 { 7_777.0 } else { 0.0 };
        [500.0 * t + by, 500.0]
    };
    write_replay(&folder.join("ripple.csv"), 40, ripple);
    write_replay(&folder.join("constant.csv"), 40, |t| [500.0 * t, 500.0]);
    write_replay(&folder.join("jump.csv"), 12, jump);
}

fn write_replay(path: &Path, seconds: u32, at: impl Fn(f64) -> [f64; 2]) {
    let mut text = "time_s,position,velocity\n".to_owned();
    for millis in 0..=seconds * 1_000 {
        let t = f64::from(millis) / 1_000.0;
        let [position, velocity] = at(t);
        // Nine decimals of millimetres: differences over a millisecond are exact to a millionth of 1 mm/s.
        writeln!(text, "{t:.4},{position:.9},{velocity:.9}").expect("a string takes it");
    }
    fs::write(path, text).expect("the scratch folder");
}
