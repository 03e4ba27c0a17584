//! The limits of a slave, checked on the differences of its set positions, for any fault of its master.

use std::slice::from_mut;

use crate::bench::{Far, MILLISECOND, Nanos, Near, SECOND, VELOCITY, run, run_pair};
use coaxle_axis::AxisStatus;
use coaxle_receiver::ContinuityState::{Following, Rejoining};
use coaxle_receiver::{GuardState, HealthName};
use coaxle_slave::Command;

const CYCLE: f64 = 1e-3;
const MODES: [&str; 5] = ["bypass", "pt1", "sync", "time", "observer"];

/// Limits far below the dynamics of a beat, and below those for braking the far axis.
const FASTEST: f64 = 1_000.0;
const HARDEST: f64 = 1_000.0;
const JERK: f64 = 100_000.0;

/// Swarm schedules 143 and 630: at the beats of its master an axis with limits of its own was never shown as following, nor in sync.
#[test]
fn a_far_axis_with_limits_follows_a_master_that_comes_in_beats() {
    for mode in ["bypass", "pt1"] {
        for (fastest, follows) in [(FASTEST, Following), (0.9 * VELOCITY, Rejoining)] {
            // A frame every four cycles is a step of 2 u.
            let mut far = Far::new(4_000, 200, 0, 1);
            let limits = format!(
                "limits = {{ velocity = {fastest:?}, acceleration = {HARDEST:?}, jerk = {JERK:?} }}"
            );
            let head = format!("mode = '{mode}'\nsync.time-sync.automatic-re-init = true");
            let mut near = Near::with_master(1_000, 0, &limits, &head);
            run_pair(&mut far, &mut near, 20 * SECOND);
            let last = &near.snapshots[near.snapshots.len() - 1_000..];
            let states = last.iter().map(|shown| shown.axis.continuity);
            assert!(states.clone().all(|state| state == follows), "{mode}");
            let positions = last
                .iter()
                .filter_map(|shown| shown.axis.corrected_position);
            check_positions(mode, &positions.collect::<Vec<_>>());
        }
    }
}

/// A receiver whose slave follows 1:1 within its limits.
fn receiver(mode: &str, on_master_loss: &str) -> Near {
    let rest = format!(
        "mode = '{mode}'\nsync.time-sync.automatic-re-init = true\nslave = [{{ limits = {{ \
         velocity = {FASTEST:?}, acceleration = {HARDEST:?}, jerk = {JERK:?}, \
         on-master-loss = '{on_master_loss}', distance.window = 300 }} }}]\n"
    );
    Near::new(1000, 0, &rest)
}

/// Checks velocity, acceleration and jerk of the set positions, from the coupling on.
fn check(what: &str, near: &Near) {
    let sets = near.snapshots.iter().filter_map(|shown| shown.slave());
    check_positions(what, &sets.map(|set| set.position).collect::<Vec<f64>>());
}

fn check_positions(what: &str, positions: &[f64]) {
    let differences = |values: &[f64]| -> Vec<f64> {
        let pairs = values.windows(2);
        pairs.map(|pair| (pair[1] - pair[0]) / CYCLE).collect()
    };
    let velocities = differences(positions);
    let accelerations = differences(&velocities);
    let jerks = differences(&accelerations);
    // Rounding in the differences of positions as large as these.
    let rounding = 4.0
        * f64::EPSILON
        * positions
            .iter()
            .fold(FASTEST, |most: f64, p| most.max(p.abs()));
    for (quantity, values, limit, rounding) in [
        ("velocity", velocities, FASTEST, rounding / CYCLE),
        (
            "acceleration",
            accelerations,
            HARDEST,
            2.0 * rounding / CYCLE.powi(2),
        ),
        ("jerk", jerks, JERK, 4.0 * rounding / CYCLE.powi(3)),
    ] {
        let most = values
            .iter()
            .fold(0.0, |most: f64, value| most.max(value.abs()));
        assert!(
            most <= limit * (1.0 + 1e-9) + rounding,
            "{what}: {quantity} {most}, at most {limit}"
        );
    }
}

/// Checks that it has finally arrived at its master's position, without an error on the way.
fn has_arrived(what: &str, near: &Near) {
    let last = near.last();
    let errors = near
        .snapshots
        .iter()
        .filter(|shown| shown.slaves[0].error.is_some());
    assert_eq!(errors.count(), 0, "{what}");
    assert_eq!(last.health.name(), HealthName::Ok, "{what}");
    assert_eq!(
        last.slaves[0].status,
        AxisStatus::SynchronizedMotion,
        "{what}"
    );
    assert_eq!(last.slaves[0].guard, GuardState::Tracking, "{what}");
    assert_eq!(last.slaves[0].distance, 0.0, "{what}");
    let master = last.master.expect("there is one").corrected;
    assert_eq!(
        last.slave().expect("coupled").position,
        master.position,
        "{what}"
    );
}

/// Time half a second after a beat of a sender that is 1000 ppm fast, with a beat per second: the
/// slave has caught up.
fn between_beats(seconds: Nanos) -> Nanos {
    seconds * SECOND + 250 * MILLISECOND
}

#[test]
fn beats_are_caught_up() {
    for mode in MODES {
        let mut far = Far::new(1000, 1000, 0, 1);
        let mut near = receiver(mode, "stop");
        run_pair(&mut far, &mut near, between_beats(20));
        check(mode, &near);
        if mode != "pt1" {
            has_arrived(mode, &near);
        }
    }
}

#[test]
fn a_slave_that_follows_goes_through_silence_and_restart() {
    for mode in MODES {
        for (silent, anew) in [(300, false), (3_000, false), (20, true), (1_000, true)] {
            let what = format!("{mode}, silent for {silent} ms, begun anew: {anew}");
            let mut far = Far::new(1000, 1000, 0, 1);
            let mut near = receiver(mode, "follow");
            run_pair(&mut far, &mut near, 5 * SECOND);
            let back = 5 * SECOND + silent * MILLISECOND;
            run(None, from_mut(&mut near), back);
            if anew {
                far = Far::new(1000, 1000, back, 2);
            } else {
                let frame = far.tick(back);
                near.post(back, &frame);
            }
            run_pair(&mut far, &mut near, back + between_beats(40));
            check(&what, &near);
            if mode != "pt1" {
                has_arrived(&what, &near);
            }
        }
    }
}

#[test]
fn a_slave_that_stops_is_reset_and_coupled_again() {
    for on_master_loss in ["stop", "quick-stop"] {
        let mut far = Far::new(1000, 1000, 0, 1);
        let mut near = receiver("observer", on_master_loss);
        run_pair(&mut far, &mut near, 5 * SECOND);
        run(None, from_mut(&mut near), 8 * SECOND);
        assert_eq!(near.last().slaves[0].status, AxisStatus::ErrorStop);
        if on_master_loss == "stop" {
            check(on_master_loss, &near);
        }
        let number = near.node.slave_number("slave").expect("a slave");
        near.node
            .command(number, &Command::Reset {})
            .expect("it is at rest");
        run(None, from_mut(&mut near), 8 * SECOND + 10 * MILLISECOND);
        assert_eq!(near.last().slaves[0].status, AxisStatus::Standstill);
    }
}

#[test]
fn a_far_axis_keeps_limits_of_its_own() {
    for mode in MODES {
        let rest = format!(
            "mode = '{mode}'\nsync.time-sync.automatic-re-init = true\nmaster.limits = {{ velocity = {FASTEST:?}, \
             acceleration = {HARDEST:?}, jerk = {JERK:?} }}\n"
        );
        let mut near = Near::new(1000, 0, &rest);
        let mut far = Far::new(1000, 1000, 0, 1);
        run_pair(&mut far, &mut near, 5 * SECOND);
        run(None, from_mut(&mut near), 7 * SECOND);
        far = Far::new(1000, 1000, 7 * SECOND, 2);
        run_pair(&mut far, &mut near, 7 * SECOND + between_beats(40));
        let masters = near.snapshots.iter().filter_map(|shown| shown.master);
        let positions: Vec<f64> = masters.map(|master| master.corrected.position).collect();
        check_positions(mode, &positions);
        if mode != "pt1" {
            let last = near.last().master.expect("there is one");
            let (shown, sent) = (last.corrected.position, last.received.position);
            assert!((shown - sent).abs() < 5.0, "{mode}: {shown}, {sent}");
        }
    }
}
