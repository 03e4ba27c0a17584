//! Losses, errors and what follows them.

use super::*;
use proptest::prelude::*;

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
fn of_two_limits_the_narrower_one_ends_a_silence() {
    for (max_cycle_index_difference, age_of_data_limit, error, age) in [
        (3.0, 50, SyncError::MaxCycleIndexDiffExceeded, 4),
        (7.0, 7, SyncError::MaxDataAgeExceeded, 8),
        (50.0, 3, SyncError::MaxDataAgeExceeded, 4),
        (0.0, 3, SyncError::MaxDataAgeExceeded, 4),
    ] {
        for drift in [200.0, -200.0] {
            let far = Far::drifting(drift);
            let mut sync = started(TimeSyncParameters {
                max_cycle_index_difference,
                age_of_data_limit: Some(age_of_data_limit),
                ..defaults()
            });
            let (cycle, _) = cycle_of_sync(&mut sync, &far, 100_000).unwrap();
            let failed = (1..60).find_map(|age| match sync.update(far.index(cycle), 1).state {
                TimeSyncState::Failed(error) => Some((error, age)),
                TimeSyncState::StartUp | TimeSyncState::Synced => None,
            });
            assert_eq!(
                failed,
                Some((error, age)),
                "{max_cycle_index_difference}, {drift} ppm"
            );
        }
    }
}

#[test]
fn with_the_age_not_watched_the_index_difference_ends_an_outage() {
    let far = Far::drifting(-200.0);
    let mut sync = started(TimeSyncParameters {
        age_of_data_limit: Some(0),
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
        age_of_data_limit: Some(0),
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
