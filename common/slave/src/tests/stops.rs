//! A stop that is under way, and what may still take it over.

use std::string::ToString;

use super::*;
use crate::Refusal;
use coaxle_axis::{AxisStatus, CommandState};

fn stop_with(deceleration: f64) -> Command {
    Command::Stop {
        dynamics: Dynamics {
            deceleration: Some(deceleration),
            ..OWN
        },
    }
}

/// An axis at 500 u/s that stops with hardly any deceleration, for so many cycles already.
fn stopping_weakly(cycles: u32) -> (SlaveAxis, Job, Differences) {
    let mut axis = powered(&PARAMETERS);
    start(&mut axis, &move_velocity(500.0));
    run(&mut axis, 500);
    let mut differences = Differences::of(&axis);
    let weak = start(&mut axis, &stop_with(1.0));
    run_within(&mut axis, &mut differences, cycles);
    assert_eq!(axis.status(), AxisStatus::Stopping);
    (axis, weak, differences)
}

fn run_within(axis: &mut SlaveAxis, differences: &mut Differences, cycles: u32) {
    for _ in 0..cycles {
        axis.update(None, CYCLE);
        differences.keep(axis, &PARAMETERS);
    }
}

#[test]
fn a_harder_stop_takes_over_from_a_weaker_one() {
    for cycles in [0, 1, 7, 500] {
        let (mut axis, weak, mut differences) = stopping_weakly(cycles);
        let hard = start(&mut axis, &stop_with(4_000.0));
        assert_eq!(axis.status(), AxisStatus::Stopping);
        assert_eq!(axis.progress(weak), CommandState::Aborted);
        // 500/4000 s, and 4000/100000 s for the jerk.
        run_within(&mut axis, &mut differences, 170);
        assert_eq!(axis.progress(hard), CommandState::Done);
        assert_eq!(axis.status(), AxisStatus::Standstill);
    }
}

#[test]
fn a_stop_that_ends_no_earlier_is_refused() {
    let (mut axis, _, mut differences) = stopping_weakly(100);
    let hard = start(&mut axis, &stop_with(2_000.0));
    run_within(&mut axis, &mut differences, 50);
    for deceleration in [2_000.0, 1_000.0, 1.0] {
        let refused = axis.command(&stop_with(deceleration)).unwrap_err();
        assert_eq!(refused.code(), 0x42ef);
        let Refusal::WeakerStop { received, left } = refused else {
            panic!("{refused}");
        };
        assert!(received >= left * (1.0 - 1e-9), "{refused}");
    }
    let refused = axis.command(&stop_with(1_000.0)).unwrap_err().to_string();
    assert!(refused.starts_with("0x42ef: MC_Stop: the stop would take 0.4"));
    run_within(&mut axis, &mut differences, 300);
    assert_eq!(axis.progress(hard), CommandState::Done);
}

#[test]
fn power_taken_away_overrides_any_stop() {
    for cycles in [0, 3, 800] {
        let (mut axis, weak, mut differences) = stopping_weakly(cycles);
        axis.command(&Command::Power(false)).unwrap();
        assert_eq!(axis.status(), AxisStatus::Stopping);
        assert_eq!(axis.progress(weak), CommandState::Aborted);
        let mut cycles = 0;
        loop {
            run(&mut axis, 1);
            if axis.status() != AxisStatus::Stopping {
                break;
            }
            differences.keep(&axis, &PARAMETERS);
            cycles += 1;
        }
        // 500/4000 s, and 4000/100000 s for the jerk.
        assert!((160..=170).contains(&cycles), "{cycles}");
        assert_eq!(axis.status(), AxisStatus::Disabled);
        assert!(!axis.is_operational());
    }
}

#[test]
fn a_stop_that_is_held_does_not_hold_the_one_that_takes_over() {
    let (mut axis, _, _) = stopping_weakly(10);
    axis.hold_stop(true);
    start(&mut axis, &stop_with(4_000.0));
    run(&mut axis, 200);
    assert_eq!(axis.status(), AxisStatus::Standstill);
    let (mut axis, _, _) = stopping_weakly(10);
    start(&mut axis, &stop_with(4_000.0));
    axis.hold_stop(true);
    run(&mut axis, 200);
    assert_eq!(axis.status(), AxisStatus::Stopping);
    axis.command(&Command::Power(false)).unwrap();
    run(&mut axis, 2);
    assert_eq!(axis.status(), AxisStatus::Disabled);
}
