//! A far axis through the interface is that of the Rust crate to the last bit, and goes by its plan where frames are missing.
#![allow(missing_docs, unsafe_code)]

mod interruptions;

use core::ptr::{null, null_mut};
use std::ffi::CString;

use ::coaxle_axis::NcToPlcAxis;
use coaxle_c::*;
use coaxle_clock::{CycleIndex, Seconds, Span};
use coaxle_remote::{AxisSync, AxisSyncParameters, FilterMode};

const CYCLE_NS: i64 = 1_000_000;
/// Rate of the far clock: a beat every half second.
const RATE: f64 = 1.002;

/// A struct of zeros that says its size.
fn sized<T>() -> T {
    // SAFETY: all structs of the interface are plain numbers, the first a `u32`.
    unsafe {
        let mut zero: T = core::mem::zeroed();
        (&raw mut zero).cast::<u32>().write(size_of::<T>() as u32);
        zero
    }
}

/// An axis without steps in a mode; or as `FB_AxisSync` has it.
fn axis_of_mode(mode: u32, is_continuous: bool) -> *mut coaxle_far_axis {
    let mut axis = null_mut();
    let mut parameters: coaxle_far_axis_parameters = sized();
    // SAFETY: the rules of the header.
    unsafe {
        let code = coaxle_far_axis_parameters_init(&raw mut parameters, CYCLE_NS, 0);
        assert_eq!(code, COAXLE_OK);
        parameters.mode = mode;
        parameters.is_continuous = is_continuous.into();
        let code = coaxle_far_axis_new(&raw const parameters, &raw mut axis);
        assert_eq!(code, COAXLE_OK);
    }
    axis
}

/// Set values of the master at a cycle of its own.
fn master(count: u64) -> (f64, f64) {
    let t = count as f64 * 1e-3;
    (
        200.0 * t + 3.0 * (9.0 * t).sin(),
        200.0 + 27.0 * (9.0 * t).cos(),
    )
}

fn take(axis: *mut coaxle_far_axis, sample: &coaxle_far_sample) {
    // SAFETY: the rules of the header.
    assert_eq!(unsafe { coaxle_far_axis_sample(axis, sample) }, COAXLE_OK);
}

fn cycle(axis: *mut coaxle_far_axis, correction: Option<f64>) -> coaxle_far_axis_state {
    let mut state = sized();
    let correction = correction.as_ref().map_or(null(), core::ptr::from_ref);
    // SAFETY: the rules of the header.
    let code = unsafe { coaxle_far_axis_cycle(axis, correction, 1, &raw mut state) };
    assert_eq!(code, COAXLE_OK);
    state
}

#[test]
fn each_mode_is_that_of_the_crate() {
    let modes = [
        (COAXLE_MODE_AUTO, FilterMode::Auto),
        (COAXLE_MODE_BYPASS, FilterMode::Bypass),
        (COAXLE_MODE_PT1, FilterMode::Pt1),
        (COAXLE_MODE_TIME, FilterMode::Time),
        (COAXLE_MODE_OBSERVER, FilterMode::Observer),
    ];
    for (mode, filter) in modes {
        let axis = axis_of_mode(mode, false);
        let mut block = AxisSync::start(Span::from_millis(1), AxisSyncParameters::default())
            .expect("good parameters");
        let mut modes_in_force = [false; 6];
        for own in 1_u32..8_000 {
            let far = f64::from(own) * RATE;
            // Silent for long enough for an error once.
            let silent = (6_000..6_200).contains(&own);
            let count = if silent { 6_011 } else { far as u64 };
            let (position, velocity) = master(count);
            take(
                axis,
                &coaxle_far_sample {
                    count,
                    position,
                    velocity,
                    ..sized()
                },
            );
            // Sure after a second.
            let correction = (own > 1_000).then_some((far - count as f64) * 1e-3);
            let state = cycle(axis, correction);
            let received = NcToPlcAxis {
                set_position: position,
                set_velocity: velocity,
                ..NcToPlcAxis::default()
            };
            let index = CycleIndex::of_count(count);
            let expected = match filter {
                FilterMode::Observer => {
                    block.update_by_clock(index, &received, correction.map(Seconds), 1)
                }
                filter => block.update(index, &received, filter, 1),
            };
            assert_eq!(
                [state.position, state.velocity, state.acceleration].map(f64::to_bits),
                [
                    expected.axis.set_position,
                    expected.axis.set_velocity,
                    expected.axis.set_acceleration
                ]
                .map(f64::to_bits),
                "{filter}, cycle {own}"
            );
            assert_eq!(
                (state.mode, state.is_synced != 0, state.beats, state.error),
                (
                    expected.state as u32,
                    expected.synced,
                    expected.beats,
                    expected.error.map_or(0, |error| error.code().into())
                ),
                "{filter}, cycle {own}"
            );
            modes_in_force[state.mode as usize] = true;
        }
        let reached: Vec<usize> = (0..6).filter(|mode| modes_in_force[*mode]).collect();
        // The fallback is in force after the silence, but for a mode that was selected explicitly.
        let expected: &[usize] = match filter {
            FilterMode::Auto => &[2, 3, 4],
            FilterMode::Bypass => &[1],
            FilterMode::Pt1 => &[2],
            FilterMode::Time => &[2, 4],
            FilterMode::Observer => &[2, 4, 5],
        };
        assert_eq!(reached, expected, "{filter}");
        // SAFETY: the rules of the header.
        unsafe { coaxle_far_axis_free(axis) };
    }
}

/// A motion of one piece: it accelerates evenly.
const PLANNED: coaxle_motion_piece = coaxle_motion_piece {
    start_ns: 0,
    duration_ns: 60_000_000_000,
    position: 10.0,
    velocity: 50.0,
    acceleration: 4.0,
    jerk: 0.0,
};

fn planned(t: f64) -> f64 {
    10.0 + 50.0 * t + 2.0 * t * t
}

/// The plan as of a cycle: promised for three seconds.
fn plan_of(count: u64) -> coaxle_plan {
    let mut pieces = [coaxle_motion_piece::default(); COAXLE_MOST_PIECES];
    pieces[0] = PLANNED;
    coaxle_plan {
        count,
        axis_id: 4,
        number: 1,
        promised_until_ns: count as i64 * CYCLE_NS + 3_000_000_000,
        max_velocity: 1_000.0,
        max_acceleration: 10.0,
        max_deceleration: 10.0,
        max_jerk: 100.0,
        pieces,
    }
}

/// The plan after a way over the wire.
fn received(plan: &coaxle_plan) -> coaxle_plan {
    let mut key = null_mut();
    let text = CString::new("coaxle/arm/plans").expect("no 0 in it");
    let mut bytes = vec![0; COAXLE_MOST_BYTES];
    let mut back = [plan_of(0)];
    // SAFETY: the rules of the header.
    unsafe {
        assert_eq!(coaxle_key_new(text.as_ptr(), &raw mut key), COAXLE_OK);
        let mut encode = |plans: &[coaxle_plan]| {
            let (room, mut length) = (bytes.as_mut_ptr(), 0);
            let (plans, number) = (plans.as_ptr(), plans.len());
            let code = coaxle_plans_encode(
                key,
                7,
                9,
                plans,
                number,
                room,
                COAXLE_MOST_BYTES,
                &raw mut length,
            );
            (code, length)
        };
        let of_another_cycle = coaxle_plan {
            count: plan.count + 1,
            ..*plan
        };
        assert_eq!(encode(&[*plan, of_another_cycle]).0, COAXLE_RANGE);
        assert_eq!(encode(&[]).0, COAXLE_RANGE);
        let (code, length) = encode(core::slice::from_ref(plan));
        assert_eq!(code, COAXLE_OK);
        let mut decode = |bytes: &[u8]| {
            let (mut epoch, mut number, mut refused) = (0, 0, 0);
            let code = coaxle_plans_decode(
                key,
                bytes.as_ptr(),
                bytes.len(),
                &raw mut epoch,
                back.as_mut_ptr(),
                1,
                &raw mut number,
                &raw mut refused,
            );
            (code, epoch, number, refused)
        };
        assert_eq!(decode(&bytes[..length]), (COAXLE_OK, 9, 1, 0));
        bytes[length / 2] ^= 1;
        assert_eq!(decode(&bytes[..length]), (COAXLE_REJECTED, 0, 0, 0));
        coaxle_key_free(key);
    }
    back[0]
}

#[test]
fn an_outage_is_bridged_by_the_plan_and_the_time_of_a_position_is_known() {
    // Shown now, and 20 ms later.
    for later_ns in [0, 20_000_000] {
        let axis = axis_of_mode(COAXLE_MODE_OBSERVER, true);
        let later = later_ns as f64 * 1e-9;
        let sample = |count: u64| {
            let t = count as f64 * 1e-3;
            coaxle_far_sample {
                count,
                present_after_ns: later_ns,
                position: planned(t),
                velocity: 50.0 + 4.0 * t,
                acceleration: 4.0,
                ..sized()
            }
        };
        let mut bridged = 0;
        for own in 1_u64..9_000 {
            // Nothing comes between 5 s and 9 s.
            let newest = own.min(5_000);
            if own <= 5_000 {
                if own % 250 == 1 {
                    let plan = received(&plan_of(own));
                    // SAFETY: the rules of the header.
                    assert_eq!(unsafe { coaxle_far_axis_plan(axis, &plan) }, COAXLE_OK);
                }
                take(axis, &sample(own));
            }
            let state = cycle(axis, Some((own - newest) as f64 * 1e-3 + 4e-4));
            let shown = own as f64 * 1e-3 + 4e-4 - later;
            // The last plan was that of 4.751 s.
            if own > 1_500 && shown < 7.750 {
                let off = state.position - planned(shown);
                assert!(off.abs() < 1e-9 * planned(shown), "{own}: {off}");
                assert_eq!((state.error, state.is_synced), (0, 1), "{own}");
                let ahead = (7.751_f64).min(4.751 + 3.0) - shown;
                assert!(own <= 5_000 || (state.promised_ahead_s - ahead).abs() < 1e-6);
                bridged += state.is_planned;
            }
            if shown > 7.752 {
                assert_eq!(
                    (state.is_planned, state.is_silent, state.error),
                    (0, 1, 0x4b52),
                    "{own}"
                );
            }
        }
        // Frames that are shown later are interpolated as long as they are there.
        assert!(bridged > 2_600, "{bridged}");
        the_time_of_a_position_is_known(axis);
        // SAFETY: the rules of the header.
        unsafe { coaxle_far_axis_free(axis) };
    }
}

fn the_time_of_a_position_is_known(axis: *mut coaxle_far_axis) {
    let mut awaited = coaxle_awaited_position {
        position: planned(7.0),
        modulo: 0.0,
        direction: 1,
        reserved: 0,
    };
    let mut at = 0;
    let from = 6_000_000_000;
    // SAFETY: the rules of the header.
    unsafe {
        let mut ask = |awaited: &coaxle_awaited_position| {
            coaxle_far_axis_passage(axis, awaited, from, i64::MAX, &raw mut at)
        };
        assert_eq!(ask(&awaited), COAXLE_OK);
        awaited.direction = -1;
        assert_eq!(ask(&awaited), COAXLE_NOT_THERE);
        awaited.direction = 2;
        assert_eq!(ask(&awaited), COAXLE_RANGE);
    }
    assert!((at - 7_000_000_000).abs() < 10, "{at}");
}

#[test]
fn a_plan_that_is_none_is_refused_and_what_breaks_its_promise_too() {
    let axis = axis_of_mode(COAXLE_MODE_OBSERVER, true);
    // SAFETY: the rules of the header.
    let give = |plan: &coaxle_plan| unsafe { coaxle_far_axis_plan(axis, plan) };
    let good = plan_of(1_000);
    for wrong in [
        coaxle_plan { number: 0, ..good },
        coaxle_plan {
            promised_until_ns: i64::MAX,
            ..good
        },
        coaxle_plan {
            max_acceleration: 1.0,
            max_deceleration: 1.0,
            ..good
        },
        coaxle_plan {
            max_jerk: f64::NAN,
            ..good
        },
    ] {
        assert_eq!(give(&wrong), COAXLE_REJECTED, "{wrong:?}");
    }
    assert_eq!(give(&coaxle_plan { number: 9, ..good }), COAXLE_RANGE);
    assert_eq!(give(&good), COAXLE_OK);
    let back = coaxle_plan {
        promised_until_ns: good.promised_until_ns - 1,
        ..plan_of(1_001)
    };
    assert_eq!(give(&back), COAXLE_REJECTED);
    let mut other = plan_of(1_100);
    other.pieces[0].position += 0.1;
    assert_eq!(give(&other), COAXLE_REJECTED);
    // A sample beside a plan is counted.
    let beside = coaxle_far_sample {
        count: 1_200,
        position: planned(1.2) + 1.0,
        ..sized()
    };
    take(axis, &beside);
    assert_eq!(cycle(axis, None).plan_contradictions, 1);
    // SAFETY: the rules of the header.
    unsafe {
        assert_eq!(coaxle_far_axis_restart(axis), COAXLE_OK);
        let code = coaxle_far_axis_cycle(axis, null(), 1, null_mut());
        assert_eq!(code, COAXLE_NOT_THERE, "of the new run nothing has come");
        coaxle_far_axis_free(axis);
    }
}
