use super::*;
use crate::{FallBackMode, StartUpMode};
use proptest::prelude::*;

const CYCLE: Span = Span::from_millis(1);
const VELOCITY: f64 = 500.0;
const DRIFT_PPM: f64 = 200.0;

/// A master at constant velocity on a clock that runs fast, read once per own cycle.
fn far(cycle: u32) -> (CycleIndex, NcToPlcAxis) {
    // Half a cycle beyond a whole one, far from both beats at the start.
    let count = (10.5 + f64::from(cycle) * (1.0 + DRIFT_PPM * 1e-6)).floor();
    let axis = NcToPlcAxis {
        set_position: VELOCITY * 1e-3 * count,
        set_velocity: VELOCITY,
        ..NcToPlcAxis::default()
    };
    (CycleIndex(count as u16), axis)
}

fn block(parameters: AxisSyncParameters) -> AxisSync {
    AxisSync::start(CYCLE, parameters).unwrap()
}

fn scan(block: &mut AxisSync, cycle: u32, mode: FilterMode) -> AxisSyncOutput {
    let (index, axis) = far(cycle);
    block.update(index, &axis, mode, 1)
}

/// Runs until synchronised; returns the next cycle.
fn synchronise(block: &mut AxisSync) -> u32 {
    // A beat comes every 1/200 ppm = 5000 cycles, and sync takes some of them.
    (0..50_000)
        .find(|cycle| scan(block, *cycle, FilterMode::Auto).synced)
        .expect("synchronised")
        + 1
}

#[test]
fn defaults_are_the_manuals() {
    let p = AxisSyncParameters::default();
    assert_eq!(p.start_up_mode, StartUpMode::Time);
    assert_eq!(p.fall_back_mode, FallBackMode::Pt1);
    assert_eq!(FilterMode::default(), FilterMode::Auto);
    assert_eq!(FilterMode::Time as u8, 4);
    assert_eq!(FilterState::Sync as u8, 3);
}

#[test]
fn disabled_it_passes_everything_through() {
    let mut block = block(AxisSyncParameters::default());
    let _ = synchronise(&mut block);
    block.disable();
    let (index, axis) = far(77);
    let out = block.update(index, &axis, FilterMode::Auto, 1);
    assert_eq!(out.axis, axis);
    assert!(!out.synced);
    block.enable().unwrap();
    assert!(
        !scan(&mut block, 78, FilterMode::Auto).synced,
        "starts anew"
    );
}

#[test]
fn automatic_mode_starts_in_the_chosen_mode_and_ends_in_sync() {
    for (start_up_mode, state) in [
        (StartUpMode::Bypass, FilterState::Bypass),
        (StartUpMode::Pt1, FilterState::Pt1),
        (StartUpMode::Time, FilterState::Time),
    ] {
        let mut block = block(AxisSyncParameters {
            start_up_mode,
            ..AxisSyncParameters::default()
        });
        let first = scan(&mut block, 0, FilterMode::Auto);
        assert_eq!(first.state, state);
        assert!(first.diagnostic.time_mode);
        let cycle = synchronise(&mut block);
        let out = scan(&mut block, cycle, FilterMode::Auto);
        assert_eq!(out.state, FilterState::Sync);
        assert!(!out.diagnostic.time_mode);
        assert!(out.diagnostic.correction_time.is_some());
    }
}

#[test]
fn each_filter_mode_holds_whether_synchronised_or_not() {
    let mut block = block(AxisSyncParameters::default());
    let synced = synchronise(&mut block);
    let mut cycle = synced;
    for (mode, state) in [
        (FilterMode::Bypass, FilterState::Bypass),
        (FilterMode::Pt1, FilterState::Pt1),
        (FilterMode::Time, FilterState::Time),
        (FilterMode::Auto, FilterState::Sync),
    ] {
        for _ in 0..200 {
            let out = scan(&mut block, cycle, mode);
            assert_eq!(out.state, state);
            assert!(out.synced, "the mode does not touch the synchronisation");
            cycle += 1;
        }
    }
}

#[test]
fn synchronised_the_velocity_has_no_spike_and_in_bypass_it_has() {
    let worst = |mode| {
        let mut block = block(AxisSyncParameters::default());
        let start = synchronise(&mut block);
        let mut previous = None;
        let mut worst = 0.0_f64;
        for cycle in start..start + 40_000 {
            let position = scan(&mut block, cycle, mode).axis.set_position;
            if let Some(previous) = previous.replace(position)
                && cycle > start + 200
            {
                let velocity = (position - previous) / 1e-3;
                worst = worst.max((velocity / VELOCITY - 1.0 - DRIFT_PPM * 1e-6).abs());
            }
        }
        worst
    };
    // Slopes of the corrected time stay below the drift itself, 2e-4.
    assert!(worst(FilterMode::Auto) < 1e-3);
    // A beat shows two cycles of way in one: twice the velocity.
    assert!((worst(FilterMode::Bypass) - 1.0).abs() < 0.01);
    // The filter passes 1 - e^(-1/3) = 0.28 of a step in its first cycle.
    assert!((0.2..0.5).contains(&worst(FilterMode::Pt1)));
    // A cycle blended over 90 is 1/90 = 0.011 of the velocity.
    assert!((0.005..0.02).contains(&worst(FilterMode::Time)));
}

#[test]
fn lost_data_fall_back_and_stay_there() {
    for (fall_back_mode, state) in [
        (FallBackMode::Pt1, FilterState::Pt1),
        (FallBackMode::Bypass, FilterState::Bypass),
    ] {
        let mut block = block(AxisSyncParameters {
            fall_back_mode,
            ..AxisSyncParameters::default()
        });
        let lost = synchronise(&mut block);
        let mut out = scan(&mut block, lost, FilterMode::Auto);
        // A scan more than the age limit of 7.
        for _ in 0..8 {
            out = scan(&mut block, lost, FilterMode::Auto);
        }
        assert_eq!(out.error, Some(SyncError::MaxDataAgeExceeded));
        assert_eq!(out.state, state);
        assert!(!out.synced);
        // Data are back; the fault stays until the block is enabled again.
        let out = scan(&mut block, lost + 20, FilterMode::Auto);
        assert_eq!(out.error, Some(SyncError::MaxDataAgeExceeded));
        block.enable().unwrap();
        assert_eq!(scan(&mut block, lost + 21, FilterMode::Auto).error, None);
    }
}

/// The correction grows to a whole cycle of 0.5 mm; half of that is too much.
fn narrow(automatic_re_init: bool) -> AxisSyncParameters {
    let mut parameters = AxisSyncParameters::default();
    parameters.extrapolate.max_position_diff = 0.25;
    parameters.time_sync.automatic_re_init = automatic_re_init;
    parameters
}

#[test]
fn a_position_too_far_off_drops_sync_and_falls_back() {
    let mut block = block(narrow(false));
    let (cycle, out) = (0..50_000)
        .map(|cycle| (cycle, scan(&mut block, cycle, FilterMode::Auto)))
        .find(|(_, out)| out.error.is_some())
        .unwrap();
    assert_eq!(out.error, Some(SyncError::MaxPositionDiffExceeded));
    assert_eq!(out.state, FilterState::Pt1);
    let later = scan(&mut block, cycle + 1, FilterMode::Auto);
    assert_eq!(later.error, Some(SyncError::MaxPositionDiffExceeded));
    assert!(!later.synced);
}

#[test]
fn automatic_re_initialisation_deletes_a_position_error_after_one_cycle() {
    let mut block = block(narrow(true));
    let errors: std::vec::Vec<u32> = (0..30_000)
        .filter(|cycle| scan(&mut block, *cycle, FilterMode::Auto).error.is_some())
        .collect();
    assert!(!errors.is_empty());
    let first = errors[0];
    assert!(errors.contains(&(first + 1)) && !errors.contains(&(first + 2)));
}

#[test]
fn a_wrong_parameter_keeps_it_from_starting() {
    let mut parameters = AxisSyncParameters::default();
    parameters.time_sync.slope1_numerator = 2.0;
    assert!(AxisSync::start(CYCLE, parameters).is_err());
    let mut parameters = AxisSyncParameters::default();
    parameters.extrapolate.t1_factor_pos = -2.0;
    assert!(AxisSync::start(CYCLE, parameters).is_err());
}

#[test]
fn the_delay_offset_moves_the_axis_ahead() {
    let mut plain = block(AxisSyncParameters::default());
    let mut ahead = block(AxisSyncParameters::default());
    ahead.set_delay_time_offset(Seconds(0.002));
    for cycle in 0..3_000 {
        let plain = scan(&mut plain, cycle, FilterMode::Auto).axis.set_position;
        let ahead = scan(&mut ahead, cycle, FilterMode::Auto).axis.set_position;
        // 2 ms at 500 u/s.
        assert!((ahead - plain - 1.0).abs() < 1e-9);
    }
}

#[test]
fn other_parameters_take_hold_without_a_step_and_wrong_ones_change_nothing() {
    let mut block = block(AxisSyncParameters::default());
    let begin = synchronise(&mut block);
    let mut parameters = AxisSyncParameters::default();
    parameters.extrapolate.blending_time = Seconds(0.05);
    parameters.start_up_mode = StartUpMode::Bypass;
    let mut before = scan(&mut block, begin, FilterMode::Auto).axis.set_position;
    for cycle in begin + 1..begin + 2_000 {
        if cycle == begin + 1_000 {
            block.set_parameters(parameters).expect("good ones");
        }
        if cycle == begin + 1_500 {
            let mut wrong = parameters;
            wrong.extrapolate.blending_time = Seconds(-1.0);
            let error = block.set_parameters(wrong).unwrap_err();
            assert_eq!(error.error(), SyncError::WrongParameter);
        }
        let out = scan(&mut block, cycle, FilterMode::Auto);
        assert!(out.synced, "{cycle}");
        let way = out.axis.set_position - before;
        before = out.axis.set_position;
        assert!(
            (way - VELOCITY * 1e-3).abs() < 0.02 * VELOCITY * 1e-3,
            "{cycle}: {way}"
        );
    }
    block.disable();
    block.enable().unwrap();
    let anew = scan(&mut block, begin + 2_000, FilterMode::Auto);
    assert_eq!(anew.state, FilterState::Bypass, "as they say now");
}

proptest! {
    /// With any input the output is finite and its mode is true.
    #[test]
    fn any_input_gives_finite_set_values(
        scans in prop::collection::vec((any::<u16>(), -1e6..1e6_f64, 0_u8..4, 1_u32..9), 1..300),
        re_init: bool,
    ) {
        let mut parameters = narrow(re_init);
        parameters.time_sync.end_of_transition_limit = 4;
        let mut block = block(parameters);
        for (index, value, mode, elapsed) in scans {
            let mode = [FilterMode::Auto, FilterMode::Bypass, FilterMode::Pt1, FilterMode::Time]
                [usize::from(mode)];
            let axis = NcToPlcAxis {
                set_position: value,
                set_velocity: -value,
                set_acceleration: value,
                ..NcToPlcAxis::default()
            };
            let out = block.update(CycleIndex(index % 50), &axis, mode, elapsed);
            prop_assert_eq!(out.axis.implausible_field(), None);
            prop_assert!(!(out.synced && out.error.is_some()));
        }
    }
}

/// The correction of an ideal observer: to the true count, less the mean that it cannot see.
fn clock_of(cycle: u32) -> Option<Seconds> {
    let truth = 10.5 + f64::from(cycle) * (1.0 + DRIFT_PPM * 1e-6);
    Some(Seconds((truth - truth.floor()) * 1e-3))
}

#[test]
fn by_a_clock_time_mode_bridges_until_it_is_sure_and_the_change_is_no_step() {
    let mut block = block(AxisSyncParameters::default());
    let mut previous: Option<f64> = None;
    for cycle in 0..20_000 {
        let clock = clock_of(cycle).filter(|_| cycle >= 3_000);
        let (index, axis) = far(cycle);
        let out = block.update_by_clock(index, &axis, clock, 1);
        let expected = match clock {
            Some(_) => FilterState::Observer,
            None => FilterState::Time,
        };
        assert_eq!((out.state, out.synced), (expected, clock.is_some()));
        if let Some(previous) = previous {
            let velocity = (out.axis.set_position - previous) / 1e-3;
            let ripple = velocity / VELOCITY - 1.0 - DRIFT_PPM * 1e-6;
            // A correction of up to a cycle, faded in over 60.
            assert!(ripple.abs() < 1.0 / 59.0, "cycle {cycle}: {ripple}");
            if cycle > 3_100 {
                assert!(ripple.abs() < 1e-9, "cycle {cycle}: {ripple}");
            }
        }
        previous = Some(out.axis.set_position);
    }
}

/// Until an observer is sure of the clock, time mode stood for the length of the silence, and then jumped.
#[test]
fn by_a_clock_time_mode_bridges_a_silence_as_the_observer_does() {
    for limit in [None, Some(100), Some(0)] {
        let mut parameters = AxisSyncParameters::default();
        parameters.time_sync.age_of_data_limit = limit;
        let mut block = block(parameters);
        let mut previous: Option<f64> = None;
        for cycle in 0..3_000 {
            let heard = match cycle {
                1_000..1_060 => 999,
                2_000..2_095 => 1_999,
                _ => cycle,
            };
            let (index, axis) = far(heard);
            let out = block.update_by_clock(index, &axis, None, 1);
            assert_eq!((out.state, out.error), (FilterState::Time, None), "{cycle}");
            if let Some(previous) = previous {
                let velocity = (out.axis.set_position - previous) / 1e-3;
                let ripple = velocity / VELOCITY - 1.0;
                assert!(ripple.abs() < 1.0 / 59.0, "{limit:?}, {cycle}: {ripple}");
            }
            previous = Some(out.axis.set_position);
        }
    }
}

#[test]
fn by_a_clock_silence_falls_back_and_new_data_are_followed_again() {
    let mut parameters = AxisSyncParameters::default();
    parameters.time_sync.age_of_data_limit = Some(7);
    let mut block = block(parameters);
    for cycle in 0..500 {
        let (index, axis) = far(cycle);
        let _ = block.update_by_clock(index, &axis, clock_of(cycle), 1);
    }
    let (index, axis) = far(499);
    // Up to the age limit the clock carries the axis on.
    for age in 1..=7 {
        let held = block.update_by_clock(index, &axis, clock_of(499 + age), 1);
        assert_eq!(held.state, FilterState::Observer, "held over");
    }
    let out = block.update_by_clock(index, &axis, clock_of(507), 1);
    assert_eq!(out.state, FilterState::Pt1);
    assert_eq!(out.error, Some(SyncError::MaxDataAgeExceeded));
    assert!(!out.synced);
    let (index, axis) = far(520);
    let out = block.update_by_clock(index, &axis, clock_of(520), 1);
    assert_eq!((out.state, out.error), (FilterState::Observer, None));
}

#[test]
fn by_a_clock_a_drift_that_beats_show_to_change_is_no_news() {
    let warned = |clock: fn(u32) -> Option<Seconds>| {
        let mut block = block(AxisSyncParameters::default());
        (0..20_000_u32).any(|cycle| {
            let faster = f64::from(cycle.saturating_sub(8_000)) * 10.0 * DRIFT_PPM * 1e-6;
            let count = (f64::from(cycle) * (1.0 + DRIFT_PPM * 1e-6) + faster) as u64;
            let (_, axis) = far(cycle);
            let index = CycleIndex::of_count(count);
            block
                .update_by_clock(index, &axis, clock(cycle), 1)
                .warning
                .is_some()
        })
    };
    assert!(warned(|_| None));
    assert!(!warned(clock_of));
}

#[test]
fn a_blend_is_bounded_by_the_real_difference_whatever_the_re_initialisations() {
    let mut parameters = AxisSyncParameters::default();
    parameters.time_sync.automatic_re_init = true;
    let mut block = block(parameters);
    // 10 ms of data, 9 ms of silence, for a minute.
    for cycle in 0..60_000 {
        let heard = cycle - (cycle % 19_u32).saturating_sub(9);
        let (index, axis) = far(heard);
        let out = block.update(index, &axis, FilterMode::Auto, 1);
        let (_, master) = far(cycle);
        let off = out.axis.set_position - master.set_position;
        // Silence of 9 cycles moves the far axis by 9 of its own, and the filter lags behind by 3.
        let cycles = off / (VELOCITY * 1e-3);
        assert!((-3.5..3.5).contains(&cycles), "cycle {cycle}: {off} u");
    }
}

#[test]
fn a_small_index_difference_that_is_exceeded_at_every_beat_moves_nothing_away() {
    let mut parameters = AxisSyncParameters::default();
    parameters.time_sync.automatic_re_init = true;
    parameters.time_sync.max_cycle_index_difference = 0.5;
    let mut block = block(parameters);
    let mut errors = 0;
    for cycle in 0..60_000 {
        let (index, axis) = far(cycle);
        let out = block.update(index, &axis, FilterMode::Auto, 1);
        errors += u32::from(out.error.is_some());
        let cycles = (out.axis.set_position - axis.set_position) / (VELOCITY * 1e-3);
        assert!(
            (-4.0..1.6).contains(&cycles),
            "cycle {cycle}: {cycles} cycles"
        );
    }
    // A beat every 5000 cycles, so 12 in this minute.
    assert!(errors > 10, "{errors}");
}
