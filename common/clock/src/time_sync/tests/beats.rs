//! Beats, drift and corrections.

use super::*;
use std::vec::Vec;

#[test]
fn sync_comes_after_one_beat_more_than_periods_and_the_drift_is_right() {
    for drift in [100.0, -100.0, 500.0, -40.0] {
        for periods in [1, 3] {
            let far = Far::drifting(drift);
            let mut sync = started(TimeSyncParameters {
                no_of_periods_for_mean_drift: periods,
                ..defaults()
            });
            let (cycle, output) = cycle_of_sync(&mut sync, &far, 500_000).unwrap();
            assert_eq!(output.beats, u32::from(periods) + 1, "{drift} ppm");
            let beats = far.count(cycle) - far.count(0) - cycle;
            assert_eq!(beats.abs(), i64::from(periods) + 1);
            let estimate = output.diagnostic.drift_ppm;
            assert!((estimate / drift - 1.0).abs() < 1e-3, "{estimate} ppm");
        }
    }
}

#[test]
fn sync_begins_when_the_blending_after_its_beat_is_over() {
    // At 100 ppm the blending leads onto the ramp, at 500 ppm to the plateau: the ramp would be
    // outside the threshold.
    for drift in [100.0, 500.0] {
        let far = Far::drifting(drift);
        let mut sync = started(defaults());
        let second = (1..)
            .find(|cycle| far.count(*cycle) - far.count(0) - cycle == 2)
            .unwrap();
        let (cycle, output) = cycle_of_sync(&mut sync, &far, 100_000).unwrap();
        assert_eq!(cycle - second, 90 + 90);
        let correction = output.correction_time.unwrap().0 / CYCLE.as_secs_f64();
        let on_the_ramp = 1.9 * 180.0 * drift * 1e-6;
        let expected = if drift < 200.0 { on_the_ramp } else { 0.0 };
        assert!((correction - expected).abs() < 1e-3, "{correction}");
    }
}

#[test]
fn sync_waits_for_the_correction_to_be_inside_the_threshold() {
    let far = Far::drifting(500.0);
    let mut sync = started(defaults());
    let second = (1..)
        .find(|cycle| far.count(*cycle) - far.count(0) - cycle == 2)
        .unwrap();
    // The message of the cycle in which it would synchronise is lost: a whole cycle to correct.
    let due = second + 180;
    let states: Vec<_> = (0..due + 3)
        .map(|cycle| {
            let read = if cycle == due { cycle - 1 } else { cycle };
            sync.update(far.index(read), 1).state
        })
        .collect();
    let last = &states[states.len() - 3..];
    let expected = [
        TimeSyncState::StartUp,
        TimeSyncState::Synced,
        TimeSyncState::Synced,
    ];
    assert_eq!(last, expected);
}

#[test]
fn corrected_time_never_jumps_and_stays_within_half_a_cycle_of_a_constant() {
    for drift in [100.0, -100.0] {
        let far = Far::drifting(drift);
        let mut sync = started(defaults());
        let mut previous: Option<f64> = None;
        let mut errors = Vec::new();
        for cycle in 0..120_000 {
            let output = sync.update(far.index(cycle), 1);
            let corrected =
                far.count(cycle) as f64 + output.correction_time.unwrap().0 / CYCLE.as_secs_f64();
            if let Some(previous) = previous {
                let step = corrected - previous;
                // One cycle, and at most a whole one and the ramp so far more, blended over 90.
                assert!((step - 1.0).abs() < 1.07 / 90.0, "cycle {cycle}: {step}");
            }
            previous = Some(corrected);
            if output.state == TimeSyncState::Synced {
                errors.push(error_of(&far, cycle, &output, CYCLE.as_secs_f64()));
            }
        }
        let (low, high) = errors
            .iter()
            .fold((f64::MAX, f64::MIN), |(l, h), e| (l.min(*e), h.max(*e)));
        // The default slopes wander by 0.45 of a cycle by design.
        assert!((0.4..0.5).contains(&(high - low)), "{}", high - low);
    }
}

#[test]
fn even_slopes_are_exact_up_to_the_delay_of_detection() {
    for drift in [100.0, -100.0] {
        let far = Far::drifting(drift);
        let mut sync = started(TimeSyncParameters {
            slope1_numerator: 0.5,
            slope1_denominator: 0.5,
            ..defaults()
        });
        let mut synced = Vec::new();
        for cycle in 0..200_000 {
            let output = sync.update(far.index(cycle), 1);
            if output.state == TimeSyncState::Synced {
                synced.push(error_of(&far, cycle, &output, CYCLE.as_secs_f64()));
            }
        }
        // The blend into sync starts from a correction of up to 0.05 cycles.
        let mean = synced.iter().sum::<f64>() / synced.len() as f64;
        let settled = &synced[200..];
        let worst = settled.iter().map(|e| (e - mean).abs()).fold(0.0, f64::max);
        let detection = f64::from(defaults().end_of_transition_limit) * 100e-6;
        assert!(worst < 1.2 * detection, "{worst} of {detection} cycles");
    }
}

#[test]
fn time_mode_hides_a_beat_and_blends_it_away() {
    let far = Far::drifting(-500.0);
    let mut sync = started(TimeSyncParameters {
        force_time_mode: true,
        ..defaults()
    });
    let first = (1..)
        .find(|cycle| far.index(*cycle) == far.index(cycle - 1))
        .unwrap();
    let mut corrections = Vec::new();
    for cycle in 0..10_000 {
        let output = sync.update(far.index(cycle), 1);
        assert_eq!(output.state, TimeSyncState::StartUp, "forced");
        corrections.push(output.correction_time.unwrap().0 / CYCLE.as_secs_f64());
    }
    let at = |after: i64| corrections[usize::try_from(first + after).unwrap()];
    let close = |value: f64, to: f64| (value - to).abs() < 1e-9;
    assert!(close(at(-1), 0.0), "before the beat nothing is corrected");
    assert!(close(at(0), 1.0), "the cycle read twice is continued");
    assert!(close(at(91), 1.0), "up to its detection");
    assert!(close(at(91 + 45), 0.5), "then blended");
    assert!(close(at(91 + 90), 0.0), "away");
}

#[test]
fn a_beat_of_two_indices_counts_as_two_periods() {
    let mut sync = started(defaults());
    let mut index = 0_u16;
    let mut beats = 0;
    for cycle in 1..=3_000_u32 {
        index = index.wrapping_add(if cycle % 1_000 == 0 { 3 } else { 1 });
        let output = sync.update(CycleIndex(index), 1);
        beats = output.beats;
        if output.beats >= 4 {
            // Two indices gained in 1000 cycles: 2000 ppm.
            assert!((output.diagnostic.drift_ppm - 2000.0).abs() < 1e-9);
        }
    }
    assert_eq!(beats, 4, "the third is not detected yet");
}

#[test]
fn diagnostic_values_count_what_they_say() {
    let mut sync = started(defaults());
    let mut read = |index| sync.update(CycleIndex(index), 1).diagnostic;
    let _ = read(65_533);
    assert_eq!(read(65_534).cycle_index_diff, 1);
    assert_eq!(read(65_534).cycle_index_diff, 0);
    let twice = read(65_534);
    assert_eq!(
        (twice.consecutive_equal_data, twice.total_equal_data),
        (2, 2)
    );
    let missed = read(0);
    assert_eq!(missed.cycle_index_diff, 2, "over the wrap");
    assert_eq!(
        (missed.consecutive_equal_data, missed.total_equal_data),
        (0, 2)
    );
}

#[test]
fn the_wrap_of_the_index_is_not_noticed() {
    let mut near_wrap = Far::drifting(100.0);
    near_wrap.first_index = 65_000;
    let plain = Far::drifting(100.0);
    let mut a = started(defaults());
    let mut b = started(defaults());
    for cycle in 0..140_000 {
        let wrapping = a.update(near_wrap.index(cycle), 1);
        let other = b.update(plain.index(cycle), 1);
        assert_eq!(wrapping, other, "cycle {cycle}");
    }
}

#[test]
fn a_drift_that_changes_by_half_warns_and_a_steady_one_does_not() {
    let mut sync = started(defaults());
    let mut index = 0_u16;
    let mut warnings = Vec::new();
    let beats_at = [1_000, 2_000, 3_000, 4_400, 6_000, 6_400];
    for cycle in 1..7_000 {
        index = index.wrapping_add(if beats_at.contains(&cycle) { 2 } else { 1 });
        let output = sync.update(CycleIndex(index), 1);
        if output.warning.is_some() {
            warnings.push(cycle);
        }
    }
    assert_eq!(warnings.first(), Some(&(6_400 + 90)));
}

#[test]
fn the_delay_offset_is_added_and_does_not_hinder_sync() {
    let far = Far::drifting(200.0);
    let offset = Seconds(0.0005);
    let mut plain = started(defaults());
    let mut ahead = started(TimeSyncParameters {
        delay_time_offset: offset,
        ..defaults()
    });
    for cycle in 0..30_000 {
        let plain = plain.update(far.index(cycle), 1);
        let ahead = ahead.update(far.index(cycle), 1);
        assert_eq!(plain.state, ahead.state);
        let difference = ahead.correction_time.unwrap() - plain.correction_time.unwrap();
        assert!((difference.0 - offset.0).abs() < 1e-15);
    }
}

#[test]
fn both_ratios_of_cycle_times_synchronise() {
    // Sender cycle, receiver cycle, in ms; indices per receiver cycle follow.
    for (data, task, drift) in [
        (2, 1, 100.0),
        (2, 1, -100.0),
        (1, 4, 50.0),
        (1, 4, -50.0),
        (10, 1, 100.0),
    ] {
        let data_seconds = f64::from(data) * 1e-3;
        let ratio = f64::from(task) / f64::from(data);
        let far = Far {
            rate: ratio * (1.0 + drift * 1e-6),
            // The first cycle is one that brings new data.
            phase: 40.02,
            first_index: 0,
        };
        let parameters = TimeSyncParameters {
            data_cycle_time: Seconds(data_seconds),
            slope1_numerator: 0.5,
            ..defaults()
        };
        let mut sync = TimeSync::start(Span::from_millis(task.into()), parameters).unwrap();
        let mut previous: Option<f64> = None;
        let mut synced = 0;
        for cycle in 0..60_000 {
            let output = sync.update(far.index(cycle), 1);
            let corrected =
                far.count(cycle) as f64 + output.correction_time.unwrap().0 / data_seconds;
            if output.state == TimeSyncState::Synced {
                synced += 1;
                let estimate = output.diagnostic.drift_ppm;
                assert!((estimate / drift - 1.0).abs() < 0.01, "{estimate} ppm");
            }
            if let Some(previous) = previous {
                let step = (corrected - previous) / ratio;
                assert!(
                    (step - 1.0).abs() < 0.02,
                    "{data}:{task} cycle {cycle}: {step}"
                );
            }
            previous = Some(corrected);
        }
        assert!(synced > 20_000, "{data}:{task} synced for {synced} cycles");
    }
}
