//! A stop under way, and the commands that can take it over.

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

/// An axis at 500 u/s that has been stopping with hardly any deceleration for this number of cycles.
fn stopping_weakly(cycles: u32) -> (AxisWithPlates, Job, Differences) {
    let mut axis = powered(&PARAMETERS);
    start(&mut axis, &move_velocity(500.0));
    run(&mut axis, 500);
    let mut differences = Differences::of(&axis);
    let weak = start(&mut axis, &stop_with(1.0));
    run_within(&mut axis, &mut differences, cycles);
    assert_eq!(axis.status(), AxisStatus::Stopping);
    (axis, weak, differences)
}

fn run_within(axis: &mut AxisWithPlates, differences: &mut Differences, cycles: u32) {
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

/// The set positions of an axis, and the number of presets to the drive's position.
fn traced(axis: &mut AxisWithPlates, cycles: u32) -> std::vec::Vec<(AxisStatus, Kinematics, u32)> {
    let mut cycle = |_| {
        axis.update(None, CYCLE);
        (axis.status(), axis.set(), axis.preset_count())
    };
    (0..cycles).map(&mut cycle).collect()
}

#[test]
fn the_power_goes_after_a_cycle_at_rest() {
    let mut axis = powered(&PARAMETERS);
    start(&mut axis, &move_velocity(500.0));
    let mut trace = traced(&mut axis, 500);
    axis.command(&Command::Power(false)).unwrap();
    trace.extend(traced(&mut axis, 300));
    let off = trace
        .iter()
        .position(|(status, ..)| *status == AxisStatus::Disabled)
        .expect("it stops");
    let [.., (_, older, _), (_, last, before), (_, now, after)] = trace[..=off] else {
        panic!("{off}");
    };
    assert_eq!(last, Kinematics::at_rest(older.position));
    assert_eq!((now.velocity, now.acceleration), (0.0, 0.0));
    assert_eq!(after, before + 1, "the step to where the drive is");
    assert_eq!(now.position, axis.actual_position());
    assert_eq!(trace.last(), Some(&(AxisStatus::Disabled, now, after)));
}

#[test]
fn power_taken_away_as_a_motion_ends_goes_after_a_cycle_at_rest_too() {
    let mut axis = powered(&PARAMETERS);
    start(&mut axis, &move_absolute(10.0));
    while axis.status() != AxisStatus::Standstill {
        run(&mut axis, 1);
    }
    let (last, before) = (axis.set(), axis.preset_count());
    axis.command(&Command::Power(false)).unwrap();
    assert_eq!(axis.status(), AxisStatus::Stopping);
    let trace = traced(&mut axis, 3);
    assert_eq!(trace[0], (AxisStatus::Stopping, last, before));
    assert_eq!((trace[2].0, trace[2].2), (AxisStatus::Disabled, before + 1));
}

/// Wide schedule 200075: the blend of a far axis began, and its velocity was stated in the cycle before its positions had it; in the next the
/// master was lost. The quick stop from there took 1.17 times the deceleration, by its positions.
#[test]
fn a_quick_stop_goes_on_from_a_velocity_that_its_positions_can_have() {
    let parameters = SlaveParameters {
        on_master_loss: OnMasterLoss::QuickStop,
        ..SlaveParameters::new(1_000.0, 5_000.0, 1e8)
    };
    for beside in [0.0, 2.0, -2.0, 3.35, -3.35, 4.9] {
        let mut axis = powered(&parameters);
        let mut master = Master::at(0.0, 100.0);
        master.lead(&mut axis, 1);
        start(&mut axis, &Command::GearIn(GearIn::of(1.0)));
        master.lead(&mut axis, 500);
        let mut positions = std::vec![axis.set().position];
        let mut stated = std::vec![axis.set().velocity];
        master.lead(&mut axis, 1);
        positions.push(axis.set().position);
        master.0.position += 0.1;
        master.0.velocity -= beside;
        axis.update(Some(&master.0), CYCLE);
        for _ in 0..60 {
            positions.push(axis.set().position);
            stated.push(axis.set().velocity);
            run(&mut axis, 1);
        }
        assert_eq!(axis.status(), AxisStatus::ErrorStop);
        assert_eq!(axis.set().velocity, 0.0);
        let dt = CYCLE.0;
        let seconds = (positions.windows(3)).map(|w| (w[2] - 2.0 * w[1] + w[0]) / (dt * dt));
        let hardest = seconds.fold(0.0, |most: f64, now| most.max(now.abs()));
        assert!(hardest <= 5_000.0 * (1.0 + 1e-6), "{beside}: {hardest}");
        let steps = stated.windows(2).map(|w| (w[1] - w[0]) / dt);
        let step = steps.fold(0.0, |most: f64, now| most.max(now.abs()));
        // What was stated beside the positions is given up on top of it.
        assert!(step <= 1.5 * 5_000.0, "{beside}: {step}");
    }
}

/// A gear that the axis cannot follow accelerates it to its highest velocity; the drive fails
/// meanwhile. The start state of the stop has less acceleration, which would exceed that velocity;
/// the stated one has not.
#[test]
fn an_error_stop_goes_on_from_what_was_stated() {
    let parameters = SlaveParameters {
        deceleration: Some(28_161.352_748_847_23),
        ..SlaveParameters::new(
            9.759_458_247_201_72,
            37_393.427_883_364_97,
            14_753.620_576_664_2,
        )
    };
    let drive = drive(0.002_314_739_848_554_424_8);
    let mut axis = AxisWithPlates::new(&parameters, drive, cycle_time()).expect("in range");
    start(&mut axis, &Command::Power(true));
    let mut master = Master::at(0.0, 0.0);
    master.lead(&mut axis, 1);
    start(
        &mut axis,
        &Command::GearIn(GearIn::of(-1.737_355_570_283_625_2)),
    );
    let mut differences = Differences::of(&axis);
    for _ in 0..200 {
        master.accelerate(&mut axis, -1_000.0, 1e6);
        differences.keep(&axis, &parameters);
    }
    assert!(matches!(axis.error(), Some(crate::SlaveError::Drive(_))));
}
