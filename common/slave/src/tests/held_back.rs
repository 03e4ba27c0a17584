//! An axis whose drive shows its set values later: commands wait, stops do not, and its drive never steps.

use std::vec::Vec;

use super::*;
use crate::{CoupledStart, SlaveError};
use coaxle_axis::AxisStatus;
use coaxle_gear::LinearGear;

const BY: Span = Span::from_millis(40);

/// Set values that the drive was given, cycle by cycle, with the limits that its differences have to keep.
struct Given(Vec<f64>);

impl Given {
    fn take(&mut self, axis: &AxisWithPlates) {
        self.0.push(axis.shown().position);
    }

    /// Greatest acceleration and jerk of the differences.
    fn hardest(&self) -> (f64, f64) {
        let differences = |of: &[f64]| -> Vec<f64> {
            of.windows(2)
                .map(|pair| (pair[1] - pair[0]) * 1e3)
                .collect()
        };
        let most = |of: &[f64]| of.iter().fold(0.0_f64, |most, one| most.max(one.abs()));
        let accelerations = differences(&differences(&self.0));
        (most(&accelerations), most(&differences(&accelerations)))
    }
}

fn held_back() -> AxisWithPlates {
    let mut axis = axis(&PARAMETERS);
    axis.prepare_hold_back();
    axis.set_hold_back(BY);
    start(&mut axis, &Command::Power(true));
    run(&mut axis, 5);
    assert_eq!(axis.held_back_by(), BY);
    axis
}

/// Moves to 300 mm; returns the set values, and those that the drive was given.
fn moved(axis: &mut AxisWithPlates) -> (Vec<Kinematics>, Vec<Kinematics>) {
    start(axis, &move_absolute(300.0));
    (0..2_000)
        .map(|_| (axis.update(None, CYCLE), axis.shown()))
        .unzip()
}

fn run_with(axis: &mut AxisWithPlates, given: &mut Given, cycles: u32) {
    for _ in 0..cycles {
        axis.update(None, CYCLE);
        given.take(axis);
    }
}

#[test]
fn a_motion_is_shown_later_with_its_own_bits() {
    let mut axis = held_back();
    let (early, shown) = moved(&mut axis);
    assert_eq!(early[..1_960], shown[40..]);
    assert!(
        axis.rests()
            && shown[..40]
                .iter()
                .all(|set| *set == Kinematics::at_rest(0.0))
    );
}

#[test]
fn a_halt_is_a_command_and_waits() {
    let mut axis = held_back();
    start(&mut axis, &move_velocity(500.0));
    run(&mut axis, 1_000);
    start(&mut axis, &HALT);
    run(&mut axis, 40);
    assert_eq!(axis.shown().velocity, 500.0);
    run(&mut axis, 5);
    assert!(axis.shown().velocity < 500.0 && axis.set_back_count() == 0);
}

/// The hold-back of a drive with a dead time is shorter.
#[test]
fn a_dead_time_is_taken_from_the_hold_back_with_its_own_bits() {
    let mut axis = axis(&PARAMETERS);
    axis.set_dead_time(Span::from_millis(4));
    axis.prepare_hold_back();
    axis.set_hold_back(BY);
    start(&mut axis, &Command::Power(true));
    run(&mut axis, 5);
    assert_eq!(axis.held_back_by(), BY - Span::from_millis(4));
    let (early, shown) = moved(&mut axis);
    assert_eq!(early[..1_964], shown[36..]);
}

/// Without a hold-back, and with a part of one, the rest is predicted.
#[test]
fn what_a_hold_back_lacks_for_a_dead_time_is_predicted() {
    for (hold_back, ahead) in [(0, 8), (3, 5)] {
        let mut axis = axis(&PARAMETERS);
        axis.set_dead_time(Span::from_millis(8));
        axis.prepare_hold_back();
        axis.set_hold_back(Span::from_millis(hold_back));
        start(&mut axis, &Command::Power(true));
        run(&mut axis, 5);
        let (truth, given) = moved(&mut axis);
        assert_eq!(axis.held_back_by(), Span::ZERO);
        // jerk · time³ / 6, and twice that where the jerk turns.
        let bound = 2.0 * 100_000.0 * (ahead as f64 * 1e-3).powi(3) / 6.0;
        let errors = truth[ahead..]
            .iter()
            .zip(&given)
            .map(|(truth, given)| (truth.position - given.position).abs());
        let worst = errors.fold(0.0, f64::max);
        assert!(worst < bound && worst > 0.1 * bound, "{worst} of {bound}");
        assert_eq!(given[1_999], truth[1_999]);
        // A stop begins from the axis, without a step of what the drive is given.
        start(&mut axis, &move_velocity(500.0));
        let mut given = Given(Vec::new());
        run_with(&mut axis, &mut given, 150);
        start(&mut axis, &STOP);
        run_with(&mut axis, &mut given, 1_000);
        let (acceleration, _) = given.hardest();
        // The velocity steps by `jerk · time² / 2` as the jerk comes and goes, by twice that as it turns.
        let time = ahead as f64 * 1e-3;
        let most = 5_000.0 + 100_000.0 * time + 100_000.0 * time * time / 1e-3;
        assert!(acceleration < most * 1.001, "{acceleration} of {most}");
        assert_eq!(axis.set_back_count(), 0);
    }
}

#[test]
fn a_drive_with_a_dead_time_is_switched_on_where_the_axis_is_shown() {
    for (hold_back, shown) in [(40, 160.0), (2, 198.0), (0, 200.0)] {
        let mut axis = axis(&PARAMETERS);
        axis.set_dead_time(Span::from_millis(4));
        axis.prepare_hold_back();
        axis.set_hold_back(Span::from_millis(hold_back));
        let master = Master::at(100.0, 500.0);
        let start = CoupledStart::Gear(LinearGear::new(2.0, 0.0).expect("a gear"));
        assert!(axis.switch_on_coupled(&start, Some(&master.0)).is_ok());
        assert!((axis.actual().position - shown).abs() < 1e-9);
        // Given 4 ms earlier.
        assert!((axis.shown().position - shown - 4.0).abs() < 1e-9);
    }
}

/// Runs to a ramp, where what is shown differs from what is calculated in everything.
fn on_a_ramp() -> (AxisWithPlates, Given) {
    let mut axis = held_back();
    let mut given = Given(Vec::new());
    start(&mut axis, &move_velocity(800.0));
    run_with(&mut axis, &mut given, 100);
    assert!(axis.shown().velocity < axis.set().velocity);
    (axis, given)
}

fn assert_brakes_at_once(mut axis: AxisWithPlates, mut given: Given, shown: Kinematics) {
    assert_eq!(axis.set_back_count(), 1);
    assert_eq!(axis.held_back_by(), Span::ZERO);
    // A cycle from there on.
    let moved = axis.shown().position - shown.position;
    assert!((moved - shown.velocity * 1e-3).abs() < 0.02, "{moved}");
    run_with(&mut axis, &mut given, 1_000);
    let (acceleration, jerk) = given.hardest();
    assert!(acceleration < 5_000.0 * 1.001, "{acceleration}");
    assert!(jerk < 100_000.0 * 1.01, "{jerk}");
    assert!(axis.stands());
    // From rest on it is held back again.
    assert_eq!(axis.held_back_by(), BY);
}

#[test]
fn a_stop_acts_on_what_is_shown() {
    let (mut axis, mut given) = on_a_ramp();
    let shown = axis.shown();
    start(&mut axis, &STOP);
    run_with(&mut axis, &mut given, 1);
    assert_eq!(axis.status(), AxisStatus::Stopping);
    assert_brakes_at_once(axis, given, shown);
}

#[test]
fn a_loss_of_power_acts_on_what_is_shown() {
    let (mut axis, mut given) = on_a_ramp();
    let shown = axis.shown();
    start(&mut axis, &Command::Power(false));
    run_with(&mut axis, &mut given, 1);
    assert_eq!(axis.set_back_count(), 1);
    let moved = axis.shown().position - shown.position;
    assert!((moved - shown.velocity * 1e-3).abs() < 0.02, "{moved}");
    run_with(&mut axis, &mut given, 1_000);
    assert_eq!(axis.status(), AxisStatus::Disabled);
}

/// The master goes on, ahead of what is shown.
#[test]
fn a_lost_master_brakes_what_is_shown() {
    let mut axis = held_back();
    let mut given = Given(Vec::new());
    let mut master = Master::at(0.0, 0.0);
    master.lead(&mut axis, 1);
    start(&mut axis, &Command::GearIn(GearIn::of(1.0)));
    for cycle in 0..150 {
        let wanted = if cycle < 100 { 4_000.0 } else { 0.0 };
        master.accelerate(&mut axis, wanted, 80_000.0);
        given.take(&axis);
    }
    let shown = axis.shown();
    assert!(axis.set().position > shown.position + 5.0);
    run_with(&mut axis, &mut given, 1);
    assert_eq!(axis.error(), Some(SlaveError::MasterLost));
    assert_brakes_at_once(axis, given, shown);
}

#[test]
fn power_off_at_rest_waits_for_what_is_still_shown() {
    let mut axis = held_back();
    let mut given = Given(Vec::new());
    start(&mut axis, &move_absolute(50.0));
    while axis.status() != AxisStatus::Standstill {
        run_with(&mut axis, &mut given, 1);
    }
    assert!(axis.shown().velocity > 0.0);
    start(&mut axis, &Command::Power(false));
    run_with(&mut axis, &mut given, 1);
    assert!(axis.status() != AxisStatus::Disabled && axis.is_operational());
    // Without power the axis is where its drive is.
    loop {
        run(&mut axis, 1);
        if axis.status() == AxisStatus::Disabled {
            break;
        }
        given.take(&axis);
    }
    let (acceleration, _) = given.hardest();
    assert!(acceleration < 5_000.0 * 1.001, "{acceleration}");
}

#[test]
fn homing_moves_no_drive() {
    let mut axis = held_back();
    start(&mut axis, &move_absolute(50.0));
    while axis.status() != AxisStatus::Standstill {
        run(&mut axis, 1);
    }
    let before = axis.shown().position;
    start(&mut axis, &Command::Home { position: 1_000.0 });
    run(&mut axis, 1);
    let after = axis.shown().position - 950.0;
    assert!(after >= before && after - before < 1.0, "{before} {after}");
    run(&mut axis, 100);
    assert_eq!(axis.shown().position, 1_000.0);
}

#[test]
fn coupled_from_the_start_its_drive_comes_to_the_first_set_value_in_time() {
    let mut axis = axis(&PARAMETERS);
    axis.prepare_hold_back();
    axis.set_hold_back(BY);
    let mut master = Master::at(100.0, 500.0);
    let start = CoupledStart::Gear(LinearGear::new(2.0, 0.0).expect("a gear"));
    let job = axis.switch_on_coupled(&start, Some(&master.0));
    assert!(job.is_ok());
    assert_eq!(axis.set().position, 200.0);
    assert!((axis.shown().position - 160.0).abs() < 1e-9);
    for cycle in 1..200 {
        master.lead(&mut axis, 1);
        let expected = 2.0 * (100.0 + 0.5 * f64::from(cycle - 40));
        assert!((axis.shown().position - expected).abs() < 1e-9, "{cycle}");
    }
    assert!(axis.is_operational());
}

/// In swarm schedule 60591 the clock of the master was lost in the cycle of the start, and the hold-back with it: a stop in that cycle would have set
/// the axis back to where it had stood without power.
#[test]
fn coupled_as_its_hold_back_ends_it_is_shown_where_it_begins() {
    let mut axis = axis(&PARAMETERS);
    axis.prepare_hold_back();
    axis.set_hold_back(BY);
    run(&mut axis, 5);
    assert_eq!((axis.held_back_by(), axis.shown().position), (BY, 0.0));
    axis.set_hold_back(Span::ZERO);
    let master = Master::at(14.0, 0.9);
    let start = CoupledStart::Gear(LinearGear::new(2.0, 0.0).expect("a gear"));
    assert!(axis.switch_on_coupled(&start, Some(&master.0)).is_ok());
    assert_eq!(axis.shown().position, 28.0);
    assert_eq!(axis.held_back_by(), Span::ZERO);
}

/// A hold-back that is not prepared, and one of zero, leave every bit alone.
#[test]
fn without_a_hold_back_nothing_changes() {
    let motion = |prepare: fn(&mut AxisWithPlates)| {
        let mut axis = axis(&PARAMETERS);
        prepare(&mut axis);
        start(&mut axis, &Command::Power(true));
        run(&mut axis, 5);
        start(&mut axis, &move_velocity(500.0));
        let mut seen = Vec::new();
        for cycle in 0..1_000 {
            if cycle == 400 {
                start(&mut axis, &STOP);
            }
            seen.push(axis.update(None, CYCLE));
            assert_eq!(axis.shown(), axis.set());
        }
        (seen, axis.actual().position)
    };
    let plain = motion(|_| {});
    assert_eq!(plain, motion(|axis| axis.prepare_hold_back()));
    assert_eq!(plain, motion(|axis| axis.set_hold_back(BY)));
}
