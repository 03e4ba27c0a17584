use super::*;
use coaxle_axis::{AxisState, CoupleState, StateWord};
use proptest::prelude::*;

const CYCLE: Span = Span::from_millis(1);
const DT: f64 = 1e-3;

fn block(parameters: ExtrapolateParameters) -> AxisExtrapolate {
    AxisExtrapolate::start(CYCLE, parameters).unwrap()
}

fn moving(position: f64, velocity: f64, acceleration: f64) -> NcToPlcAxis {
    NcToPlcAxis {
        set_position: position,
        set_velocity: velocity,
        set_acceleration: acceleration,
        ..NcToPlcAxis::default()
    }
}

fn update(
    block: &mut AxisExtrapolate,
    axis: &NcToPlcAxis,
    correction: f64,
    mode: ExtrapolateMode,
) -> ExtrapolateOutput {
    block.update(axis, Some(Seconds(correction)), mode, FallBackMode::Pt1, 1)
}

#[test]
fn defaults_are_the_manuals() {
    let p = ExtrapolateParameters::default();
    assert_eq!(p.max_position_diff, 0.0);
    assert!(p.use_acc_for_extrapolation);
    assert_eq!((p.t1_factor_pos, p.t1_factor_velo), (3.0, 3.0));
    assert_eq!(p.blending_time, Seconds(0.06));
    assert_eq!(p.sys_cmd, 1);
}

#[test]
fn sync_and_time_extrapolate_with_acceleration_or_without() {
    let axis = moving(10.0, 500.0, -2000.0);
    for mode in [ExtrapolateMode::Sync, ExtrapolateMode::Time] {
        let out = update(
            &mut block(ExtrapolateParameters::default()),
            &axis,
            0.0004,
            mode,
        );
        let expected = 10.0 + 500.0 * 0.0004 - 0.5 * 2000.0 * 0.0004 * 0.0004;
        assert!((out.axis.set_position - expected).abs() < 1e-14);
        assert!((out.axis.set_velocity - (500.0 - 2000.0 * 0.0004)).abs() < 1e-12);
        assert_eq!(out.axis.set_acceleration, -2000.0);
        assert_eq!(out.state, mode);

        let encoder = ExtrapolateParameters {
            use_acc_for_extrapolation: false,
            ..ExtrapolateParameters::default()
        };
        let out = update(&mut block(encoder), &axis, 0.0004, mode);
        assert_eq!(out.axis.set_position, 10.0 + 500.0 * 0.0004);
        assert_eq!(out.axis.set_velocity, 500.0);
        // 500 u/s over 0.4 ms.
        assert!((out.diagnostic.position_diff + 0.2).abs() < 1e-12);
        assert_eq!(out.diagnostic.velocity_diff, 0.0);
    }
}

#[test]
fn bypass_changes_nothing() {
    let axis = moving(10.0, 500.0, -2000.0);
    let mut block = block(ExtrapolateParameters::default());
    let out = update(&mut block, &axis, 0.5, ExtrapolateMode::Bypass);
    assert_eq!(out.axis, axis);
}

#[test]
fn every_other_field_passes_through() {
    let axis = NcToPlcAxis {
        state_word: StateWord::HOMED | StateWord::HAS_JOB,
        error_code: 7,
        axis_state: AxisState::Accelerating,
        couple_state: CoupleState::Master,
        actual_position: 3.5,
        axis_id: 4,
        command_number: 12,
        ..moving(1.0, 2.0, 3.0)
    };
    let out = update(
        &mut block(ExtrapolateParameters::default()),
        &axis,
        0.001,
        ExtrapolateMode::Sync,
    );
    let expected = NcToPlcAxis {
        set_position: out.axis.set_position,
        set_velocity: out.axis.set_velocity,
        ..axis
    };
    assert_eq!(out.axis, expected);
}

#[test]
fn the_pt1_answers_a_step_as_its_time_constant_says() {
    let mut block = block(ExtrapolateParameters {
        t1_factor_pos: 5.0,
        t1_factor_velo: 2.0,
        ..ExtrapolateParameters::default()
    });
    let _ = update(
        &mut block,
        &moving(0.0, 0.0, 0.0),
        0.0,
        ExtrapolateMode::Pt1,
    );
    let mut out = None;
    for _ in 0..5 {
        out = Some(update(
            &mut block,
            &moving(1.0, 1.0, 0.0),
            0.0,
            ExtrapolateMode::Pt1,
        ));
    }
    let axis = out.unwrap().axis;
    // Five cycles at a time constant of five, and 5/2 time constants below.
    assert!((axis.set_position - (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
    assert!((axis.set_velocity - (1.0 - (-2.5_f64).exp())).abs() < 1e-12);
}

#[test]
fn a_position_difference_beyond_its_limit_falls_back_with_an_error() {
    for (fall_back, state) in [
        (FallBackMode::Bypass, ExtrapolateMode::Bypass),
        (FallBackMode::Pt1, ExtrapolateMode::Pt1),
    ] {
        let mut block = block(ExtrapolateParameters {
            max_position_diff: 0.3,
            ..ExtrapolateParameters::default()
        });
        let axis = moving(0.0, 500.0, 0.0);
        let mut scan = |correction| {
            let correction = Some(Seconds(correction));
            block.update(&axis, correction, ExtrapolateMode::Sync, fall_back, 1)
        };
        // The limit of 0.3 u is 0.6 ms at 500 u/s.
        let within = scan(0.000_59);
        assert_eq!((within.error, within.state), (None, ExtrapolateMode::Sync));
        let beyond = scan(0.000_61);
        assert_eq!(beyond.error, Some(SyncError::MaxPositionDiffExceeded));
        assert_eq!(beyond.state, state);
        let again = scan(0.000_59);
        assert_eq!((again.error, again.state), (None, ExtrapolateMode::Sync));
    }
}

#[test]
fn without_a_correction_time_the_fallback_takes_over() {
    let mut block = block(ExtrapolateParameters::default());
    let axis = moving(0.0, 500.0, 0.0);
    let out = block.update(&axis, None, ExtrapolateMode::Sync, FallBackMode::Pt1, 1);
    assert_eq!(out.state, ExtrapolateMode::Pt1);
    assert_eq!(out.error, None);
}

#[test]
fn a_change_from_pt1_to_sync_is_blended_in_a_straight_line() {
    let mut block = block(ExtrapolateParameters::default());
    let axis = |k: i32| moving(500.0 * DT * f64::from(k), 500.0, 0.0);
    for k in 0..200 {
        let _ = update(&mut block, &axis(k), 0.0, ExtrapolateMode::Pt1);
    }
    let mut previous: Option<f64> = None;
    for k in 200..300 {
        let out = update(&mut block, &axis(k), 0.000_5, ExtrapolateMode::Sync);
        let behind = axis(k).set_position + 0.25 - out.axis.set_position;
        if k < 259 {
            let previous = previous.replace(behind).unwrap_or(behind);
            // PT1 lag of three cycles plus half a cycle, faded over 60 cycles.
            let step = 500.0 * DT * (1.0 / (1.0 / 3.0_f64).exp_m1() + 0.5) / 60.0;
            if k > 200 {
                assert!((previous - behind - step).abs() < 1e-9, "cycle {k}");
            }
        } else if k >= 260 {
            assert!(behind.abs() < 1e-12, "cycle {k}: {behind}");
        }
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    type Spoil = fn(&mut ExtrapolateParameters);
    let cases: [(&str, Spoil); 4] = [
        ("max-position-diff", |p| p.max_position_diff = -1.0),
        ("t1-factor-pos", |p| p.t1_factor_pos = f64::NAN),
        ("t1-factor-velo", |p| p.t1_factor_velo = -0.1),
        ("blending-time-s", |p| {
            p.blending_time = Seconds(f64::INFINITY)
        }),
    ];
    for (name, spoil) in cases {
        let mut parameters = ExtrapolateParameters::default();
        spoil(&mut parameters);
        let wrong = AxisExtrapolate::start(CYCLE, parameters).unwrap_err();
        assert_eq!(wrong.parameter, name);
    }
}

fn any_mode() -> impl Strategy<Value = ExtrapolateMode> {
    prop::sample::select(std::vec![
        ExtrapolateMode::Bypass,
        ExtrapolateMode::Pt1,
        ExtrapolateMode::Sync,
        ExtrapolateMode::Time,
    ])
}

proptest! {
    /// With any sequence of modes a steadily moving axis never jumps.
    #[test]
    fn no_change_of_mode_is_a_step(
        modes in prop::collection::vec((any_mode(), 1_usize..100), 1..12),
    ) {
        let mut block = block(ExtrapolateParameters::default());
        let mut previous: Option<f64> = None;
        let mut k = 0;
        // The filter settles first.
        let settle = (ExtrapolateMode::Bypass, 50);
        for (mode, cycles) in core::iter::once(settle).chain(modes) {
            for _ in 0..cycles {
                k += 1;
                let axis = moving(500.0 * DT * f64::from(k), 500.0, 0.0);
                let position = update(&mut block, &axis, 0.000_7, mode).axis.set_position;
                if let Some(previous) = previous {
                    let step: f64 = position - previous;
                    // At most the filter's lag of three cycles and the correction of 0.7, faded
                    // over 60, come on top.
                    prop_assert!((step / (500.0 * DT) - 1.0).abs() < 0.1, "{step}");
                }
                previous = Some(position);
            }
        }
    }
}

proptest! {
    /// At any number of changes of the mode and losses of its correction the set values stay
    /// between those of the modes.
    #[test]
    fn a_blend_stays_between_the_modes_whatever_the_changes(
        parts in prop::collection::vec((any_mode(), 1_usize..20, any::<bool>(), any::<bool>()), 1..300),
    ) {
        let mut block = block(ExtrapolateParameters::default());
        let mut k = 0;
        for (mode, cycles, is_known, carries_on) in parts {
            if carries_on {
                block.carry_on();
            }
            for _ in 0..cycles {
                k += 1;
                let axis = moving(500.0 * DT * f64::from(k), 500.0, 0.0);
                let correction = is_known.then_some(Seconds(0.000_7));
                let out = block.update(&axis, correction, mode, FallBackMode::Pt1, 1);
                let behind = axis.set_position - out.axis.set_position;
                // The filter lags behind by three cycles; the correction is 0.7 of one.
                prop_assert!((-0.36..1.8).contains(&behind), "{behind}");
            }
        }
    }
}
