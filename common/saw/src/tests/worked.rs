//! The examples of TS5055, chapters 3 and 4, with the start positions as the coupling moment.

use super::super::{Check, GearInSyncMode, SawForm, SawPlan, SyncMask, SyncMode};
use super::*;

struct Ramp {
    gear: f64,
    master: f64,
    slave: f64,
    length: f64,
    duration: f64,
    acceleration: f64,
    time_duration: f64,
    time_acceleration: f64,
}

const CHAPTER_3: [Ramp; 3] = [
    Ramp {
        gear: 1.0,
        master: 500.0,
        slave: -250.0,
        // √(6·Δv/j) = √(6 · 750/5000) s at 500 mm/s, with a peak of 1.5·Δv/T.
        length: 474.342,
        duration: 0.948_683,
        acceleration: 1_185.85,
        // 2·√(Δv/j), with a peak of √(j·Δv): the limit of 2500 is not reached.
        time_duration: 0.774_597,
        time_acceleration: 1_936.49,
    },
    Ramp {
        gear: 1.5,
        master: 500.0,
        slave: -250.0,
        length: 547.723,
        duration: 1.095_445,
        acceleration: 1_369.31,
        time_duration: 0.894_427,
        time_acceleration: 2_236.07,
    },
    Ramp {
        gear: 1.0,
        master: -500.0,
        slave: 400.0,
        length: 519.615,
        duration: 1.039_230,
        acceleration: 1_299.04,
        time_duration: 0.848_528,
        time_acceleration: 2_121.32,
    },
];

/// Returns the peak of acceleration and of jerk.
fn peaks(plan: &SawPlan) -> (f64, f64) {
    let extremes = plan.characteristics(255).extremes;
    (extremes.acceleration.magnitude(), extremes.jerk.magnitude())
}

#[test]
fn synchronisation_to_velocity_position_based() {
    for example in CHAPTER_3 {
        let command = to_velocity(
            example.gear,
            SyncMode::default(),
            dynamics(2_500.0, 5_000.0),
        );
        let moment = moment((0.0, example.master), (0.0, example.slave));
        let plan = command.plan(&moment).unwrap();
        assert_eq!(plan.form(), SawForm::Ramp);
        printed(plan.master_end().abs(), example.length, 1e-3);
        printed(plan.duration().0, example.duration, 1e-6);
        let (acceleration, jerk) = peaks(&plan);
        printed(acceleration, example.acceleration, 1e-2);
        printed(jerk, 5_000.0, 1e-9);
        if example.gear == 1.0 && example.master > 0.0 {
            // The mean of −250 and 500 over the duration, and likewise over time.
            printed(plan.line().slave, 118.585, 1e-3);
        }
    }
}

#[test]
fn synchronisation_to_velocity_time_based() {
    for example in CHAPTER_3 {
        let mode = SyncMode::time_based(SyncMask::MAX_DYNAMICS);
        assert_eq!(mode.base, GearInSyncMode::TimeBased);
        let command = to_velocity(example.gear, mode, dynamics(2_500.0, 5_000.0));
        let moment = moment((0.0, example.master), (0.0, example.slave));
        let plan = command.plan(&moment).unwrap();
        assert_eq!(plan.form(), SawForm::JerkPhases);
        printed(plan.duration().0, example.time_duration, 1e-6);
        let (acceleration, jerk) = peaks(&plan);
        printed(acceleration, example.time_acceleration, 1e-2);
        printed(jerk, 5_000.0, 1e-9);
        if example.gear == 1.0 && example.master > 0.0 {
            printed(plan.line().slave, 96.8246, 1e-4);
        }
    }
}

#[test]
fn synchronisation_to_position_1() {
    let start = moment((-500.0, 500.0), (-250.0, 250.0));
    let limits = dynamics(2_500.0, 5_000.0);
    let plan = to_position(1.0, (1_000.0, 1_000.0), SyncMode::default(), limits)
        .plan(&start)
        .unwrap();
    assert_eq!(plan.form(), SawForm::Quintic);
    printed(plan.duration().0, 3.0, 1e-12);
    let (acceleration, jerk) = peaks(&plan);
    printed(acceleration, 175.046, 1e-3);
    printed(jerk, 444.444, 1e-3);
    let velocity = plan.characteristics(255).extremes.velocity.maximum;
    printed(velocity.value, 506.0, 1e-9);
    // 1200 past the start at −500, where the manual's curve is highest.
    printed(velocity.master, 700.0, 1e-9);

    let mask = SyncMask::OVERSHOOT_VELO | SyncMask::UNDERSHOOT_VELO;
    let mode = SyncMode::position_based(mask);
    let plan = to_position(1.0, (1_000.0, 1_000.0), mode, limits)
        .plan(&start)
        .unwrap();
    assert_eq!(plan.form(), SawForm::QuinticLine);
    printed(plan.duration().0, 3.0, 1e-12);
    let (acceleration, jerk) = peaks(&plan);
    // τ = 2/3, so L = 2(1 − τ)M = 1000: 1.5·0.5·500²/1000, and 6·0.5·500³/1000² for the jerk.
    printed(acceleration, 187.5, 1e-9);
    printed(jerk, 375.0, 1e-9);
    printed(plan.joins_line_at(), 500.0, 1e-9);
    let velocity = plan.characteristics(255).extremes.velocity;
    assert_eq!(velocity.minimum.value, 250.0);
    assert!((velocity.maximum.value - 500.0).abs() < 1e-9);
}

#[test]
fn synchronisation_to_position_2() {
    let start = moment((-500.0, 500.0), (-500.0, -250.0));
    let limits = dynamics(10_000.0, 50_000.0);
    let plan = to_position(1.5, (1_000.0, 500.0), SyncMode::default(), limits)
        .plan(&start)
        .unwrap();
    assert_eq!(plan.form(), SawForm::Quintic);
    printed(plan.duration().0, 3.0, 1e-12);
    let (acceleration, jerk) = peaks(&plan);
    printed(acceleration, 568.755, 1e-3);
    printed(jerk, 1_222.22, 1e-2);
    let lowest = plan.characteristics(255).extremes.position.minimum;
    printed(lowest.value, -620.638, 1e-3);

    let mode = SyncMode::position_based(SyncMask::UNDERSHOOT_POS | SyncMask::DETAILED_ERROR_CODES);
    let refusal = to_position(1.5, (1_000.0, 500.0), mode, limits)
        .plan(&start)
        .unwrap_err();
    assert_eq!(refusal.code(), 0x4377);
    let violation = refusal.violation().unwrap();
    assert_eq!(violation.check, Check::UndershootPosForward);
    assert_eq!(violation.limit, -500.0);
    assert_eq!(violation.measured, lowest.value);
    assert_eq!(violation.master_position, lowest.master);
}

#[test]
fn the_plan_runs_from_the_start_to_the_synchronous_line() {
    let start = moment((-500.0, 500.0), (-500.0, -250.0));
    let mode = SyncMode::default();
    let plan = to_position(1.5, (1_000.0, 500.0), mode, SyncLimits::default())
        .plan(&start)
        .unwrap();
    assert_eq!(plan.at(seconds(0.0)), start.slave);
    let end = plan.at(plan.duration());
    assert_eq!((end.position, end.velocity), (500.0, 750.0));
}
