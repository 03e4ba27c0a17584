//! The axis in a PLC program.

use coaxle_axis::{AxisStatus, CommandState};
use coaxle_gear::FlyingGearParameters;

use super::*;
use crate::{CommandBlock, EnableFlyingGear, Outputs, Power};

#[test]
fn power_follows_its_level() {
    let mut axis = axis(&PARAMETERS);
    let mut power = Power::default();
    assert!(!power.scan(false, &mut axis, &mut Tables::new(0)).status);
    let on = power.scan(true, &mut axis, &mut Tables::new(0));
    assert!(on.status && on.busy && !on.error);
    assert_eq!(axis.status(), AxisStatus::Standstill);
    power.scan(false, &mut axis, &mut Tables::new(0));
    assert_eq!(axis.status(), AxisStatus::Disabled);
}

#[test]
fn a_pulse_moves_the_axis_and_shows_done_for_one_scan() {
    let mut axis = powered(&PARAMETERS);
    let mut block = CommandBlock::default();
    let command = move_absolute(1.0);
    assert_eq!(
        block.scan(true, &command, &mut axis, &mut Tables::new(0)),
        CommandState::Active
    );
    let mut done = 0;
    // Far longer than 1 u takes: Done must not come back.
    for _ in 0..500 {
        axis.update(&mut Tables::new(0), None, CYCLE);
        done += u32::from(
            block.scan(false, &command, &mut axis, &mut Tables::new(0)) == CommandState::Done,
        );
    }
    assert_eq!(done, 1);
    assert_eq!(axis.set().position, 1.0);
}

#[test]
fn a_block_sees_that_another_took_over() {
    let mut axis = powered(&PARAMETERS);
    let (mut first, mut second) = (CommandBlock::default(), CommandBlock::default());
    first.scan(true, &move_absolute(100.0), &mut axis, &mut Tables::new(0));
    run(&mut axis, 10);
    second.scan(true, &move_absolute(-100.0), &mut axis, &mut Tables::new(0));
    assert_eq!(
        first.scan(true, &move_absolute(100.0), &mut axis, &mut Tables::new(0)),
        CommandState::Aborted
    );
}

#[test]
fn a_block_that_was_done_does_not_turn_into_aborted() {
    let mut axis = powered(&PARAMETERS);
    let (mut first, mut second) = (CommandBlock::default(), CommandBlock::default());
    first.scan(true, &move_absolute(1.0), &mut axis, &mut Tables::new(0));
    run(&mut axis, 500);
    // The second is called before the first has been called again.
    second.scan(true, &move_absolute(2.0), &mut axis, &mut Tables::new(0));
    assert_eq!(
        first.scan(true, &move_absolute(1.0), &mut axis, &mut Tables::new(0)),
        CommandState::Done
    );
}

#[test]
fn a_stop_that_is_executed_keeps_the_axis_in_stopping() {
    let mut axis = powered(&PARAMETERS);
    let mut stop = CommandBlock::default();
    start(&mut axis, &move_velocity(100.0));
    run(&mut axis, 500);
    let mut state = CommandState::Idle;
    // Long after the axis stands: only Execute keeps the state.
    for _ in 0..1_000 {
        state = stop.scan(true, &STOP, &mut axis, &mut Tables::new(0));
        run(&mut axis, 1);
    }
    assert_eq!(state, CommandState::Done);
    assert_eq!(axis.status(), AxisStatus::Stopping);
    assert_eq!(
        axis.command(&mut Tables::new(0), &move_absolute(0.0))
            .map_err(|r| r.code()),
        Err(0x42ef)
    );
    stop.scan(false, &STOP, &mut axis, &mut Tables::new(0));
    run(&mut axis, 1);
    assert_eq!(axis.status(), AxisStatus::Standstill);
}

#[test]
fn a_refused_command_is_an_error_with_its_code() {
    let mut axis = axis(&PARAMETERS);
    let mut block = CommandBlock::default();
    let state = block.scan(true, &move_absolute(1.0), &mut axis, &mut Tables::new(0));
    let outputs = Outputs::of(&state, JobError::code);
    assert!(outputs.error && !outputs.busy);
    assert_eq!(outputs.error_id, 0x422a);
}

#[test]
fn the_flying_gear_block_shows_its_windows() {
    let gear = FlyingGearParameters {
        ratio: 1.0,
        master_sync_position: 100.0,
        slave_sync_position: 40.0,
        slave_desync_position: 100.0,
        slave_stop_position: 120.0,
        default_slave_negative: false,
    };
    let mut axis = powered(&PARAMETERS);
    let mut block = EnableFlyingGear::default();
    let mut master = Master::at(0.0, 100.0);
    master.lead(&mut axis, 1);
    let mut seen = std::vec::Vec::new();
    for _ in 0..3_000 {
        let o = block.scan(true, &gear, &mut axis, &mut Tables::new(0));
        let shown = [o.start_sync, o.in_sync, o.active, o.busy];
        if seen.last() != Some(&shown) {
            seen.push(shown);
        }
        master.lead(&mut axis, 1);
    }
    assert_eq!(
        seen,
        [
            // Enabled and waiting, engaging, coupled, releasing, and past the stop position.
            [false, false, false, true],
            [true, false, true, true],
            [false, true, true, true],
            [false, false, true, true],
            [false, false, false, true],
        ]
    );
    let off = block.scan(false, &gear, &mut axis, &mut Tables::new(0));
    assert!(!off.busy && !off.error);
    assert_eq!(axis.status(), AxisStatus::Standstill);
    // The master is past the start point of another one.
    let farther = FlyingGearParameters {
        slave_sync_position: 140.0,
        slave_desync_position: 200.0,
        slave_stop_position: 220.0,
        ..gear
    };
    let again = block.scan(true, &farther, &mut axis, &mut Tables::new(0));
    assert!(again.error && !again.busy);
    assert_eq!(again.error_id, 0x421a);
}
