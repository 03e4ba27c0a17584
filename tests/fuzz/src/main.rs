//! Every target of hostile input in one program under libFuzzer; `FUZZ_TARGET` names the one that runs.
//!
//! With `FUZZ_SEEDS` set to a folder the program writes the corpus and the seeds of the target into it, and ends.
#![no_main]

use std::path::Path;
use std::sync::OnceLock;

use coaxle_test_hostile::mutate::Mutator;
use coaxle_test_hostile::{TARGETS, Target, trial};
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

/// The target of this process.
static CHOSEN: OnceLock<&'static Target> = OnceLock::new();

/// Reads the environment: libFuzzer takes every argument as a flag or a folder of its own.
fn begin() {
    let name = std::env::var("FUZZ_TARGET").unwrap_or_default();
    let Some(found) = TARGETS.iter().find(|target| target.name == name) else {
        let names: Vec<_> = TARGETS.iter().map(|target| target.name).collect();
        // For scripts, which run each of them.
        println!("{}", names.join("\n"));
        let is_list = name == "list";
        if !is_list {
            eprintln!("FUZZ_TARGET: received {name:?}, expected one of the above");
        }
        std::process::exit(i32::from(!is_list));
    };
    if let Ok(folder) = std::env::var("FUZZ_SEEDS") {
        for (name, data) in trial::inputs(found) {
            std::fs::write(Path::new(&folder).join(name), data).expect("a folder to write to");
        }
        std::process::exit(0);
    }
    CHOSEN.get_or_init(|| found);
}

fn chosen() -> &'static Target {
    CHOSEN.get().expect("a target, chosen at the start")
}

fuzz_target!(init: begin(), |data: &[u8]| {
    // A refusal is as good as any other outcome.
    let _ = chosen().examine(data);
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    // Every other time the library's own: it knows the operands of comparisons, and ours the words of the files.
    if seed % 2 == 0 {
        return fuzzer_mutate(data, size, max_size);
    }
    let mut mutator = Mutator::new(u64::from(seed), chosen().kind);
    let made = mutator.next(&[data[..size].to_vec()]);
    let length = made.len().min(max_size);
    data[..length].copy_from_slice(&made[..length]);
    length
});
