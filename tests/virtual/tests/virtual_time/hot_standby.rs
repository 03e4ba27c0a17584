//! A standby takes over when the node that is followed falls silent, and no sooner.

use crate::common::run;

/// Times at which the lines fall silent, s.
const SILENT: [f64; 2] = [10.0, 20.0];
/// Configured take-over timeout, s.
const TAKE_OVER_TIMEOUT: f64 = 0.05;

#[test]
fn a_standby_takes_over_in_time_and_its_slaves_keep_their_limits() {
    for seed in 1..4 {
        let summary = run("hot-standby", &[&format!("seed={seed}")]);
        for (name, receiver) in &summary.receivers {
            let times = &receiver.take_over_times_s;
            // The third event stops the line that stands by, which moves nothing.
            assert_eq!(times.len(), 2, "{name}: {times:?}");
            for (at, silent) in times.iter().zip(SILENT) {
                let after = at - silent;
                // The last message is less than 3 ms old when its node falls silent.
                let is_in_time =
                    (TAKE_OVER_TIMEOUT - 0.003..TAKE_OVER_TIMEOUT + 0.003).contains(&after);
                assert!(is_in_time, "{name}, seed {seed}: {after}");
            }
            for slave in receiver.slaves.values() {
                assert_eq!(slave.errors, 0, "{name}, seed {seed}");
                let shares = [
                    slave.velocity_share_max,
                    slave.acceleration_share_max,
                    slave.jerk_share_max,
                ];
                for share in shares {
                    assert!(
                        // Rounding of the third difference, 16ε·p/T³ with p = 20 m after 40 s, is 7e-7 of the jerk.
                        share.expect("it has limits") <= 1.0 + 1e-6,
                        "{name}: {shares:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn whatever_the_links_lose_the_slave_stays_coupled() {
    for loss in ["0.05", "0.2"] {
        let faults = [
            format!("network.loss={loss}"),
            "network.jitter.exponential-us=300".to_owned(),
        ];
        let faults: Vec<_> = faults.iter().map(String::as_str).collect();
        let summary = run("hot-standby", &faults);
        for (name, receiver) in &summary.receivers {
            // A false take-over needs 50 ms without a frame: 50 losses in a row, 0.2⁵⁰ ≈ 1e-35.
            assert_eq!(receiver.last.far.take_overs, 2, "{name} {loss}");
            assert!(receiver.slaves.values().all(|slave| slave.errors == 0));
        }
    }
}
