//! Equal scenarios and seeds give equal runs, byte for byte.

use coaxle_lab::catalog;

const FILES: [&str; 4] = [
    "summary.json",
    "trace.csv",
    "report.html",
    "nodes/sync-arrivals.csv",
];

fn files_of(name: &str, overrides: &[&str], seed: u64) -> Vec<Vec<u8>> {
    let out = tempfile::tempdir().expect("a scratch folder");
    let source = catalog::find(name).expect("a scenario of the catalogue");
    let _ = crate::common::run_into(&source, overrides, Some(seed), out.path());
    FILES
        .iter()
        .map(|file| std::fs::read(out.path().join(file)).expect("the run left the file"))
        .collect()
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    // All random faults at once: random walk of the drift, jitter of both ends, loss, repetition,
    // reordering, and a restart.
    let wandering = [
        "duration-s=8",
        "sender.master.clock.random-walk-ppm=5",
        "sender.master.clock.drift-ppm=2000",
        "receiver.sync.clock.jitter={ exponential-us = 30 }",
        "network.spikes={ share = 0.001, from-us = 500, to-us = 3000 }",
        "event=[{ at-s = 5, node = \"master\", action = \"restart\", for-s = 0.5 }]",
        "expect=[]",
    ];
    let first = files_of("loss", &wandering, 42);
    let second = files_of("loss", &wandering, 42);
    for (n, file) in FILES.iter().enumerate() {
        assert!(first[n] == second[n], "{file} differs");
        // Equal files prove nothing if they are empty.
        assert!(first[n].len() > 1_000, "{file} is empty");
    }
    let other = files_of("loss", &wandering, 43);
    // Otherwise a run that ignores its seed would pass, too.
    assert!(first[1] != other[1], "the seed has no effect");
}
