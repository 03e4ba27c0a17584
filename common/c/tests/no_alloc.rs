//! No function of a cycle allocates.
#![allow(missing_docs, unsafe_code)]

use core::ptr::{null, null_mut};
use std::ffi::CString;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use coaxle_c::*;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

const CYCLE: i64 = 1_000_000;

/// Size of a struct, as a caller states it.
const fn size<T>() -> u32 {
    size_of::<T>() as u32
}

/// A struct of zeros that says its size.
fn sized<T>() -> T {
    // SAFETY: all structs of the interface are plain numbers, the first a `u32`.
    unsafe {
        let mut zero: T = core::mem::zeroed();
        (&raw mut zero).cast::<u32>().write(size::<T>());
        zero
    }
}

fn text(of: &str) -> CString {
    CString::new(of).expect("no 0 in it")
}

#[test]
fn a_far_axis_and_its_plans() {
    // SAFETY: the rules of the header.
    unsafe {
        let mut parameters: coaxle_far_axis_parameters = sized();
        let (mut axis, mut key) = (null_mut(), null_mut());
        let code = coaxle_far_axis_parameters_init(&raw mut parameters, CYCLE, CYCLE);
        assert_eq!(code, COAXLE_OK);
        let code = coaxle_far_axis_new(&raw const parameters, &raw mut axis);
        assert_eq!(code, COAXLE_OK);
        let name = text("coaxle/arm/plans");
        assert_eq!(coaxle_key_new(name.as_ptr(), &raw mut key), COAXLE_OK);
        let piece = coaxle_motion_piece {
            start_ns: 0,
            duration_ns: 60_000 * CYCLE,
            position: 0.0,
            velocity: 500.0,
            acceleration: 0.0,
            jerk: 0.0,
        };
        let mut plan = coaxle_plan {
            count: 0,
            axis_id: 1,
            number: 1,
            promised_until_ns: 0,
            max_velocity: 500.0,
            max_acceleration: 1.0,
            max_deceleration: 1.0,
            max_jerk: 1.0,
            pieces: [piece; COAXLE_MOST_PIECES],
        };
        let mut bytes = [0; 4096];
        let mut state: coaxle_far_axis_state = sized();
        let mut planned = 0;
        assert_no_alloc(|| {
            for count in 0..4_000_i64 {
                let (mut length, mut epoch, mut number, mut refused) = (0, 0, 0, 0);
                plan.count = count as u64;
                plan.promised_until_ns = count * CYCLE + 3_000 * CYCLE;
                let (given, room) = (&raw mut plan, bytes.as_mut_ptr());
                let code = coaxle_plans_encode(key, 1, 1, given, 1, room, 4096, &raw mut length);
                assert_eq!(code, COAXLE_OK);
                let (epoch, refused) = (&raw mut epoch, &raw mut refused);
                let number = &raw mut number;
                let code = coaxle_plans_decode(key, room, length, epoch, given, 1, number, refused);
                assert_eq!(code, COAXLE_OK);
                assert_eq!(coaxle_far_axis_plan(axis, given), COAXLE_OK);
                // Every second sample is lost; one is no number.
                if count % 2 == 0 {
                    let sample = coaxle_far_sample {
                        count: count as u64,
                        position: if count == 2_000 {
                            f64::NAN
                        } else {
                            0.5 * count as f64
                        },
                        velocity: 500.0,
                        ..sized()
                    };
                    let code = coaxle_far_axis_sample(axis, &raw const sample);
                    assert_eq!(code == COAXLE_OK, count != 2_000);
                }
                let correction = 1e-3 * (count % 2) as f64;
                let correction = &raw const correction;
                let code = coaxle_far_axis_cycle(axis, correction, 1, &raw mut state);
                assert_eq!(code, COAXLE_OK);
                planned += state.is_planned;
            }
        });
        assert!(planned > 1_000 && state.error == 0, "{planned}");
        coaxle_far_axis_free(axis);
        coaxle_key_free(key);
    }
}

#[test]
fn the_master_of_an_encoder() {
    // SAFETY: the rules of the header.
    unsafe {
        let mut parameters: coaxle_encoder_parameters = sized();
        let mut encoder = null_mut();
        assert_eq!(
            coaxle_encoder_parameters_init(&raw mut parameters, 0.01, CYCLE),
            COAXLE_OK
        );
        assert_eq!(
            coaxle_encoder_new(&raw const parameters, &raw mut encoder),
            COAXLE_OK
        );
        let mut state: coaxle_encoder_state = sized();
        assert_no_alloc(|| {
            for cycle in 0..1_000 {
                let sample = coaxle_encoder_sample {
                    count: 50 * cycle,
                    cycles: 1,
                    reserved: 0,
                };
                // An instant that is no number is refused, with a sentence.
                let horizon = [0.0, f64::NAN][usize::from(cycle % 100 == 99)];
                let _ =
                    coaxle_encoder_update(encoder, &raw const sample, horizon, 1, &raw mut state);
            }
        });
        assert!(state.velocity > 499.0, "{} mm/s", state.velocity);
        coaxle_encoder_free(encoder);
    }
}

#[test]
fn a_slave_axis_of_a_program_of_ones_own() {
    // SAFETY: the rules of the header.
    unsafe {
        let parameters = coaxle_slave_parameters {
            cycle_time_ns: CYCLE,
            velocity: 2_000.0,
            acceleration: 10_000.0,
            jerk: 500_000.0,
            axis_id: 2,
            master_axis_id: 1,
            ..sized()
        };
        let mut slave = null_mut();
        assert_eq!(
            coaxle_slave_new(&raw const parameters, &raw mut slave),
            COAXLE_OK
        );
        let mut tables = null_mut();
        assert_eq!(coaxle_tables_new(4, &raw mut tables), COAXLE_OK);
        let mut command: coaxle_command = sized();
        let mut state: coaxle_slave_state = sized();
        let mut master = coaxle_master {
            position: 0.0,
            velocity: 500.0,
            acceleration: 0.0,
            is_there: 1,
            reserved: 0,
        };
        let mut job = 0;
        assert_no_alloc(|| {
            for cycle in 0..3_000 {
                let kind = match cycle {
                    0 => COAXLE_POWER_ON,
                    10 => COAXLE_GEAR_IN_VELO,
                    1_000 => COAXLE_PHASING_RELATIVE,
                    1_500 => COAXLE_GEAR_OUT,
                    1_600 => COAXLE_STOP,
                    // Refused, with a sentence.
                    1_700 => COAXLE_CAM_IN,
                    _ => 0,
                };
                if kind != 0 {
                    let _ = coaxle_command_init(&raw mut command, kind);
                    command.distance = 5.0;
                    let code =
                        coaxle_slave_execute(slave, tables, &raw const command, &raw mut job);
                    assert_eq!(code == COAXLE_OK, kind != COAXLE_CAM_IN, "{cycle}");
                }
                master.position += 0.5;
                let masters = &raw const master;
                let code = coaxle_slave_update(slave, tables, masters, 1, 1e-3, &raw mut state);
                assert_eq!(code, COAXLE_OK);
            }
        });
        coaxle_slave_free(slave);
        coaxle_tables_free(tables);
    }
}

#[test]
fn a_receiver_and_the_messages_of_its_master() {
    const CONFIG: &str = "
        name = \"station\"
        cycle-time-us = 1000
        master = { node = \"conveyor\", modulo = 100 }
        [[slave]]
        name = \"carriage\"
        gear = { ratio = 0.5, offset = 0.0 }
    ";
    // SAFETY: the rules of the header.
    unsafe {
        let parameters: coaxle_receiver_parameters = sized();
        let (name, config) = (text("station.toml"), text(CONFIG));
        let mut station = null_mut();
        let code = coaxle_receiver_new(
            &raw const parameters,
            name.as_ptr(),
            config.as_ptr(),
            &raw mut station,
        );
        assert_eq!(code, COAXLE_OK);
        let mut key = null_mut();
        let axes = text("coaxle/conveyor/axes");
        assert_eq!(coaxle_key_new(axes.as_ptr(), &raw mut key), COAXLE_OK);
        let mut sender = 0;
        assert_eq!(
            coaxle_sender_id(text("conveyor").as_ptr(), &raw mut sender),
            COAXLE_OK
        );
        let mut bytes = [0_u8; COAXLE_MOST_BYTES];
        let mut followed = 0;
        assert_no_alloc(|| {
            for count in 0..3_000 {
                let header = coaxle_frame_header {
                    sender,
                    epoch: 7,
                    count: count as u64,
                    cycle_time_ns: CYCLE,
                    ..sized()
                };
                let axis = coaxle_axis {
                    axis_id: 1,
                    state_word: 3,
                    set_position: 0.5 * count as f64,
                    set_velocity: 500.0,
                    ..coaxle_axis::default()
                };
                let (place, mut length) = (bytes.as_mut_ptr(), 0);
                let header = &raw const header;
                let code = coaxle_frame_encode(
                    key,
                    header,
                    &raw const axis,
                    1,
                    place,
                    bytes.len(),
                    &raw mut length,
                );
                assert_eq!(code, COAXLE_OK);
                // The ways take as long as they do: an odd one, so that arrivals are on no grid.
                let arrived = count * CYCLE + 200_000 + (count * 7_919) % 4_001;
                let code = coaxle_receiver_message(station, 0, arrived, bytes.as_ptr(), length);
                assert_eq!(code, COAXLE_OK);
                let now = count * CYCLE + CYCLE / 2;
                assert_eq!(coaxle_receiver_cycle(station, now), COAXLE_OK);
                let mut key: *const core::ffi::c_char = null();
                while coaxle_receiver_send(
                    station,
                    now,
                    &raw mut key,
                    place,
                    bytes.len(),
                    &raw mut length,
                ) == COAXLE_OK
                    && length > 0
                {}
                let mut axis = coaxle_axis::default();
                if coaxle_receiver_axis(station, 0, &raw mut axis) == COAXLE_OK {
                    let turns = 100.0 * f64::from(axis.modulo_set_turns);
                    assert!((0.0..100.0).contains(&axis.modulo_set_position));
                    assert!((axis.modulo_set_position + turns - axis.set_position).abs() < 1e-9);
                    followed += 1;
                }
            }
        });
        assert!(followed > 2_900, "{followed}");
        coaxle_receiver_free(station);
        coaxle_key_free(key);
    }
}

#[test]
fn a_far_clock_and_a_lock_to_it() {
    // SAFETY: the rules of the header.
    unsafe {
        let parameters = coaxle_far_clock_parameters {
            delay_source: COAXLE_DELAY_MEASURED,
            cycle_time_ns: CYCLE,
            ..sized()
        };
        let mut clock = null_mut();
        assert_eq!(
            coaxle_far_clock_new(&raw const parameters, &raw mut clock),
            COAXLE_OK
        );
        let mut lock = null_mut();
        assert_eq!(
            coaxle_cycle_lock_new(CYCLE, 300_000, &raw mut lock),
            COAXLE_OK
        );
        let mut far: coaxle_far_time = sized();
        let mut phase: coaxle_far_phase = sized();
        let mut locked = 0;
        assert_no_alloc(|| {
            for count in 0..5_000 {
                let message = coaxle_message {
                    has_send_stamp: 1,
                    epoch: 7,
                    count: count as u64,
                    arrived_ns: count * CYCLE + 200_000 + (count * 7_919) % 4_001,
                    ..sized()
                };
                assert_eq!(
                    coaxle_far_clock_message(clock, &raw const message),
                    COAXLE_OK
                );
                let now = count * CYCLE + CYCLE / 2;
                assert_eq!(coaxle_far_clock_cycle(clock, now, &raw mut far), COAXLE_OK);
                let (mut is_due, mut number, mut moved) = (0, 0, 0);
                let _ = coaxle_far_clock_request(clock, now, &raw mut is_due, &raw mut number);
                let phase = &raw mut phase;
                let has_phase =
                    coaxle_far_clock_phase(clock, count as u64, CYCLE, phase) == COAXLE_OK;
                let phase = if has_phase {
                    phase.cast_const()
                } else {
                    null()
                };
                assert_eq!(
                    coaxle_cycle_lock_advance(lock, phase, 1, &raw mut moved),
                    COAXLE_OK
                );
                locked += i32::from(has_phase);
            }
        });
        assert!(far.is_sure != 0 && locked > 1_000, "{locked}");
        coaxle_cycle_lock_free(lock);
        coaxle_far_clock_free(clock);
    }
}

#[test]
fn both_ends_of_the_memory_of_a_drive() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("drive");
    let path = text(path.to_str().expect("UTF-8"));
    // SAFETY: the rules of the header.
    unsafe {
        let parameters = coaxle_drive_memory_parameters {
            cycle_time_ns: CYCLE,
            max_silent_cycles: 5,
            switch_on_cycles: 50,
            following_error_window: 10.0,
            ..sized()
        };
        let (mut node, mut process) = (null_mut(), null_mut());
        let name = text("carriage");
        let code = coaxle_drive_node_new(
            &raw const parameters,
            path.as_ptr(),
            name.as_ptr(),
            &raw mut node,
        );
        assert_eq!(code, COAXLE_OK);
        let code = coaxle_drive_process_new(path.as_ptr(), &raw mut process);
        assert_eq!(code, COAXLE_OK);
        let mut actual: coaxle_actual = sized();
        assert_no_alloc(|| {
            for cycle in 0..1_000 {
                let command = coaxle_drive_memory_command {
                    wants_power: 1,
                    ideal_start_ns: cycle * CYCLE,
                    elapsed_s: 1e-3,
                    ..sized()
                };
                let code = coaxle_drive_node_step(node, &raw const command, &raw mut actual);
                assert_eq!(code, COAXLE_OK);
                let mut set: coaxle_drive_set_values = sized();
                let code = coaxle_drive_process_read(process, null_mut(), &raw mut set);
                assert_eq!((code, set.ideal_start_ns), (COAXLE_OK, cycle * CYCLE));
                let values = coaxle_drive_values {
                    state: COAXLE_PROCESS_FOLLOWING,
                    counter: set.counter,
                    resets: set.resets,
                    ..sized()
                };
                let code = coaxle_drive_process_report(process, &raw const values);
                assert_eq!(code, COAXLE_OK);
            }
        });
        assert_eq!(actual.state, COAXLE_DRIVE_FOLLOWING);
        coaxle_drive_process_free(process);
        coaxle_drive_node_free(node);
    }
}
