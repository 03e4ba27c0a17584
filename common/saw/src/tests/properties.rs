//! Properties that hold for all numbers.

use super::super::{SawForm, SawPlan, SyncMask};
use super::*;
use proptest::prelude::*;
use std::vec::Vec;

/// Slack for rounding, relative to the largest quantity of its kind in the motion.
pub(super) const SLACK: f64 = 1e-9;

/// A number spread evenly over decades.
pub(super) fn decades(from: i32, to: i32) -> impl Strategy<Value = f64> {
    (f64::from(from)..f64::from(to)).prop_map(|exponent| libm::pow(10.0, exponent))
}

pub(super) fn signed(magnitude: impl Strategy<Value = f64>) -> impl Strategy<Value = f64> {
    (magnitude, any::<bool>()).prop_map(|(x, up)| if up { x } else { -x })
}

pub(super) fn limits() -> impl Strategy<Value = SyncLimits> {
    // Absolute tolerances in the planner would show at either end of these decades.
    let dynamics = (decades(1, 4), decades(1, 6), decades(1, 6), decades(2, 8));
    (dynamics, 0.0..2e4, 0.0..2e4).prop_map(|((v, a, d, j), low, high): (_, f64, f64)| SyncLimits {
        velocity: Some(v),
        acceleration: Some(a),
        deceleration: Some(d),
        jerk: Some(j),
        min_position: Some(-low),
        max_position: Some(high),
        master_velocity: None,
    })
}

/// Any moment: half of them free of acceleration, where profiles can be optimised.
fn any_moment() -> impl Strategy<Value = CouplingMoment> {
    let velocities = (
        signed(decades(0, 3)),
        prop_oneof![Just(0.0), signed(decades(0, 3))],
    );
    let accelerations = prop_oneof![
        Just((0.0, 0.0)),
        (signed(decades(-1, 3)), signed(decades(-1, 3)))
    ];
    (velocities, accelerations, -1e3..1e3, -1e3..1e3).prop_map(
        |((v_master, v_slave), (a_master, a_slave), master, slave)| {
            let mut moment = moment((master, v_master), (slave, v_slave));
            moment.master.acceleration = a_master;
            moment.slave.acceleration = a_slave;
            // Above every limit of a command, so that only the command's decide.
            moment.axis.dynamics = Limits::new(1e5, 1e6, 1e6, 1e9).expect("above zero");
            moment
        },
    )
}

fn any_mask() -> impl Strategy<Value = SyncMask> {
    let plain = any::<u32>().prop_map(SyncMask::from_bits_truncate);
    // With all checks at random, hardly anything would pass.
    (plain, any::<u32>().prop_map(SyncMask::from_bits_truncate))
        .prop_map(|(one, other)| one & other | SyncMask::DETAILED_ERROR_CODES)
}

pub(super) fn gear_in_pos() -> impl Strategy<Value = (GearInPos, CouplingMoment)> {
    let gear = signed(decades(-1, 1));
    // The slave's part of the gear's distance: below 1 it has to hurry less than its gear, above 1 more.
    let ahead = (decades(0, 4), 0.05..2.0_f64);
    (any_moment(), any_mask(), limits(), gear, ahead).prop_map(
        |(moment, mask, limits, gear, (distance, share))| {
            let master = distance.copysign(moment.master.velocity);
            let sync = (
                moment.master.position + master,
                moment.slave.position + share * gear * master,
            );
            let command = to_position(gear, sync, SyncMode::position_based(mask), limits);
            (command, moment)
        },
    )
}

pub(super) fn gear_in_velo(
    time_based: bool,
) -> impl Strategy<Value = (GearInVelo, CouplingMoment)> {
    (any_moment(), any_mask(), limits(), signed(decades(-1, 1))).prop_map(
        move |(moment, mask, limits, gear)| {
            let mode = if time_based {
                SyncMode::time_based(mask)
            } else {
                SyncMode::position_based(mask)
            };
            (to_velocity(gear, mode, limits), moment)
        },
    )
}

/// Returns the begins of the pieces of a plan and its end, s since the start.
fn knots(plan: &SawPlan) -> Vec<f64> {
    let (path, velocity) = plan.path().expect("something to synchronise");
    let begin = path.first().begin;
    let begins = path.pieces().map(|piece| (piece.begin - begin) / velocity);
    begins.chain([plan.duration().0]).collect()
}

/// Returns the times and the slave's motion then, close to each other in every piece.
fn samples(plan: &SawPlan) -> Vec<(f64, Kinematics)> {
    let knots = knots(plan);
    let times = knots.windows(2).flat_map(|piece| {
        let (from, to) = (piece[0], piece[1]);
        (0..=200).map(move |k| from + (to - from) * f64::from(k) / 200.0)
    });
    times.map(|t| (t, plan.at(Seconds(t)))).collect()
}

type Quantity = fn(&Kinematics) -> f64;

fn size(samples: &[(f64, Kinematics)], quantity: Quantity) -> f64 {
    let magnitudes = samples.iter().map(|(_, slave)| quantity(slave).abs());
    magnitudes.fold(0.0, f64::max)
}

/// Makes the checks by sampling, independent of how the planner finds extremes.
pub(super) fn assert_kept(
    plan: &SawPlan,
    mask: SyncMask,
    limits: &SyncLimits,
) -> Result<(), TestCaseError> {
    let samples = samples(plan);
    let start = plan.slave_start();
    let end = Kinematics {
        position: plan.line().slave,
        velocity: plan.line().ratio * plan.master_velocity(),
        acceleration: 0.0,
    };
    let p = size(&samples, |s| s.position) * SLACK;
    let v = size(&samples, |s| s.velocity) * SLACK;
    // Sampled places are rounded, and the acceleration changes by the jerk over their rounding.
    let a = size(&samples, |s| s.acceleration) * 1e-6;
    let checked = |bit| mask.contains(bit);
    let given = |limit: Option<f64>| limit.expect("all limits are given");
    for (_, s) in &samples {
        if checked(SyncMask::OPTIONAL_MIN_POS) {
            prop_assert!(s.position >= given(limits.min_position) - p);
        }
        if checked(SyncMask::OPTIONAL_MAX_POS) {
            prop_assert!(s.position <= given(limits.max_position) + p);
        }
        if checked(SyncMask::OVERSHOOT_POS) {
            prop_assert!(s.position <= start.position.max(end.position) + p);
        }
        if checked(SyncMask::UNDERSHOOT_POS) {
            prop_assert!(s.position >= start.position.min(end.position) - p);
        }
        if checked(SyncMask::MAX_VELO) {
            prop_assert!(s.velocity.abs() <= given(limits.velocity) + v);
        }
        if checked(SyncMask::OVERSHOOT_VELO) {
            prop_assert!(s.velocity <= start.velocity.max(end.velocity) + v);
        }
        if checked(SyncMask::UNDERSHOOT_VELO) {
            prop_assert!(s.velocity >= start.velocity.min(end.velocity) - v);
        }
        if checked(SyncMask::OVERSHOOT_VELO_ZERO) && start.velocity.max(end.velocity) <= 0.0 {
            prop_assert!(s.velocity <= v);
        }
        if checked(SyncMask::UNDERSHOOT_VELO_ZERO) && start.velocity.min(end.velocity) >= 0.0 {
            prop_assert!(s.velocity >= -v);
        }
        let faster = s.acceleration * s.velocity > 0.0;
        if checked(SyncMask::MAX_ACC) && faster {
            prop_assert!(s.acceleration.abs() <= given(limits.acceleration) + a);
        }
        if checked(SyncMask::MAX_DEC) && !faster && s.velocity.abs() > v {
            prop_assert!(s.acceleration.abs() <= given(limits.deceleration) + a);
        }
    }
    let jerk = plan.characteristics(1).extremes.jerk.magnitude();
    if checked(SyncMask::MAX_JERK) {
        prop_assert!(jerk <= given(limits.jerk) * (1.0 + SLACK));
    }
    assert_smooth(plan, &samples, jerk)
}

/// Checks that there is no jump of position, velocity or acceleration within the phase.
fn assert_smooth(
    plan: &SawPlan,
    samples: &[(f64, Kinematics)],
    jerk: f64,
) -> Result<(), TestCaseError> {
    let p = size(samples, |s| s.position);
    let extremes = plan.characteristics(1).extremes;
    let v = extremes.velocity.magnitude();
    let a = extremes.acceleration.magnitude();
    for pair in samples.windows(2) {
        let ((t0, s0), (t1, s1)) = (pair[0], pair[1]);
        // A time has few digits left where the phase is long and a piece of it short.
        let dt = (t1 - t0) * 1.000_001 + plan.duration().0 * 1e-12;
        let step = (s1.position - s0.position).abs();
        prop_assert!(step <= v * dt + p * SLACK, "position {step} {}", v * dt);
        let step = (s1.velocity - s0.velocity).abs();
        prop_assert!(step <= a * dt + v * SLACK, "velocity {step} {}", a * dt);
        let step = (s1.acceleration - s0.acceleration).abs();
        prop_assert!(
            step <= jerk * dt + a * 1e-6,
            "acceleration {step} {}",
            jerk * dt
        );
    }
    Ok(())
}

/// Checks that it starts with the slave's motion and ends on the line, with its slope and without
/// curvature.
pub(super) fn assert_ends(plan: &SawPlan, moment: &CouplingMoment) -> Result<(), TestCaseError> {
    let near = |a: f64, b: f64, size: f64| (a - b).abs() <= SLACK * size;
    let start = plan.at(Seconds(0.0));
    let velocity = moment.slave.velocity;
    prop_assert!(near(
        start.position,
        moment.slave.position,
        1.0 + start.position.abs()
    ));
    prop_assert!(near(start.velocity, velocity, velocity.abs()));
    if let Some(path) = plan.over_master_at(plan.master_start()) {
        let v = plan.master_velocity();
        let along_slope = path.velocity * moment.master.acceleration;
        let masks_none = plan.slave_start().acceleration == moment.slave.acceleration;
        let expected = moment.slave.acceleration;
        let acceleration = path.acceleration * v * v + along_slope;
        let size = expected.abs().max(along_slope.abs()).max(1e-3 * v * v);
        if masks_none && plan.form() != SawForm::Synchronous {
            prop_assert!(near(acceleration, expected, size) || moment.master.acceleration != 0.0);
        }
    }
    // Beside the end, since at it the line takes over.
    let before_end = plan.at(Seconds(plan.duration().0 * (1.0 - 1e-12)));
    let line = plan.line();
    let peak = plan.characteristics(1).extremes;
    let size = peak.position.magnitude();
    prop_assert!((before_end.position - line.slave).abs() <= SLACK * size);
    let sync = line.ratio * plan.master_velocity();
    let left = plan.duration().0 * 1e-11;
    let (acceleration, jerk) = (peak.acceleration.magnitude(), peak.jerk.magnitude());
    let missing = (before_end.velocity - sync).abs();
    prop_assert!(missing <= SLACK * peak.velocity.magnitude() + acceleration * left);
    prop_assert!(before_end.acceleration.abs() <= 1e-6 * acceleration + jerk * left);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn an_accepted_way_to_a_position_keeps_its_checks((command, moment) in gear_in_pos()) {
        if let Ok(plan) = command.plan(&moment) {
            assert_kept(&plan, command.sync_mode.mask, &command.limits)?;
            assert_ends(&plan, &moment)?;
        }
    }

    #[test]
    fn an_accepted_ramp_keeps_its_checks_and_its_dynamics((command, moment) in gear_in_velo(false)) {
        if let Ok(plan) = command.plan(&moment) && plan.form() != SawForm::Synchronous {
            let mask = command.sync_mode.mask;
            let dynamics = SyncMask::MAX_ACC | SyncMask::MAX_DEC | SyncMask::MAX_JERK;
            assert_kept(&plan, mask | dynamics, &command.limits)?;
            assert_ends(&plan, &moment)?;
        }
    }

    #[test]
    fn an_accepted_profile_over_time_keeps_its_checks((command, moment) in gear_in_velo(true)) {
        if let Ok(plan) = command.plan(&moment) && plan.form() != SawForm::Synchronous {
            let dynamics = SyncMask::MAX_ACC | SyncMask::MAX_DEC;
            let mask = command.sync_mode.mask - dynamics;
            assert_kept(&plan, mask | SyncMask::MAX_JERK, &command.limits)?;
            assert_ends(&plan, &moment)?;
        }
    }

    #[test]
    fn characteristics_bound_the_samples_and_touch_them((command, moment) in gear_in_pos()) {
        if let Ok(plan) = command.plan(&moment) {
            let samples = samples(&plan);
            let values = plan.characteristics(1);
            let quantities: [(_, Quantity); 3] = [
                (values.extremes.position, |s| s.position),
                (values.extremes.velocity, |s| s.velocity),
                (values.extremes.acceleration, |s| s.acceleration),
            ];
            for (range, quantity) in quantities {
                let size = range.magnitude();
                let taken = || samples.iter().map(|(_, slave)| quantity(slave));
                let low = taken().fold(f64::MAX, f64::min);
                let high = taken().fold(f64::MIN, f64::max);
                prop_assert!(range.minimum.value <= low + 1e-6 * size);
                prop_assert!(range.maximum.value >= high - 1e-6 * size);
                let over_range = high - low;
                // 200 samples per piece miss a peak between two of them by a little.
                prop_assert!(range.maximum.value - high <= 0.03 * over_range + 1e-6 * size);
                prop_assert!(low - range.minimum.value <= 0.03 * over_range + 1e-6 * size);
            }
            let moments = samples.iter().map(|(_, s)| s.velocity * s.acceleration);
            let size = values.dynamic_moment.magnitude();
            for moment in moments {
                prop_assert!(moment <= values.dynamic_moment.maximum.value + 1e-5 * size);
                prop_assert!(moment >= values.dynamic_moment.minimum.value - 1e-5 * size);
            }
            let trapezoid = |pair: &[(f64, Kinematics)], f: Quantity| {
                let ((t0, s0), (t1, s1)) = (pair[0], pair[1]);
                (f(&s0) + f(&s1)) / 2.0 * (t1 - t0)
            };
            let integral = |f: Quantity| -> f64 {
                samples.windows(2).map(|pair| trapezoid(pair, f)).sum()
            };
            let mean = integral(|s| s.velocity.abs()) / plan.duration().0;
            let size = values.extremes.velocity.magnitude();
            // The trapezoidal rule, coarse where |v| or a² has a bend.
            prop_assert!((values.mean_velocity - mean).abs() <= 1e-2 * size);
            let square = integral(|s| s.acceleration * s.acceleration) / plan.duration().0;
            let size = values.extremes.acceleration.magnitude();
            let effective = values.effective_acceleration;
            prop_assert!((effective - libm::sqrt(square)).abs() <= 1e-2 * size);
        }
    }

    #[test]
    fn the_motion_function_runs_the_same_way((command, moment) in gear_in_pos()) {
        if let Ok(plan) = command.plan(&moment) {
            let function = plan.motion_function();
            prop_assert!(function.is_ok(), "{function:?}");
            let size = plan.characteristics(1).extremes.position.magnitude();
            let segments: Vec<_> = plan.segments().collect::<Result<_, _>>().expect("segments");
            let points = plan.motion_points();
            prop_assert_eq!(points.len(), segments.len() + 1);
            prop_assert!(points.windows(2).all(|pair| pair[0].master < pair[1].master));
            for segment in segments {
                let middle = f64::midpoint(segment.start(), segment.end());
                let expected = plan.over_master_at(middle).expect("over the master");
                let found = segment.at(middle);
                prop_assert!((found.position - expected.position).abs() <= 1e-8 * size);
            }
        }
    }
}
