use super::*;
use proptest::prelude::*;
use std::format;
use std::vec::Vec;

const CYCLE: Span = Span::from_millis(1);

/// A far sender as the receiver's cycles see it: no jitter, so that every figure is exact.
struct Far {
    /// Data cycles per receiver cycle.
    rate: f64,
    /// Data cycles at receiver cycle 0.
    phase: f64,
    first_index: u16,
}

impl Far {
    fn drifting(ppm: f64) -> Self {
        Self {
            rate: 1.0 + ppm * 1e-6,
            phase: 100.5,
            first_index: 0,
        }
    }

    fn true_count(&self, cycle: i64) -> f64 {
        self.phase + cycle as f64 * self.rate
    }

    fn count(&self, cycle: i64) -> i64 {
        self.true_count(cycle).floor() as i64
    }

    fn index(&self, cycle: i64) -> CycleIndex {
        CycleIndex((self.count(cycle) as u16).wrapping_add(self.first_index))
    }
}

fn started(parameters: TimeSyncParameters) -> TimeSync {
    TimeSync::start(CYCLE, parameters).unwrap()
}

fn defaults() -> TimeSyncParameters {
    TimeSyncParameters::default()
}

/// Corrected data count minus the true one, in data cycles.
fn error_of(far: &Far, cycle: i64, output: &TimeSyncOutput, data_cycle: f64) -> f64 {
    let correction = output.correction_time.unwrap().0 / data_cycle;
    far.count(cycle) as f64 + correction - far.true_count(cycle)
}

/// Runs until synchronised and gives the cycle, or none within `cycles`.
fn cycle_of_sync(sync: &mut TimeSync, far: &Far, cycles: i64) -> Option<(i64, TimeSyncOutput)> {
    (0..cycles)
        .map(|cycle| (cycle, sync.update(far.index(cycle), 1)))
        .find(|(_, output)| output.state == TimeSyncState::Synced)
}

#[test]
fn defaults_are_the_manuals() {
    let p = defaults();
    assert_eq!(p.data_cycle_time, Seconds::ZERO);
    assert_eq!(p.threshold_for_sync, 0.05);
    assert_eq!(p.max_cycle_index_difference, 7.0);
    assert_eq!(p.age_of_data_limit, 7);
    assert_eq!(p.no_of_periods_for_mean_drift, 1);
    assert_eq!(p.delay_time_offset, Seconds::ZERO);
    assert_eq!((p.slope1_numerator, p.slope1_denominator), (0.95, 0.5));
    assert_eq!(p.end_of_transition_limit, 90);
    assert_eq!(p.new_drift_bending_cycles, 90);
    assert_eq!(p.time_mode_blending_cycles, 90);
    assert!(!p.force_time_mode && !p.automatic_re_init);
    assert_eq!(p.sys_cmd, 1);
}

#[test]
fn codes_are_the_manuals() {
    assert_eq!(SyncError::MaxCycleIndexDiffExceeded.code(), 19281);
    assert_eq!(SyncError::MaxDataAgeExceeded.code(), 19282);
    assert_eq!(SyncError::UnknownSyncLoss.code(), 19283);
    assert_eq!(SyncError::WrongParameter.code(), 19286);
    assert_eq!(SyncError::MaxPositionDiffExceeded.code(), 19289);
    assert_eq!(SyncWarning::DriftChangedSignificantly.code(), 1);
}

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
fn lost_and_doubled_messages_make_no_beat() {
    let far = Far::drifting(100.0);
    let mut sync = started(TimeSyncParameters {
        slope1_numerator: 0.5,
        ..defaults()
    });
    let mut held = far.index(0);
    let mut synced_at = None;
    for cycle in 0..100_000 {
        // Every 37th message is lost: the input image keeps the old one.
        if cycle % 37 != 5 {
            held = far.index(cycle);
        }
        let output = sync.update(held, 1);
        if output.state == TimeSyncState::Synced {
            synced_at.get_or_insert(cycle);
        }
        if synced_at.is_some() {
            assert_eq!(output.state, TimeSyncState::Synced, "cycle {cycle}");
        }
    }
    assert_eq!(sync.beats.count(), 10);
    assert!(synced_at.is_some());
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
fn data_that_stay_away_too_long_are_an_error() {
    let far = Far::drifting(200.0);
    let mut sync = started(defaults());
    let (cycle, _) = cycle_of_sync(&mut sync, &far, 100_000).unwrap();
    for age in 1..=7 {
        let output = sync.update(far.index(cycle), 1);
        assert_eq!(output.state, TimeSyncState::Synced, "age {age}");
    }
    let output = sync.update(far.index(cycle), 1);
    let failed = TimeSyncState::Failed(SyncError::MaxDataAgeExceeded);
    assert_eq!(output.state, failed);
    assert_eq!(output.correction_time, None);
    // Without automatic re-initialisation it stays.
    let later = sync.update(far.index(cycle + 20), 1);
    assert_eq!(later.state, failed);
}

#[test]
fn with_the_age_not_watched_the_index_difference_ends_an_outage() {
    let far = Far::drifting(-200.0);
    let mut sync = started(TimeSyncParameters {
        age_of_data_limit: 0,
        ..defaults()
    });
    let (cycle, _) = cycle_of_sync(&mut sync, &far, 100_000).unwrap();
    let failed = (1..20).find(|_| {
        let state = sync.update(far.index(cycle), 1).state;
        state == TimeSyncState::Failed(SyncError::MaxCycleIndexDiffExceeded)
    });
    assert_eq!(failed, Some(8));
}

#[test]
fn an_age_limit_of_zero_watches_nothing() {
    let mut sync = started(TimeSyncParameters {
        age_of_data_limit: 0,
        max_cycle_index_difference: 0.0,
        ..defaults()
    });
    for _ in 0..1_000 {
        let output = sync.update(CycleIndex(9), 1);
        assert_eq!(output.state, TimeSyncState::StartUp);
    }
}

#[test]
fn an_index_that_jumps_is_an_error() {
    for jump in [1_000_u16, 64_536] {
        let far = Far::drifting(200.0);
        let mut sync = started(defaults());
        let (cycle, _) = cycle_of_sync(&mut sync, &far, 100_000).unwrap();
        let index = CycleIndex(far.index(cycle + 1).0.wrapping_add(jump));
        let output = sync.update(index, 1);
        let expected = TimeSyncState::Failed(SyncError::MaxCycleIndexDiffExceeded);
        assert_eq!(output.state, expected);
    }
}

#[test]
fn a_far_plateau_is_an_unknown_loss_when_the_difference_is_not_watched() {
    let far = Far::drifting(200.0);
    let mut sync = started(TimeSyncParameters {
        max_cycle_index_difference: 0.0,
        ..defaults()
    });
    let (start, _) = cycle_of_sync(&mut sync, &far, 100_000).unwrap();
    let failed = (start + 1..start + 1_000).find(|cycle| {
        let index = CycleIndex(far.index(*cycle).0.wrapping_add(500));
        let output = sync.update(index, 1);
        output.state == TimeSyncState::Failed(SyncError::UnknownSyncLoss)
    });
    assert_eq!(failed, Some(start + 1 + 90));
}

#[test]
fn automatic_re_initialisation_waits_for_new_data_and_synchronises_again() {
    let far = Far::drifting(500.0);
    let mut sync = started(TimeSyncParameters {
        automatic_re_init: true,
        ..defaults()
    });
    let (lost, _) = cycle_of_sync(&mut sync, &far, 100_000).unwrap();
    for _ in 0..8 {
        let _ = sync.update(far.index(lost), 1);
    }
    for _ in 0..100 {
        let output = sync.update(far.index(lost), 1);
        assert_eq!(output.state, TimeSyncState::StartUp, "fault deleted");
        assert_eq!(output.correction_time, None, "old data start nothing");
    }
    let again = (lost + 108..lost + 20_000)
        .find(|cycle| sync.update(far.index(*cycle), 1).state == TimeSyncState::Synced);
    assert!(again.is_some());
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

#[test]
fn limits_in_cycles_rise_with_the_ratio() {
    let sync = TimeSync::start(
        Span::from_millis(10),
        TimeSyncParameters {
            data_cycle_time: Seconds(0.001),
            ..defaults()
        },
    )
    .unwrap();
    assert_eq!(sync.parameters().max_cycle_index_difference, 12.0);
    assert_eq!(sync.parameters().age_of_data_limit, 12);
}

#[test]
fn wrong_parameters_are_refused_by_name() {
    type Spoil = fn(&mut TimeSyncParameters);
    let cases: [(&str, Spoil); 10] = [
        ("data-cycle-time-s", |p| p.data_cycle_time = Seconds(0.0015)),
        ("data-cycle-time-s", |p| p.data_cycle_time = Seconds(-0.001)),
        ("data-cycle-time-s", |p| {
            p.data_cycle_time = Seconds(f64::NAN)
        }),
        ("threshold-for-sync", |p| p.threshold_for_sync = 0.0),
        ("max-cycle-index-difference", |p| {
            p.max_cycle_index_difference = -1.0
        }),
        ("no-of-periods-for-mean-drift", |p| {
            p.no_of_periods_for_mean_drift = 0
        }),
        ("no-of-periods-for-mean-drift", |p| {
            p.no_of_periods_for_mean_drift = 65
        }),
        ("delay-time-offset-s", |p| {
            p.delay_time_offset = Seconds(f64::INFINITY)
        }),
        ("slope1-numerator", |p| p.slope1_numerator = 1.1),
        ("slope1-denominator", |p| p.slope1_denominator = 1.0),
    ];
    for (name, spoil) in cases {
        let mut parameters = defaults();
        spoil(&mut parameters);
        let wrong = TimeSync::start(CYCLE, parameters).unwrap_err();
        assert_eq!(wrong.parameter, name);
        assert!(format!("{wrong}").starts_with("0x4b56"), "{wrong}");
    }
}

#[test]
fn skipped_own_cycles_are_counted_as_time() {
    let far = Far::drifting(200.0);
    let mut sync = started(defaults());
    let (mut cycle, _) = cycle_of_sync(&mut sync, &far, 100_000).unwrap();
    let mut previous = None;
    for k in 0..20_000 {
        let elapsed = if k % 500 == 499 { 4 } else { 1 };
        cycle += i64::from(elapsed);
        let output = sync.update(far.index(cycle), elapsed);
        assert_eq!(output.state, TimeSyncState::Synced);
        let corrected =
            far.count(cycle) as f64 + output.correction_time.unwrap().0 / CYCLE.as_secs_f64();
        if let Some(previous) = previous {
            let step: f64 = corrected - previous;
            assert!((step - f64::from(elapsed)).abs() < 0.01, "{step}");
        }
        previous = Some(corrected);
    }
}

proptest! {
    #[test]
    fn any_index_sequence_gives_finite_corrections(
        steps in prop::collection::vec((any::<i16>(), 1_u32..20), 1..400),
        ratio in prop::sample::select(std::vec![0.0, 0.001, 0.004, 0.00025]),
        re_init: bool,
    ) {
        let parameters = TimeSyncParameters {
            data_cycle_time: Seconds(ratio),
            automatic_re_init: re_init,
            end_of_transition_limit: 3,
            ..defaults()
        };
        let mut sync = TimeSync::start(CYCLE, parameters).unwrap();
        let mut index = 0_u16;
        for (step, elapsed) in steps {
            index = index.wrapping_add_signed(if step % 3 == 0 { step } else { 1 });
            let output = sync.update(CycleIndex(index), elapsed);
            if let Some(correction) = output.correction_time {
                prop_assert!(correction.0.is_finite());
            }
            prop_assert!(output.diagnostic.drift_ppm.is_finite());
        }
    }
}
