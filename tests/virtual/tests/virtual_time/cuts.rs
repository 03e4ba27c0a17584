//! Pieces cut by a flying saw, over seeds that nothing was tuned with.

use crate::common::{figures, run};

const SEEDS: std::ops::Range<u64> = 3_000..3_020;

#[test]
fn pieces_are_cut_within_five_micrometres_whatever_the_clocks_do() {
    for seed in SEEDS {
        // Either clock is the faster one, and ways are shorter or longer.
        let drift = if seed % 2 == 0 { 100 } else { -100 };
        let sets = [
            format!("seed={seed}"),
            format!("sender.line.clock.drift-ppm={drift}"),
            format!(
                "receiver.observer.faults={{ latency-us = {} }}",
                200 + 100 * (seed % 20)
            ),
            "duration-s=30".to_owned(),
            "expect=[]".to_owned(),
        ];
        let sets: Vec<_> = sets.iter().map(String::as_str).collect();
        let summary = run("cut-to-length", &sets);
        let cuts = |receiver| figures(&summary, receiver).slaves["saw"].cuts.clone();
        let (bare, cured) = (cuts("bypass"), cuts("observer"));
        // A piece of 1000 mm takes 2 s at 500 mm/s: fifteen in 30 s, without those of the start.
        assert!(cured.cuts >= 13, "{seed}: {} cuts", cured.cuts);
        let off_length = 1e3 * cured.cut_length_error_max.expect("judged");
        // 10 µs of the far time at 500 mm/s.
        assert!(off_length <= 5.0, "{seed}: {off_length} µm");
        let off_mark = 1e3 * cured.cut_position_error_max.expect("judged");
        assert!(off_mark <= 5.0, "{seed}: {off_mark} µm");
        let off_length = 1e3 * bare.cut_length_error_max.expect("judged");
        // A beat moves the belt by a cycle, 0.5 mm, against 0.1 mm that the clocks drift apart within the 2 s of a piece.
        assert!(off_length >= 300.0, "{seed}: {off_length} µm");
    }
}
