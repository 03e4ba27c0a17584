//! What a far axis does, and what it says of itself: by its own positions, in every mode.

mod bench;

use bench::{Far, Nanos, Near, SECOND, run_pair};
use coaxle_receiver::HealthName;

const MODES: [&str; 5] = ["bypass", "pt1", "sync", "time", "observer"];

fn receiver(mode: &str) -> Near {
    let rest = format!(
        "mode = '{mode}'\nsync.time-sync = {{ automatic-re-init = true, age-of-data-limit = 500, \
         max-cycle-index-difference = 500 }}"
    );
    Near::new(1000, 0, &rest)
}

/// The far axis's own positions, and the velocities that it says.
fn corrected(near: &Near, from: Nanos) -> Vec<(f64, f64)> {
    let from = near.truths.partition_point(|at| *at < from);
    let shown = near.snapshots[from..].iter();
    let pair = |shown: &bench::Shown| {
        let master = shown.master?;
        Some((master.corrected.position, master.corrected.velocity))
    };
    shown.filter_map(pair).collect()
}

#[test]
fn a_pace_out_of_range_is_named_and_refused() {
    for mode in MODES {
        let mut far = Far::new(1000, -3_000, 0, 1);
        let mut near = receiver(mode);
        run_pair(&mut far, &mut near, 20 * SECOND);
        let last = near.last();
        assert_eq!(last.health.name(), HealthName::PaceOutOfRange, "{mode}");
        let pace = last.counters.pace_ppm.expect("measured");
        assert!((pace + 3_000.0).abs() < 20.0, "{mode}: {pace}");
        assert_eq!(
            (last.counters.error, last.axis.error),
            (0x4b56, 0x4b56),
            "{mode}"
        );
        let stale = last.counters.stale;
        assert_eq!(stale, 0, "{mode}");
        let standing = corrected(&near, 19 * SECOND);
        assert!(standing.iter().all(|at| *at == standing[0]), "{mode}");
    }
}
