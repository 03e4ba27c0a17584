//! A sender that stalls, returns or is restarted, in every mode: judged by the differences of the
//! set positions that a slave's drive gets.

use std::slice::from_mut;

use crate::bench::{Far, MILLISECOND, Nanos, Near, SECOND, Shown, VELOCITY, run, run_pair};
use coaxle_receiver::ContinuityState::{Braking, Following, Rejoining};
use coaxle_receiver::HealthName;

const CYCLE: f64 = 1e-3;

/// The modes, in which an error must not persist.
const MODES: [&str; 5] = ["bypass", "pt1", "sync", "time", "observer"];

/// Modes that conceal a few cycles without new data. The others show the received values.
const FROM_CLOCK: [&str; 3] = ["sync", "time", "observer"];

fn receiver(mode: &str) -> Near {
    // The manual's limit in each mode, so that one second shows all of a silence.
    let sync = "sync.time-sync = { automatic-re-init = true, age-of-data-limit = 7 }";
    let rest = format!("mode = '{mode}'\n{sync}");
    Near::new(1000, 0, &rest)
}

fn positions(snapshots: &[Shown]) -> Vec<f64> {
    let slaves = snapshots.iter().filter_map(Shown::slave);
    slaves.map(|slave| slave.position).collect()
}

/// The velocities and accelerations of a follower whose sender is disturbed at 5 s.
fn differences(near: &Near) -> (Vec<f64>, Vec<f64>) {
    // From 0.1 s before, so that the way into the disturbance counts.
    let from = near.truths.partition_point(|at| *at < 4_900 * MILLISECOND);
    let positions = positions(&near.snapshots[from..]);
    let rate = |values: &[f64]| -> Vec<f64> {
        let rates = values.windows(2).map(|pair| (pair[1] - pair[0]) / CYCLE);
        rates.collect()
    };
    let velocities = rate(&positions);
    let accelerations = rate(&velocities);
    (velocities, accelerations)
}

/// Largest acceleration in a mode. Beats are visible in the set values of mode bypass, and filtered
/// in those of pt1. Between modes the blocks blend in a straight line: the filter's lag of three
/// cycles within 60 is 21 u/s from cycle to cycle.
fn largest_acceleration(mode: &str) -> f64 {
    match mode {
        "bypass" => 1.1 * VELOCITY / CYCLE,
        "pt1" => 0.4 * VELOCITY / CYCLE,
        _ => 25_000.0,
    }
}

fn check(mode: &str, what: &str, near: &Near) {
    let (velocities, accelerations) = differences(near);
    let fastest = velocities
        .iter()
        .fold(0.0, |most: f64, v| most.max(v.abs()));
    let most = match mode {
        "bypass" => 2.6,
        "pt1" => 2.0,
        _ => 1.9,
    };
    assert!(fastest < most * VELOCITY, "{mode}, {what}: {fastest} u/s");
    let hardest = accelerations
        .iter()
        .fold(0.0, |most: f64, a| most.max(a.abs()));
    let most = largest_acceleration(mode);
    assert!(hardest < most, "{mode}, {what}: {hardest} u/s²");
    assert_eq!(near.last().health.name(), HealthName::Ok, "{mode}, {what}");
    let master = near.last().master.expect("there is one");
    assert_eq!(master.continuity, Following, "{mode}, {what}");
}

#[test]
fn a_sender_that_stood_still_is_no_step() {
    for mode in MODES {
        // Below and above the limit of 7 cycles, up to 1 500 u of way back.
        for silent in [3, 20, 300, 3_000] {
            if silent == 3 && !FROM_CLOCK.contains(&mode) {
                continue;
            }
            let mut far = Far::new(1000, 1000, 0, 1);
            let mut near = receiver(mode);
            run_pair(&mut far, &mut near, 5 * SECOND);
            let back = 5 * SECOND + silent * MILLISECOND;
            run(None, from_mut(&mut near), back);
            goes_on(&mut far, &mut near, back);
            run_pair(&mut far, &mut near, back + 20 * SECOND);
            check(mode, &format!("silent for {silent} ms"), &near);
        }
    }
}

/// A sender that stalled skips the cycles that it missed.
fn goes_on(far: &mut Far, near: &mut Near, at: Nanos) {
    let frame = far.tick(at);
    near.post(at, &frame);
}

#[test]
fn a_sender_that_is_started_anew_is_no_step() {
    for mode in MODES {
        for silent in [0, 20, 1_000] {
            let mut far = Far::new(1000, 1000, 0, 1);
            let mut near = receiver(mode);
            run_pair(&mut far, &mut near, 5 * SECOND);
            let back = 5 * SECOND + silent * MILLISECOND;
            run(None, from_mut(&mut near), back);
            // Another drift: what the first run taught must not be used.
            let mut again = Far::new(1000, 900, back, 2);
            run_pair(&mut again, &mut near, back + 25 * SECOND);
            // From 2 500 u back to 0.
            check_far(mode, &near);
        }
    }
}

/// Checks a long return, from 2 500 u.
fn check_far(mode: &str, near: &Near) {
    let (velocities, accelerations) = differences(near);
    let (least, most) = velocities
        .iter()
        .fold((0.0_f64, 0.0_f64), |(a, b), v| (a.min(*v), b.max(*v)));
    assert!(
        least > -1.2 * VELOCITY && most < 2.1 * VELOCITY,
        "{mode}: {least}, {most} u/s"
    );
    let hardest = accelerations
        .iter()
        .fold(0.0, |most: f64, a| most.max(a.abs()));
    assert!(
        hardest < largest_acceleration(mode),
        "{mode}: {hardest} u/s²"
    );
    let master = near.last().master.expect("there is one");
    assert_eq!(master.continuity, Following, "{mode}");
}

#[test]
fn it_is_braked_then_at_rest_then_brought_back_and_synchronised() {
    let mut far = Far::new(1000, 1000, 0, 1);
    let mut near = receiver("observer");
    run_pair(&mut far, &mut near, 5 * SECOND);
    let at = |near: &Near| near.last().master.expect("there is one");
    assert_eq!(at(&near).continuity, Following);
    run(None, from_mut(&mut near), 7 * SECOND);
    assert_eq!(at(&near).continuity, Braking);
    let end = positions(near.newest(100));
    assert!(end.iter().all(|position| *position == end[0]), "at rest");
    goes_on(&mut far, &mut near, 7 * SECOND);
    run_pair(&mut far, &mut near, 7 * SECOND + 100 * MILLISECOND);
    assert_eq!(at(&near).continuity, Rejoining);
    assert!(!at(&near).synced, "its set values are not its master's");
    // The node falls silent again on the way, and returns again.
    run(None, from_mut(&mut near), 7_200 * MILLISECOND);
    assert_eq!(at(&near).continuity, Braking);
    goes_on(&mut far, &mut near, 7_200 * MILLISECOND);
    run_pair(&mut far, &mut near, 20 * SECOND);
    assert!(at(&near).synced);
    check("observer", "twice", &near);
}
