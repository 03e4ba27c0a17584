//! A master that runs back past the coupling position: TS5055 8.

use std::vec::Vec;

use super::saws::{beside, to_position};
use super::*;
use coaxle_axis::{AxisState, AxisStatus, CommandState, Masters, TravelDirection};
use coaxle_saw::SyncMask;

/// Couples at 0, and reverses the master before or after the slave is synchronous.
fn there_and_back(mask: SyncMask, reached: bool) -> (AxisWithPlates, Job, Vec<Kinematics>) {
    let parameters = SlaveParameters {
        deceleration: Some(2_500.0),
        ..PARAMETERS
    };
    let (mut axis, mut master) = beside(&parameters, 500.0);
    start(&mut axis, &move_velocity(250.0));
    master.lead(&mut axis, 1_000);
    let start_at = (master.0.position, axis.set().position);
    let sync = (start_at.0 + 1_000.0, start_at.1 + 1_100.0);
    let job = start(&mut axis, &Command::from(to_position(sync, mask)));
    master.lead(&mut axis, if reached { 2_500 } else { 1_000 });
    assert_eq!(axis.progress(job) == CommandState::InSync, reached);
    while master.0.velocity > -500.0 {
        master.0.velocity -= 1.0;
        master.0.acceleration = -1_000.0;
        master.lead(&mut axis, 1);
    }
    master.0.acceleration = 0.0;
    let mut seen = Vec::new();
    while master.0.position > start_at.0 - 500.0 {
        seen.push(axis.set());
        master.lead(&mut axis, 1);
    }
    for slave in &mut seen {
        slave.position -= start_at.1;
    }
    (axis, job, seen)
}

#[test]
fn the_eight_cases_of_a_rollback() {
    let lock = SyncMask::ROLLBACK_LOCK;
    let instant = SyncMask::INSTANT_STOP_ON_ROLLBACK;
    let none = SyncMask::empty();
    let cases = [
        (none, true),
        (none, false),
        (instant, false),
        (instant, true),
        (lock, false),
        (lock, true),
        (lock | instant, false),
        (lock | instant, true),
    ];
    for (number, (mask, reached)) in (1..).zip(cases) {
        let (axis, job, seen) = there_and_back(mask, reached);
        assert_eq!(axis.error(), None, "case {number}");
        if reached && !mask.contains(lock) {
            assert_eq!(axis.progress(job), CommandState::InSync, "case {number}");
            assert!(!axis.was_rolled_back(job), "case {number}");
            assert_eq!(axis.set().velocity, -500.0, "case {number}");
            continue;
        }
        assert_eq!(axis.progress(job), CommandState::Aborted, "case {number}");
        assert!(axis.was_rolled_back(job), "case {number}");
        assert_eq!(axis.status(), AxisStatus::Standstill, "case {number}");
        assert_eq!(axis.axis_struct(1).axis_state, AxisState::Inactive);
        // Position and velocity of the slave as its master passes the coupling position.
        let (position, velocity): (f64, f64) = if reached {
            (100.0, -500.0)
        } else {
            (0.0, -250.0)
        };
        let last = seen
            .iter()
            .rposition(|slave| slave.velocity != 0.0)
            .unwrap();
        let (moving, standing) = (seen[last], seen[last + 1]);
        if mask.contains(instant) {
            assert!(
                (moving.velocity - velocity).abs() < 0.01 * velocity.abs(),
                "case {number}"
            );
            assert!((standing.position - position).abs() < 1e-2, "case {number}");
        } else {
            let ramp = f64::max(
                1.5 * velocity.abs() / 2_475.0,
                libm::sqrt(6.0 * velocity.abs() / 100_000.0),
            );
            let end = position + velocity * ramp / 2.0;
            assert!(
                (standing.position - end).abs() < 1e-2,
                "case {number}: {standing:?} {end}"
            );
        }
    }
}

#[test]
fn a_rollback_stop_can_be_taken_over() {
    let (mut axis, mut master) = beside(&PARAMETERS, 500.0);
    start(&mut axis, &move_velocity(250.0));
    master.lead(&mut axis, 1_000);
    let sync = (master.0.position + 1_000.0, axis.set().position + 1_100.0);
    start(
        &mut axis,
        &Command::from(to_position(sync, SyncMask::empty())),
    );
    master.lead(&mut axis, 500);
    while master.0.velocity > -500.0 {
        master.0.velocity -= 1.0;
        master.0.acceleration = -1_000.0;
        master.lead(&mut axis, 1);
    }
    master.0.acceleration = 0.0;
    while axis.status() == AxisStatus::SynchronizedMotion {
        master.lead(&mut axis, 1);
    }
    assert_eq!(axis.status(), AxisStatus::DiscreteMotion);
    assert_eq!(axis.axis_struct(1).axis_state, AxisState::Decelerating);
    // A master that is lost does not matter any more.
    run(&mut axis, 10);
    assert!(axis.set().velocity < 0.0);
    let home = start(&mut axis, &move_absolute(0.0));
    run(&mut axis, 3_000);
    assert_eq!(axis.progress(home), CommandState::Done);
    assert_eq!(axis.set(), Kinematics::at_rest(0.0));
}

#[test]
fn a_rollback_stop_goes_on_from_the_acceleration_of_the_slave() {
    for turned in [400, 500, 700, 900] {
        for mask in [SyncMask::empty(), SyncMask::ROLLBACK_LOCK] {
            let (mut axis, mut master) = beside(&PARAMETERS, 500.0);
            start(&mut axis, &move_velocity(250.0));
            master.lead(&mut axis, 1_000);
            let sync = (master.0.position + 1_000.0, axis.set().position + 1_100.0);
            start(&mut axis, &Command::from(to_position(sync, mask)));
            master.lead(&mut axis, turned);
            // The master is led back with little jerk, so that the slave follows within its own.
            let mut differences = Differences::of(&axis);
            let mut coupled = true;
            for _ in 0..3_000 {
                let pull = if master.0.velocity > -900.0 {
                    -800.0
                } else {
                    0.0
                };
                master.accelerate(&mut axis, pull, 4_000.0);
                differences.keep(&axis, &PARAMETERS);
                coupled &= axis.status() == AxisStatus::SynchronizedMotion;
            }
            assert!(!coupled && axis.error().is_none(), "{:?}", axis.error());
            assert_eq!(axis.set().velocity, 0.0);
        }
    }
}

/// A measured master that moves on by its increments is not back, for any position; unless it is
/// shifted back.
#[test]
fn increments_that_go_on_are_no_rollback() {
    for (shift, stops) in [(0.0, false), (-300.0, true)] {
        let (mut axis, mut master) = beside(&PARAMETERS, 100.0);
        let sync = (master.0.position + 200.0, axis.set().position + 100.0);
        let saw = Command::from(to_position(sync, SyncMask::ROLLBACK_LOCK));
        start(&mut axis, &saw);
        let mut lead = |axis: &mut AxisWithPlates, step: f64| {
            master.0.position += step;
            let mut masters = Masters::default();
            masters.put(0, &master.0, Some(TravelDirection::Forward));
            axis.update(masters, CYCLE);
        };
        lead(&mut axis, 0.1);
        lead(&mut axis, -0.15);
        assert_eq!(axis.status(), AxisStatus::SynchronizedMotion);
        let shifting = Command::PhasingRelative {
            shift,
            velocity: Some(200.0),
            dynamics: Dynamics {
                acceleration: Some(1_000.0),
                deceleration: None,
                jerk: Some(1e5),
            },
        };
        if shift != 0.0 {
            start(&mut axis, &shifting);
        }
        for _ in 0..4_000 {
            lead(&mut axis, 0.1);
        }
        assert_eq!(axis.error(), None);
        let was_stopped = axis.status() != AxisStatus::SynchronizedMotion;
        assert_eq!(was_stopped, stops, "shifted by {shift}");
    }
}
