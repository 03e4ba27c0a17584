//! Programs in C and C++, compiled with all warnings as errors and with sanitizers, and run.
#![allow(missing_docs, clippy::print_stderr)]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use coaxle_clock::delay::TimeResponse;
use coaxle_clock::far_clock::{DelaySource, FarClock};
use coaxle_clock::observer::ObserverParameters;
use coaxle_clock::{CycleTime, Instant, Seconds, Span};
use coaxle_remote::{EncoderMaster, EncoderParameters, EncoderSample};
// Has the static library built.
use coaxle_c as _;

/// Strict C11.
const C: &[&str] = &["-std=c11", "-D_DEFAULT_SOURCE", "-x", "c"];
/// Strict C++17, whose compiler takes designated initialisers of C as an extension.
const CPP: &[&str] = &["-std=c++17", "-x", "c++"];
const WARNINGS: &[&str] = &["-Wall", "-Wextra", "-Werror", "-g", "-O1"];
const SANITIZERS: &[&str] = &["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];

fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The static library: Cargo leaves it beside the test.
fn library() -> PathBuf {
    let test = std::env::current_exe().expect("the test's own path");
    let folder = test.parent().expect("its folder");
    let library = folder.join("libcoaxle_c.a");
    assert!(library.exists(), "{} is missing", library.display());
    library
}

fn compiler(language: &[&str]) -> Command {
    let name = if language == CPP { "c++" } else { "cc" };
    let mut compiler = Command::new(
        std::env::var_os("CC")
            .filter(|_| language == C)
            .unwrap_or(name.into()),
    );
    compiler
        .args(language)
        .args(WARNINGS)
        .arg("-I")
        .arg(package().join("include"));
    compiler
}

/// Compiles a program; none where the machine has no such compiler.
fn compiled(language: &[&str], source: &str, folder: &Path) -> Option<PathBuf> {
    let program = folder.join("program");
    let build = |sanitizers: &[&str]| {
        let mut compiler = compiler(language);
        compiler
            .args(sanitizers)
            .arg(package().join(source))
            .args(["-x", "none"]);
        compiler
            .arg(library())
            .args(["-lm", "-lpthread", "-ldl", "-o"])
            .arg(&program);
        compiler.output()
    };
    let Ok(output) = build(SANITIZERS) else {
        eprintln!("not tested: there is no compiler for {language:?}");
        return None;
    };
    if !output.status.success() {
        // A wrong program is refused without them, too.
        let plain = build(&[]).expect("it ran before");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(plain.status.success(), "{source}:\n{said}");
        eprintln!("without sanitizers, which the compiler lacks: {said}");
    }
    Some(program)
}

/// Compiles and runs a program; its output if it has ended well.
fn run(language: &[&str], source: &str, arguments: &[&str]) -> Option<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let program = compiled(language, source, folder.path())?;
    let Output {
        status,
        stdout,
        stderr,
    } = Command::new(program)
        .args(arguments)
        .output()
        .expect("it runs");
    let (out, err) = (
        String::from_utf8_lossy(&stdout),
        String::from_utf8_lossy(&stderr),
    );
    assert!(status.success(), "{source}: {status}\n{out}{err}");
    Some(out.into_owned())
}

#[test]
fn mistakes_of_a_caller_are_named() {
    let _ = run(C, "tests/c/wrong.c", &[]);
}

#[test]
fn a_saw_of_a_loop_of_ones_own_cuts_where_it_should() {
    let Some(out) = run(C, "examples/saw.c", &["4"]) else {
        return;
    };
    assert!(out.contains("cut 4 at 4000.000000 mm"), "{out}");
    assert!(out.contains("refused: 0x"), "{out}");
}

#[test]
fn frames_go_both_ways_over_a_socket_of_ones_own() {
    let Some(out) = run(C, "examples/receiver.c", &[]) else {
        return;
    };
    assert!(out.starts_with("health ok"), "{out}");
}

#[test]
fn a_recording_is_followed_to_the_last_bit() {
    let data = package().join("../clock/data/arrivals");
    let folder = data.to_str().expect("UTF-8");
    for name in ["udp-idle", "udp-4-busy"] {
        let Some(out) = run(C, "examples/follow.c", &[folder, name]) else {
            return;
        };
        let expected = followed(&data, name);
        let sure = out.lines().filter(|line| !line.ends_with('-')).count();
        assert!(sure > 15_000, "{name}: {sure} cycles");
        for (line, expected) in out.lines().zip(expected.lines()) {
            assert_eq!(bits(line), expected, "{name}");
        }
        assert_eq!(out.lines().count(), expected.lines().count(), "{name}");
    }
}

#[test]
fn an_axis_of_another_pc_is_smooth_in_a_loop_of_ones_own() {
    let Some(out) = run(C, "examples/far_axis.c", &[]) else {
        return;
    };
    let figures = |way: &str| -> [f64; 2] {
        let line = out.lines().find(|line| line.starts_with(way));
        let words = line.unwrap_or_default().split_whitespace();
        let numbers: Vec<f64> = words.filter_map(|word| word.parse().ok()).collect();
        numbers
            .try_into()
            .unwrap_or_else(|_| panic!("{way}: {out}"))
    };
    let [received, now, later] = ["as received", "moved to now", "shown later"].map(figures);
    // A cycle is 0.6 mm: as received, the axis lags by up to one more than are lost, and jumps by its whole velocity at a beat.
    assert!(received[0] > 900.0 && received[1] > 500.0, "{out}");
    // A microsecond is 0.6 um; in a cycle the velocity changes by 2.5 mm/s at most.
    for [off, jump] in [now, later] {
        assert!(off < 10.0 && jump < 5.0, "{out}");
    }
}

#[test]
fn counts_of_an_encoder_are_a_master() {
    let Some(out) = run(C, "examples/encoder.c", &["3"]) else {
        return;
    };
    let parameters = EncoderParameters {
        increment: 0.01,
        ..EncoderParameters::default()
    };
    let checked = parameters.checked(Span::from_millis(1));
    let mut master = EncoderMaster::new(&checked.expect("good parameters"));
    for line in out.lines() {
        let numbers: Vec<&str> = line.split(' ').collect();
        let sample = EncoderSample::next(numbers[0].parse().expect("a count"));
        let set = master.update(Some(sample), Seconds::ZERO, 1).set;
        // 17 digits are exact.
        let received: Vec<f64> = numbers[1..]
            .iter()
            .filter_map(|of| of.parse().ok())
            .collect();
        assert_eq!(received, [set.position, set.velocity, set.acceleration]);
    }
    assert_eq!(out.lines().count(), 3_000);
}

#[test]
fn a_drive_is_reached_from_both_ends_of_its_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let memory = folder.path().join("drive");
    let _ = run(C, "tests/c/drive.c", &[memory.to_str().expect("UTF-8")]);
}

#[test]
fn the_header_is_one_of_cpp() {
    let _ = run(CPP, "tests/c/header.cpp", &[]);
}

/// A line of the program with its numbers as bits: 17 digits are exact.
fn bits(line: &str) -> String {
    let [now, far, numbers @ ..] = &line.split(' ').collect::<Vec<_>>()[..] else {
        panic!("{line}");
    };
    let bits = |word: &&str| format!("{:016x}", word.parse::<f64>().expect("a number").to_bits());
    let numbers: Vec<_> = numbers.iter().map(bits).collect();
    [&[(*now).to_owned(), (*far).to_owned()], &numbers[..]]
        .concat()
        .join(" ")
}

/// Output of `examples/follow.c` as it should be, by the clock itself.
fn followed(data: &Path, name: &str) -> String {
    const CYCLE: i64 = 1_000_000;
    let messages = std::fs::read(data.join(format!("{name}.i32"))).expect("messages");
    let exchanges =
        std::fs::read_to_string(data.join(format!("{name}-exchanges.csv"))).expect("exchanges");
    let mut responses = (1..).zip(exchanges.lines().skip(1)).map(|(number, line)| {
        let times: Vec<i64> = line
            .split(',')
            .map(|word| word.parse().expect("a time"))
            .collect();
        let response = TimeResponse {
            run: 1,
            number,
            requested: Instant::from_nanos(times[0]),
            epoch: 1,
            received: Span::from_nanos(times[1]),
            responded: Span::from_nanos(times[2]),
        };
        (times[3], response)
    });
    let mut response = responses.next();
    let cycle_time = CycleTime::new(Span::from_nanos(CYCLE)).expect("a cycle time");
    let parameters = ObserverParameters::default();
    let mut clock =
        FarClock::new(cycle_time, parameters, DelaySource::Measured, 1).expect("a clock");
    let mut out = String::new();
    let mut last = None;
    for row in messages.chunks_exact(16) {
        let number =
            |n: usize| i32::from_le_bytes(row[4 * n..4 * n + 4].try_into().expect("four bytes"));
        let [count, stamp, way] = [0, 1, 2].map(|n| i64::from(number(n)));
        let arrived = count * CYCLE + stamp + way;
        let due = arrived / CYCLE * CYCLE + CYCLE / 2;
        let mut now = last.map_or(due, |last| last + CYCLE);
        while now < due {
            while let Some((at, taken)) = response.as_ref().filter(|(at, _)| *at <= now) {
                clock.response(Instant::from_nanos(*at), taken);
                response = responses.next();
            }
            let start = Instant::from_nanos(now);
            let output = *clock.cycle(start, |_, _| {});
            let _ = clock.request(start);
            match clock.far_time_at(start) {
                Some(far) if output.is_sure => {
                    let _ = writeln!(
                        out,
                        "{now} {} {:016x} {:016x} {:016x}",
                        far.time.instant.as_nanos(),
                        far.time.fraction_ns.to_bits(),
                        far.uncertainty.0.to_bits(),
                        output.observer.drift_ppm.to_bits()
                    );
                }
                _ => {
                    let _ = writeln!(out, "{now} -");
                }
            }
            last = Some(now);
            now += CYCLE;
        }
        if last.is_none() {
            last = Some(due - CYCLE);
        }
        clock.message(
            1,
            count as u64,
            Instant::from_nanos(arrived),
            Some(Span::from_nanos(stamp)),
        );
    }
    out
}
