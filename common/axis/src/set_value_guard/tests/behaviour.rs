//! Behaviour in single cases.

use std::vec::Vec;

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits};

use super::super::{DistancePolicy, GuardState, Guarded, SetValueGuard};
use super::watch::Watch;

const T: f64 = 0.001;

fn limits() -> Limits {
    Limits::new(100.0, 1_000.0, 1_000.0, 50_000.0).unwrap()
}

fn guard(here: &Kinematics) -> SetValueGuard {
    let none = (f64::NEG_INFINITY, f64::INFINITY);
    SetValueGuard::new(&limits(), none.0, none.1, Seconds(T), here).unwrap()
}

fn moving(cycle: u32) -> Kinematics {
    Kinematics {
        position: 0.05 * f64::from(cycle),
        velocity: 50.0,
        acceleration: 0.0,
    }
}

/// The guarded set values of this number of cycles, which keep the limits.
fn guarded(
    guard: &mut SetValueGuard,
    watch: &mut Watch,
    cycles: u32,
    target: impl Fn(u32) -> Kinematics,
) -> Vec<Guarded> {
    (1..=cycles)
        .map(|cycle| {
            let guarded = guard.update(&target(cycle), 1);
            let used = watch.see(guarded.set.position, 1);
            assert!(used.most() <= 1.0, "cycle {cycle}: {used:?}");
            guarded
        })
        .collect()
}

fn from_rest(cycles: u32, target: impl Fn(u32) -> Kinematics) -> Vec<Guarded> {
    let start = Kinematics::at_rest(0.0);
    let mut watch = Watch::at_rest(0.0, &limits(), T);
    guarded(&mut guard(&start), &mut watch, cycles, target)
}

#[test]
fn a_single_wrong_position_costs_one_cycle() {
    let mut guard = guard(&moving(0));
    for cycle in 1..100 {
        let mut target = moving(cycle);
        if cycle == 50 {
            target.position += 3.0;
        }
        let guarded = guard.update(&target, 1);
        if cycle == 50 {
            assert_eq!(guarded.state, GuardState::Coasting);
            assert!((guarded.set.position - moving(50).position).abs() < 1e-12);
            // The axis less its target, which is 3 ahead.
            assert!((guarded.distance + 3.0).abs() < 1e-12);
        } else {
            assert_eq!(guarded.state, GuardState::Tracking, "cycle {cycle}");
            assert_eq!(guarded.set, target);
        }
    }
}

/// Swarm schedule 1075: an axis was led 17 µm to and fro about a target that went 0.5 µm to and fro, and 1.2 mm about one at 400 Hz.
#[test]
fn a_target_that_goes_to_and_fro_faster_than_it_can_is_followed_on_average() {
    const CYCLE: f64 = 0.000_25;
    let limits = Limits::new(434.0, 13_700.0, 13_700.0, 30_000.0).unwrap();
    for (hertz, ripple) in [(100.0, 0.3), (200.0, 0.3), (400.0, 0.5)] {
        let w = 2.0 * core::f64::consts::PI * hertz;
        let target = |cycle: u32| {
            let (sin, cos) = libm::sincos(w * CYCLE * f64::from(cycle));
            Kinematics {
                position: 1.4 * CYCLE * f64::from(cycle) - ripple / w * cos,
                velocity: 1.4 + ripple * sin,
                acceleration: ripple * w * cos,
            }
        };
        let infinite = f64::INFINITY;
        let start = target(0);
        let mut guard =
            SetValueGuard::new(&limits, -infinite, infinite, Seconds(CYCLE), &start).unwrap();
        let guarded = (1..12_000).map(|cycle| guard.update(&target(cycle), 1));
        let last = guarded.skip(6_000);
        let farthest = last.fold(0.0, |most: f64, one| most.max(one.distance.abs()));
        // A stop from the greatest difference of the velocities, with half of the jerk: 2·u·√(2·2·u/j).
        let most = 2.0 * ripple * libm::sqrt(4.0 * ripple / limits.jerk());
        assert!(farthest < most, "{hertz} Hz: {farthest} u, {most}");
    }
}

#[test]
fn no_number_brings_it_to_a_stop_and_a_number_back() {
    for nothing in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let gone = |cycle: u32| (300..700).contains(&cycle);
        let all = from_rest(3_000, |cycle| {
            let mut target = moving(cycle);
            if gone(cycle) {
                // A single value is enough, even with a position that is a number.
                target.velocity = nothing;
            }
            target
        });
        let after = |cycle: usize| all[cycle - 1];
        assert_eq!(after(299).state, GuardState::Tracking);
        assert_eq!(after(300).state, GuardState::Coasting);
        let standing = after(699);
        assert_eq!(standing.state, GuardState::Coasting);
        assert!(standing.set.velocity.abs() < 1e-6 && standing.set.acceleration.abs() < 1e-6);
        assert!((standing.distance - (standing.set.position - moving(699).position)).abs() < 1e-9);
        assert_eq!(after(700).state, GuardState::CatchingUp);
        assert_eq!(after(3_000).set, moving(3_000));
    }
}

#[test]
fn far_targets_are_gone_to_within_the_limits() {
    for far in [1e15, -1e15, 1e300, f64::MAX, -f64::MAX] {
        let all = from_rest(3_000, |cycle| {
            let mut target = moving(cycle);
            if cycle < 500 {
                target.position = far;
            }
            target
        });
        // At the highest velocity: 0.1 s and a ramp of 0.02 s to get there.
        assert!((all[400].set.velocity.abs() - 100.0).abs() < 1e-6);
        assert_eq!(all[2_999].set, moving(3_000));
    }
}

#[test]
fn a_target_that_is_too_fast_is_reported_and_caught_up() {
    let all = from_rest(4_000, |cycle| {
        let position = if cycle < 500 {
            0.15 * f64::from(cycle)
        } else {
            75.0
        };
        let velocity = if cycle < 500 { 150.0 } else { 0.0 };
        Kinematics {
            position,
            velocity,
            acceleration: 0.0,
        }
    });
    assert_eq!(all[300].state, GuardState::Cannot);
    assert!((all[300].set.velocity - 100.0).abs() < 1e-9);
    assert_eq!(all[600].state, GuardState::CatchingUp);
    assert_eq!(all[3_999].state, GuardState::Tracking);
    assert_eq!(all[3_999].set, Kinematics::at_rest(75.0));
}

#[test]
fn a_distance_stays_where_only_the_velocity_is_followed() {
    let start = moving(0);
    let mut guard = guard(&start);
    guard.set_distance_policy(DistancePolicy::VeloSync);
    // The target jumps ahead by 7 and moves on.
    let jumped = |cycle: u32| {
        let mut target = moving(cycle);
        target.position += if cycle < 100 { 0.0 } else { 7.0 };
        target
    };
    let all: Vec<Guarded> = (1..500)
        .map(|cycle| guard.update(&jumped(cycle), 1))
        .collect();
    let last = all[498];
    assert_eq!(last.state, GuardState::Tracking);
    assert!((last.distance + 7.0).abs() < 1e-9, "{last:?}");
    assert_eq!((last.set.velocity, last.set.acceleration), (50.0, 0.0));
    let departed = all
        .iter()
        .filter(|g| g.state != GuardState::Tracking)
        .count();
    // Only the differences across the jump depart: velocity, acceleration and jerk span four positions.
    assert!(departed < 10, "{departed}");

    // Another policy catches it up.
    guard.set_distance_policy(DistancePolicy::PosSync1);
    let all: Vec<Guarded> = (500..3_000)
        .map(|cycle| guard.update(&jumped(cycle), 1))
        .collect();
    assert_eq!(all[0].state, GuardState::Coasting);
    assert_eq!(all[2_499].set, jumped(2_999));
    assert_eq!(all[2_499].distance, 0.0);
}

#[test]
fn a_wrong_position_leaves_no_distance_even_so() {
    let mut guard = guard(&moving(0));
    guard.set_distance_policy(DistancePolicy::VeloSync);
    for cycle in 1..100 {
        let mut target = moving(cycle);
        target.position += if cycle == 50 { 3.0 } else { 0.0 };
        let guarded = guard.update(&target, 1);
        assert!(
            cycle == 50 || guarded.distance == 0.0,
            "cycle {cycle}: {guarded:?}"
        );
    }
}

#[test]
fn it_resumes_from_a_motion() {
    let here = Kinematics {
        position: 3.0,
        velocity: 60.0,
        acceleration: -500.0,
    };
    let mut guard = guard(&Kinematics::at_rest(0.0));
    guard.start(&here);
    let after = |t: f64| Kinematics {
        position: 3.0 + 60.0 * t - 250.0 * t * t,
        velocity: 60.0 - 500.0 * t,
        acceleration: -500.0,
    };
    for cycle in 1..50 {
        let target = after(T * f64::from(cycle));
        let guarded = guard.update(&target, 1);
        assert_eq!((guarded.state, guarded.set), (GuardState::Tracking, target));
    }
}

#[test]
fn a_start_that_is_no_number_is_none() {
    let mut guard = guard(&Kinematics::at_rest(5.0));
    guard.start(&Kinematics {
        position: f64::NAN,
        velocity: f64::INFINITY,
        acceleration: f64::NAN,
    });
    let here = Kinematics::at_rest(5.0);
    assert_eq!(guard.update(&here, 1).set, here);
}

#[test]
fn beyond_a_software_limit_it_may_stand_and_come_back() {
    let out = Kinematics::at_rest(12.0);
    let mut guard = SetValueGuard::new(&limits(), 0.0, 10.0, Seconds(T), &out).unwrap();
    for _ in 0..100 {
        let guarded = guard.update(&out, 1);
        assert_eq!((guarded.state, guarded.set), (GuardState::Tracking, out));
    }
    // No farther,
    for _ in 0..100 {
        let guarded = guard.update(&Kinematics::at_rest(13.0), 1);
        assert_eq!(guarded.state, GuardState::Cannot);
        assert!(guarded.set.position <= 12.0);
    }
    // but back, and then not out again.
    let back = Kinematics::at_rest(5.0);
    let last = (0..1_000).map(|_| guard.update(&back, 1)).last().unwrap();
    assert_eq!(last.set, back);
    let last = (0..1_000).map(|_| guard.update(&out, 1)).last().unwrap();
    assert!((last.set.position - 10.0).abs() < 1e-12, "{last:?}");
    assert_eq!(last.state, GuardState::Cannot);
}

#[test]
fn stated_values_that_no_axis_has_do_not_leave_it() {
    let mut guard = guard(&moving(0));
    for cycle in 1..100 {
        let target = Kinematics {
            velocity: 1e9,
            acceleration: -1e9,
            ..moving(cycle)
        };
        let guarded = guard.update(&target, 1);
        assert_eq!(guarded.state, GuardState::Tracking);
        assert_eq!(guarded.set.position.to_bits(), target.position.to_bits());
        assert!((guarded.set.velocity - 50.0).abs() < 1e-9);
        assert!(guarded.set.acceleration.abs() < 1e-6);
    }
}

#[test]
fn any_number_of_cycles_may_be_skipped() {
    for elapsed in [0, 2, 99, 100_000, u32::MAX] {
        let mut guard = guard(&moving(0));
        let _ = guard.update(&moving(1), 1);
        let next = 1 + elapsed.clamp(1, 1_000_000_000);
        let guarded = guard.update(&moving(next), elapsed);
        assert!(guarded.set.position.is_finite());
        if elapsed < 1_000 {
            assert_eq!(
                (guarded.state, guarded.set),
                (GuardState::Tracking, moving(next))
            );
        }
    }
}

/// A node that stalled for seconds while its axis was on the way to a faster target, whose way to
/// rest is unknown.
#[test]
fn after_many_skipped_cycles_it_is_at_rest_where_its_target_is() {
    for skipped in [200, 1_000, 4_000] {
        let mut guard = guard(&Kinematics::at_rest(0.0));
        let fast = |cycle: u32| Kinematics {
            position: 0.3 * f64::from(cycle),
            velocity: 300.0,
            acceleration: 0.0,
        };
        for cycle in 1..=20 {
            assert_ne!(guard.update(&fast(cycle), 1).state, GuardState::Tracking);
        }
        let rest = Kinematics::at_rest(fast(20).position + 2.0);
        let guarded = guard.update(&rest, skipped);
        assert!(guarded.distance.abs() < 1e-6, "{skipped}: {guarded:?}");
        assert!(guarded.set.velocity.abs() < 1e-3);
        assert_eq!(guard.update(&rest, 1).set.position, rest.position);
    }
}

#[test]
fn extreme_limits_and_cycle_times_do_no_harm() {
    for cycle_time in [1e-6, 1e-3, 1.0] {
        for [v, a, j] in [
            [1e15, 1e15, 1e15],
            [1e-9, 1e-9, 1e-9],
            [1e15, 1e-9, 1e15],
            [1e-9, 1e15, 1e-9],
            [100.0, 1_000.0, 1e15],
        ] {
            let limits = Limits::new(v, a, a, j).unwrap();
            let start = Kinematics::at_rest(0.0);
            let mut guard =
                SetValueGuard::new(&limits, -10.0, 10.0, Seconds(cycle_time), &start).unwrap();
            for cycle in 0..200_u32 {
                let position = [0.5, -3.0, 1e15, f64::NAN, -1e300][(cycle / 40) as usize];
                let target = Kinematics {
                    position,
                    velocity: 1e15,
                    acceleration: -1e15,
                };
                let set = guard.update(&target, 1).set;
                assert!(
                    set.position.abs() <= 10.0 + 1e-9,
                    "{cycle_time} {limits:?} {set:?}"
                );
                assert!(set.velocity.is_finite() && set.acceleration.is_finite());
            }
        }
    }
}

#[test]
fn a_cycle_time_that_is_none_is_named() {
    for received in [0.0, -0.001, f64::NAN, f64::INFINITY] {
        let here = Kinematics::at_rest(0.0);
        let refused = SetValueGuard::new(&limits(), 0.0, 1.0, Seconds(received), &here);
        assert_eq!(refused.unwrap_err().field, "cycle time");
    }
}
