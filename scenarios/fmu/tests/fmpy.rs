//! The units in FMPy: valid, equal to the run and to the slave axis to the last digit, and with a sentence for each mistake.
#![allow(missing_docs, clippy::print_stderr)]

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::Span;
// Has the library built.
use coaxle_fmi::{LIBRARY, Resources, UnitInstance, UnitPackage, UnitValue};
use coaxle_fmu as _;
use coaxle_lab::catalog;
use coaxle_lab::run::{self, Options, TraceFormat};
use coaxle_lab::stage::VirtualTime;
use coaxle_source::SourceAxis;

const STEPS: i64 = 6000;

fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn units() -> PathBuf {
    package().join("../fmi/examples")
}

/// An interpreter with FMPy; none where the machine has none, and the test that needs it tests nothing.
fn python() -> Option<PathBuf> {
    let wish = std::env::var_os("COAXLE_PYTHON").map(PathBuf::from);
    let own = package().join("../../target/python/bin/python3");
    let mut all = wish.into_iter().chain([own, PathBuf::from("python3")]);
    let found = all.find(|python| {
        let tried = Command::new(python).args(["-c", "import fmpy"]).output();
        tried.is_ok_and(|tried| tried.status.success())
    });
    if found.is_none() {
        eprintln!("not tested: FMPy is missing, see docs/FMI.md");
    }
    found
}

/// Runs a program; its output if it has ended well.
fn output(python: &Path, script: &Path, arguments: &[&Path]) -> String {
    let mut command = Command::new(python);
    let output = command
        .arg(script)
        .args(arguments)
        .output()
        .expect("it runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "{}: {out}{err}", script.display());
    out
}

fn write(resources: &Resources, path: &Path) {
    let test = std::env::current_exe().expect("the test's own path");
    let library = test.parent().expect("its folder").join(LIBRARY);
    let library =
        fs::read(&library).unwrap_or_else(|error| panic!("{}: {error}", library.display()));
    let unit = UnitPackage::new(resources, &library).expect("a unit");
    fs::write(path, unit.into_bytes()).expect("a file");
}

fn link() -> Resources {
    let text = fs::read_to_string(units().join("link.toml")).expect("the example");
    Resources::of_link("link.toml", &text)
}

fn saw() -> Resources {
    let path = package().join("../saws/cut-to-length.toml");
    let text = fs::read_to_string(path).expect("the saw");
    Resources::of_slave("cut-to-length.toml", &text, 1000).expect("a cycle time")
}

/// Leaves the trace of the scenario's run, and the motion of its master at the beginnings of the steps.
fn run_of_the_scenario(folder: &Path) {
    let path = units().join("link.toml");
    let source = catalog::find(&path.display().to_string()).expect("the example");
    let options = Options {
        seed: None,
        overrides: Vec::new(),
        receivers: Vec::new(),
        out: folder.to_owned(),
        trace: Some(TraceFormat::Csv),
    };
    let scenario = run::prepare(&source, &options).expect("a scenario");
    let result = run::run("link", &scenario, &options, &VirtualTime, &mut ()).expect("a run");
    assert!(
        result.summary.expectations.iter().all(|it| it.met),
        "{:?}",
        result.summary.expectations
    );
    let mut axis = SourceAxis::open(&scenario.senders[0].axes[0]).expect("a program");
    let mut shown = NcToPlcAxis::default();
    let mut rows = String::new();
    for step in 0..STEPS {
        let set = axis.at(Span::from_millis(step), &mut shown).seen;
        let _ = writeln!(
            rows,
            "{:?},{:?},{:?}",
            set.position, set.velocity, set.acceleration
        );
    }
    fs::write(folder.join("master.csv"), rows).expect("a file");
}

#[test]
fn a_link_is_the_run_of_its_scenario() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let (out, unit) = (folder.path().join("run"), folder.path().join("link.fmu"));
    run_of_the_scenario(&out);
    write(&link(), &unit);
    let (trace, master) = (out.join("trace.csv"), out.join("master.csv"));
    let script = units().join("link.py");
    // 200 ppm: now and then a step has two cycles of the receiver, of which the unit shows the second.
    let by_scenario = output(&python, &script, &[&unit, &trace]);
    assert!(equal_cycles(&by_scenario) >= 9990, "{by_scenario}");
    let by_inputs = output(&python, &script, &[&unit, &trace, &master]);
    assert!(equal_cycles(&by_inputs) >= 5990, "{by_inputs}");
}

/// The number in "6000 cycles with 187 signals each: equal".
fn equal_cycles(said: &str) -> u32 {
    let number = said.split(' ').next().and_then(|word| word.parse().ok());
    number.unwrap_or_default()
}

#[test]
fn a_saw_cuts_as_its_instance_in_rust() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let unit = folder.path().join("saw.fmu");
    write(&saw(), &unit);
    let script = units().join("saw.py");
    let cuts = output(&python, &script, &[&unit]);
    assert!(
        cuts.starts_with("cut 1 at 200.000 mm") && cuts.contains("cut 3 at 2200.000 mm"),
        "{cuts}"
    );
    let steps = output(&python, &script, &[&unit, Path::new("--csv")]);
    let mut own = UnitInstance::new(saw().model(Path::new("")).expect("a saw"));
    let set = |unit: &mut UnitInstance, name, value| {
        let reference = unit.reference(name).expect(name);
        unit.set(reference, value).expect(name);
    };
    own.enter_initialization(0.0).expect("it is new");
    own.exit_initialization().expect("it starts");
    // Up to the first cut, where the script releases the saw.
    for (n, line) in steps.lines().take(1500).enumerate() {
        let t = n as f64 * 0.001;
        let ramp = t.min(0.5);
        let acceleration = if t < 0.5 { 1000.0 } else { 0.0 };
        let position = -1000.0 + 500.0 * ramp * ramp + 500.0 * (t - ramp);
        set(&mut own, "master.position", UnitValue::Float64(position));
        set(
            &mut own,
            "master.velocity",
            UnitValue::Float64(1000.0 * ramp),
        );
        set(
            &mut own,
            "master.acceleration",
            UnitValue::Float64(acceleration),
        );
        set(&mut own, "command.execute", UnitValue::Boolean(n >= 600));
        own.step(t, 0.001).expect("a step");
        let mut words = line.split(' ').skip(1);
        for name in ["position", "velocity", "acceleration"] {
            let received = number_of_hex(words.next().expect("three numbers"));
            let expected = own.get(own.reference(name).expect(name)).expect(name);
            assert_eq!(&UnitValue::Float64(received), expected, "step {n}: {name}");
        }
    }
}

/// A number as Python writes all its digits: `-0x1.8p+3`.
fn number_of_hex(text: &str) -> f64 {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1.0, digits),
        None => (1.0, text),
    };
    let (mantissa, exponent) = digits[2..].split_once('p').expect("a power");
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let bits = u64::from_str_radix(&format!("{whole}{fraction}"), 16).expect("hex");
    let exponent: i32 = exponent.parse().expect("a number");
    sign * bits as f64 * 2.0_f64.powi(exponent - 4 * fraction.len() as i32)
}

#[test]
fn both_are_valid_and_each_mistake_has_its_sentence() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let (link_unit, saw_unit) = (
        folder.path().join("link.fmu"),
        folder.path().join("saw.fmu"),
    );
    write(&link(), &link_unit);
    write(&saw(), &saw_unit);
    let script = package().join("tests/python/mistakes.py");
    let said = output(&python, &script, &[&link_unit, &saw_unit]);
    assert_eq!(said, "each mistake has its sentence\n");
}
