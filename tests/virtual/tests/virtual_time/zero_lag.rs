//! The delay measured by requests and responses, over seeds that nothing was tuned with.

use coaxle_clock::delay::DelayState;
use coaxle_lab::summary::ReceiverSummary;

use crate::common::{figures, run};

const SEEDS: std::ops::Range<u64> = 7_000..7_040;

/// A pair of numbers between 0 and 1 of its own for each seed.
fn shares(seed: u64) -> (f64, f64) {
    // 2⁶⁴/φ, as in Fibonacci hashing: the upper bits of successive multiples spread evenly.
    let mixed = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let share = |bits: u64| (bits & 0xFFFF) as f64 / 65_536.0;
    (share(mixed >> 48), share(mixed >> 24))
}

/// The receivers `measured` and `unequal` of a run with jitter, and a way back and forth for each, that
/// differ from seed to seed.
fn judged(seed: u64) -> [ReceiverSummary; 2] {
    let (a, b) = shares(seed);
    let sets = [
        format!("seed={seed}"),
        format!(
            "network.jitter={{ exponential-us = {:.1} }}",
            2.0 + 40.0 * a
        ),
        format!("sender.master.clock.drift-ppm={:.1}", 200.0 * b - 100.0),
        format!(
            "receiver.unequal.faults={{ latency-us = {:.0} }}",
            2_000.0 * a
        ),
        format!(
            "receiver.unequal.request-faults={{ latency-us = {:.0} }}",
            2_000.0 * b
        ),
        "duration-s=12".to_owned(),
        "expect=[]".to_owned(),
    ];
    let sets: Vec<_> = sets.iter().map(String::as_str).collect();
    let summary = run("zero-lag", &sets);
    ["measured", "unequal"].map(|name| figures(&summary, name).clone())
}

#[test]
fn equal_ways_leave_five_microseconds_of_travel_and_the_uncertainty_covers_any_ways() {
    let mut covered = 0;
    for seed in SEEDS {
        let judged = judged(seed);
        for receiver in &judged {
            assert_eq!(
                receiver.last.far.delay_state,
                Some(DelayState::Measured),
                "{seed}"
            );
            assert_eq!(receiver.last.far.responses_refused, 0, "{seed}");
            covered += u64::from(receiver.delay_covered_share == Some(1.0));
        }
        let worst = judged[0].lag_error_max_us.expect("judged");
        // 2.5 µm at 500 mm/s.
        assert!(worst <= 5.0, "{seed}: {worst} µs of travel");
    }
    let runs = 2 * (SEEDS.end - SEEDS.start);
    // A run counts only if every cycle of it is covered, so that a single excursion costs the whole run.
    assert!(covered * 100 >= runs * 95, "{covered} of {runs}");
}

#[test]
fn a_longer_path_moves_nothing_and_a_restarted_sender_is_asked_anew() {
    let steps =
        "receiver.measured.faults={ latency-us = 1000, delay-steps = [{ at-s = 6, by-us = 400 }] }";
    let restart = "event=[{ at-s = 14, node = \"master\", action = \"restart\", for-s = 0.5 }]";
    let sets = [steps, restart, "duration-s=22", "expect=[]"];
    let summary = run("zero-lag", &sets);
    let measured = figures(&summary, "measured");
    assert_eq!(measured.last.far.restarts, 1);
    assert!(measured.last.far.shifts >= 1);
    let delay = measured.last.far.delay_us.expect("measured again");
    // 1000 + 400 µs: latency and step, asked again by the run after the restart.
    assert!((delay - 1_400.0).abs() < 5.0, "{delay}");
    // Before a jump is noticed the line is pulled a little.
    let worst = measured.lag_error_max_us.expect("judged");
    assert!(worst <= 30.0, "{worst}");
}
