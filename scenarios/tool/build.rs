//! Asks the linker to keep one of those functions whose code is the same: generic code is made by each crate that uses it.

use std::env;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Folds functions. Nothing here tells two functions apart by their addresses, which Rust never promises to be different.
const FOLD: &str = "-Wl,--icf=all";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=RUSTC_LINKER");
    // Others are not shipped: they are linked often, or their symbols are for a profiler.
    let is_release = env::var("PROFILE").is_ok_and(|profile| profile == "release")
        && env::var("DEBUG").is_ok_and(|debug| debug == "false");
    if is_release && folds().unwrap_or(false) {
        println!("cargo::rustc-link-arg-bins={FOLD}");
    }
}

/// Tries it: LLD folds, which is what Rust links with on x86-64 Linux; GNU's own linker refuses the argument.
fn folds() -> Option<bool> {
    let place = PathBuf::from(env::var_os("OUT_DIR")?).join("folded");
    let mut rustc = Command::new(env::var_os("RUSTC")?);
    rustc.args(["--crate-type", "bin", "--crate-name", "folded", "-"]);
    rustc.args(["--target", &env::var("TARGET").ok()?]);
    rustc
        .args(["-C", &format!("link-arg={FOLD}"), "-o"])
        .arg(place);
    if let Ok(linker) = env::var("RUSTC_LINKER") {
        rustc.args(["-C", &format!("linker={linker}")]);
    }
    let flags = env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    rustc.args(flags.split('\x1f').filter(|flag| !flag.is_empty()));
    rustc.stdin(Stdio::piped());
    let mut probe = rustc
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .ok()?;
    probe.stdin.take()?.write_all(b"fn main() {}").ok()?;
    Some(probe.wait().ok()?.success())
}
