//! Accuracy of TS5066's method, in virtual time, against the master's true motion.

use coaxle_lab::sweep::{Options, Setup, prepare};
use coaxle_report::sweep;

use crate::common::{figures, run};

/// 1 ms cycles, constant velocity, no jitter.
const CLEAN: [(&str, f64); 2] = [("beat-sender-slow", -100.0), ("beat-sender-fast", 100.0)];

#[test]
fn without_correction_each_beat_is_a_spike_of_the_full_velocity() {
    for (scenario, _) in CLEAN {
        let summary = run(scenario, &[]);
        // A beat shows a frame twice or skips one: for a cycle the axis moves by no or by two ways, each off by the whole velocity.
        let ratio = figures(&summary, "bypass").velocity_ripple_ratio.unwrap();
        assert!((ratio - 1.0).abs() < 0.01, "{scenario}: {ratio}");
    }
}

#[test]
fn sync_mode_comes_after_its_beats_and_leaves_a_thousandth() {
    for (scenario, drift) in CLEAN {
        // A beat comes every 1 ms / 100 ppm = 10 s, so four of them are over after 40 of the 150 s.
        for periods in [1, 3] {
            let set =
                format!("receiver.sync.sync.time-sync.no-of-periods-for-mean-drift={periods}");
            let summary = run(scenario, &[&set, "duration-s=150", "expect=[]"]);
            let sync = figures(&summary, "sync");
            // The first beat only begins the first period.
            assert_eq!(sync.beats_at_sync, Some(periods + 1), "{scenario}");
            let estimate = sync.last.far.drift_ppm.unwrap();
            assert!((estimate / drift - 1.0).abs() < 0.01, "{estimate}");
            let truth = sync.drift_ppm_true.unwrap();
            assert!((truth / drift - 1.0).abs() < 1e-3, "{truth}");
            let ratio = sync.velocity_ripple_ratio.unwrap();
            assert!(ratio <= 1e-3, "{scenario}: {ratio}");
            assert_eq!(sync.synced_times, 1);
        }
    }
}

#[test]
fn even_slopes_follow_within_ten_microseconds() {
    for (scenario, _) in CLEAN {
        let summary = run(scenario, &[]);
        let worst = figures(&summary, "sync-even-slopes")
            .corrected_time_error_max_us
            .unwrap();
        assert!(worst <= 10.0, "{scenario}: {worst} µs");
    }
}

#[test]
fn jitter_and_loss_cost_neither_sync_nor_smoothness() {
    let noise = [
        "duration-s=300",
        "sender.master.clock.jitter={ normal-us = 5 }",
        "network.jitter={ exponential-us = 20 }",
        "network.loss=0.01",
        "expect=[]",
    ];
    for (scenario, _) in CLEAN {
        let summary = run(scenario, &noise);
        let sync = figures(&summary, "sync");
        assert_eq!((sync.synced_times, sync.errors), (1, 0), "{scenario}");
        assert!(sync.synced_at_end);
        let ratio = sync.velocity_ripple_ratio.unwrap();
        // A single frame that is taken as it came would be a spike of 1.
        assert!(ratio < 0.02, "{scenario}: a spike of {ratio}");
        // Expected are 300 s · 1000/s · 1 % = 3000 with a standard deviation of 54.
        assert!(sync.last.far.lost > 2_000);
    }
}

/// Seconds to sync, estimated drift and worst ripple over a grid, as one table to review.
#[test]
fn sweep_over_drift_and_jitter() {
    let mut table = String::from("drift ppm  jitter µs  sync s  estimate ppm  ripple ratio\n");
    for drift in [-500, -50, 50, 500] {
        for jitter in [0, 20, 100] {
            let drift_set = format!("sender.master.clock.drift-ppm={drift}");
            let jitter_set = format!("network.jitter={{ exponential-us = {jitter} }}");
            let summary = run(
                "beat-sender-fast",
                // A beat every 20 s at 50 ppm: six within the run, of which two give a drift.
                &[&drift_set, &jitter_set, "duration-s=120", "expect=[]"],
            );
            let sync = figures(&summary, "sync");
            table += &format!(
                "{drift:9}  {jitter:9}  {:6.1}  {:12.1}  {:12.4}\n",
                sync.time_to_sync_s.unwrap_or(f64::NAN),
                sync.last.far.drift_ppm.unwrap_or(f64::NAN),
                sync.velocity_ripple_ratio.unwrap_or(f64::NAN),
            );
        }
    }
    insta::assert_snapshot!(table);
}

/// Lock and accuracy of the phase observer over drift, jitter and loss, as one table to review.
#[test]
fn sweep_of_the_observer() {
    let source = coaxle_lab::catalog::find("observer-sweep").expect("a scenario of the catalogue");
    let prepared = prepare(&source, &Setup::default()).expect("the grid is right");
    let scratch = tempfile::tempdir().expect("a folder");
    let options = Options {
        out: scratch.path().to_owned(),
        ..Options::default()
    };
    let swept = sweep::run(&prepared, &options, "", &|_| true).expect("every point runs");
    assert!(swept.is_whole());
    insta::assert_snapshot!(swept.table);
}
