//! Parameters, limits and codes.

use super::*;
use std::format;

#[test]
fn defaults_are_the_manuals() {
    let p = defaults();
    assert_eq!(p.data_cycle_time, Seconds::ZERO);
    assert_eq!(p.threshold_for_sync, 0.05);
    assert_eq!(p.max_cycle_index_difference, 7.0);
    assert_eq!(p.age_limit(), 7);
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
    assert_eq!(sync.parameters().age_of_data_limit, Some(12));
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
