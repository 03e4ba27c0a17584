//! The axis as a slave.

use super::*;
use crate::{CouplingPhase, DistanceParameters, JobError, Refusal, SlaveError};
use coaxle_axis::guard::GuardFault;
use coaxle_axis::set_value_guard::{DistancePolicy, GuardState};
use coaxle_axis::{AxisState, AxisStatus, CommandState, CoupleState};
use coaxle_gear::FlyingGearParameters;

/// An axis at the velocity of its master, coupled 1:1.
fn coupled(parameters: &SlaveParameters, velocity: f64) -> (AxisWithPlates, Master) {
    let mut axis = powered(parameters);
    start(&mut axis, &move_velocity(velocity));
    run(&mut axis, 500);
    let mut master = Master::at(-1_000.0, velocity);
    master.lead(&mut axis, 1);
    start(&mut axis, &Command::GearIn(GearIn::of(1.0)));
    (axis, master)
}

#[test]
fn a_gear_couples_where_the_axis_is() {
    let (mut axis, mut master) = coupled(&PARAMETERS, 200.0);
    let apart = axis.set().position - master.0.position;
    master.lead(&mut axis, 100);
    assert!((axis.set().position - master.0.position - apart).abs() < 1e-9);
    assert_eq!(axis.set().velocity, 200.0);
    assert_eq!(axis.coupling_phase(), Some(CouplingPhase::InSync));
    assert_eq!(axis.job().1, CommandState::InSync);
    let image = axis.axis_struct(1);
    assert_eq!(image.axis_state, AxisState::SlaveSynchronous);
    assert_eq!(image.couple_state, CoupleState::Slave);
}

#[test]
fn a_gear_that_couples_nothing_or_too_fast_is_refused() {
    let mut axis = powered(&PARAMETERS);
    let mut master = Master::at(0.0, 200.0);
    let refused = axis.command(&Command::GearIn(GearIn::of(1.0))).unwrap_err();
    assert_eq!(refused, Refusal::NoMaster);
    master.lead(&mut axis, 1);
    let refused = axis
        .command(&Command::GearIn(GearIn::of(10.0)))
        .unwrap_err();
    assert_eq!(refused.code(), 0x42dd);
    for ratio in [0.0, f64::NAN] {
        let refused = axis
            .command(&Command::GearIn(GearIn::of(ratio)))
            .unwrap_err();
        assert_eq!(refused.code(), 0x421b);
    }
    assert_eq!(axis.status(), AxisStatus::Standstill);
}

#[test]
fn gear_out_keeps_the_velocity_and_leads_the_acceleration_to_zero() {
    let (mut axis, mut master) = coupled(&PARAMETERS, 200.0);
    for _ in 0..50 {
        master.accelerate(&mut axis, 1_000.0, 80_000.0);
    }
    let gear = axis.job().0;
    let out = start(&mut axis, &Command::GearOut {});
    assert_eq!(axis.progress(out), CommandState::Done);
    assert_eq!(axis.progress(gear.unwrap()), CommandState::Aborted);
    assert_eq!(axis.status(), AxisStatus::ContinuousMotion);
    let before = axis.set();
    let mut differences = Differences::of(&axis);
    // 1000/100000 s to zero, and not 15 ms for the velocity gained meanwhile.
    for _ in 0..25 {
        master.lead(&mut axis, 1);
        differences.keep(&axis, &PARAMETERS);
    }
    assert_eq!(axis.set().velocity, before.velocity);
    assert_eq!(axis.set().acceleration, 0.0);
    run(&mut axis, 1_000);
    assert_eq!(axis.set().velocity, before.velocity);
}

#[test]
fn a_command_of_its_own_uncouples_the_axis_smoothly() {
    let (mut axis, mut master) = coupled(&PARAMETERS, 200.0);
    master.lead(&mut axis, 100);
    let before = axis.set();
    start(&mut axis, &move_absolute(0.0));
    master.lead(&mut axis, 1);
    assert!((axis.set().velocity - before.velocity).abs() < 1.0);
    master.lead(&mut axis, 3_000);
    assert_eq!(axis.set(), Kinematics::at_rest(0.0));
}

#[test]
fn a_lost_master_stops_the_slave_as_configured() {
    let stop_of = |on_master_loss| {
        let parameters = SlaveParameters {
            on_master_loss,
            ..PARAMETERS
        };
        let (mut axis, mut master) = coupled(&parameters, 800.0);
        master.lead(&mut axis, 100);
        let mut cycles = 0;
        while axis.set().velocity != 0.0 {
            let before = axis.set().velocity;
            axis.update(None, CYCLE);
            assert!(before - axis.set().velocity <= 4_000.0 * CYCLE.0 * (1.0 + 1e-9));
            cycles += 1;
        }
        assert_eq!(axis.error(), Some(SlaveError::MasterLost));
        cycles
    };
    // 800/4000 s, and with a limited jerk 4000/100000 s more.
    assert!((240..=241).contains(&stop_of(OnMasterLoss::Stop)));
    assert!((200..=202).contains(&stop_of(OnMasterLoss::QuickStop)));
}

#[test]
fn a_lost_master_does_not_matter_to_an_axis_that_is_not_coupled() {
    let mut axis = powered(&PARAMETERS);
    Master::at(0.0, 0.0).lead(&mut axis, 1);
    let job = start(&mut axis, &move_absolute(10.0));
    run(&mut axis, 1_000);
    assert_eq!(axis.progress(job), CommandState::Done);
    let refused = axis.command(&Command::GearIn(GearIn::of(1.0))).unwrap_err();
    assert_eq!(refused, Refusal::NoMaster);
}

/// Steps of the master, and the code of the resulting error.
#[test]
fn set_values_that_no_axis_can_have_are_an_error_stop() {
    type Step = fn(&mut Kinematics);
    let steps: [Step; 3] = [
        |m| m.position = f64::NAN,
        |m| m.position = 1e13,
        |m| m.acceleration = f64::INFINITY,
    ];
    for step in steps {
        let (mut axis, mut master) = coupled(&PARAMETERS, 200.0);
        let mut differences = Differences::of(&axis);
        for _ in 0..10 {
            master.lead(&mut axis, 1);
            differences.keep(&axis, &PARAMETERS);
        }
        let mut wrong = master.0;
        step(&mut wrong);
        for _ in 0..200 {
            axis.update(Some(&wrong), CYCLE);
            differences.keep(&axis, &PARAMETERS);
        }
        assert_eq!(axis.status(), AxisStatus::ErrorStop);
        assert_eq!(axis.error().map(|error| error.code()), Some(0x42d5));
        assert_eq!(axis.set().velocity, 0.0);
    }
}

/// An axis with a master that steps once by a position and a velocity, then moves on evenly.
fn stepped(parameters: &SlaveParameters, position: f64, velocity: f64) -> (AxisWithPlates, u32) {
    let (mut axis, mut master) = coupled(parameters, 200.0);
    master.lead(&mut axis, 10);
    let apart = axis.set().position - master.0.position;
    let mut differences = Differences::of(&axis);
    master.0.position += position;
    master.0.velocity += velocity;
    let mut off = 0;
    for _ in 0..3_000 {
        master.lead(&mut axis, 1);
        differences.keep(&axis, parameters);
        off += u32::from(axis.tracking() != GuardState::Tracking);
    }
    if axis.status() == AxisStatus::SynchronizedMotion {
        assert_eq!(axis.tracking(), GuardState::Tracking);
        assert_eq!(axis.set().velocity, master.0.velocity);
        let off = axis.set().position - master.0.position - apart - axis.distance();
        assert!(off.abs() < 1e-9, "{off}");
    }
    (axis, off)
}

#[test]
fn a_master_that_steps_is_caught_up_within_the_limits() {
    // A beat in both directions, an encoder's step, the return from an outage.
    for (position, velocity) in [
        (0.2, 0.0),
        (-0.2, 0.0),
        (0.0, 6.0),
        (0.0, -10.0),
        (80.0, 0.0),
    ] {
        let (axis, off) = stepped(&PARAMETERS, position, velocity);
        assert_eq!(axis.status(), AxisStatus::SynchronizedMotion);
        assert_eq!(axis.error(), None);
        assert_eq!(axis.distance(), 0.0);
        assert!(
            (3..600).contains(&off),
            "{position} {velocity}: {off} cycles"
        );
    }
}

#[test]
fn with_velo_sync_the_distance_stays() {
    let parameters = SlaveParameters {
        distance: DistanceParameters {
            policy: DistancePolicy::VeloSync,
            ..DistanceParameters::default()
        },
        ..PARAMETERS
    };
    let (axis, off) = stepped(&parameters, 80.0, 0.0);
    assert_eq!(axis.status(), AxisStatus::SynchronizedMotion);
    // Most of the step: the velocity is quickly that of the master again.
    assert!((axis.distance() + 80.0).abs() < 1.0, "{}", axis.distance());
    assert!(off < 100, "{off} cycles");
}

#[test]
fn a_master_that_is_too_fast_or_too_far_is_a_fault_after_its_time() {
    let narrow = SlaveParameters {
        distance: DistanceParameters {
            window: Some(1.0),
            time_s: Some(0.05),
            ..DistanceParameters::default()
        },
        ..PARAMETERS
    };
    let watched = SlaveParameters {
        distance: DistanceParameters {
            window: Some(0.0),
            ..DistanceParameters::default()
        },
        ..PARAMETERS
    };
    for (parameters, position, velocity, expected) in [
        (&narrow, 20.0, 0.0, true),
        (&narrow, 0.2, 0.0, false),
        (&PARAMETERS, 0.0, 900.0, true),
        (&PARAMETERS, 500.0, 0.0, true),
        (&watched, 500.0, 0.0, false),
    ] {
        let (axis, _) = stepped(parameters, position, velocity);
        let failed = axis.status() == AxisStatus::ErrorStop;
        assert_eq!(failed, expected, "{position} {velocity}");
        let left_behind = matches!(
            axis.error(),
            Some(SlaveError::Guard(GuardFault::LeftBehind { .. }))
        );
        assert_eq!(left_behind, expected);
    }
}

#[test]
fn a_distance_is_dropped_by_whatever_takes_over() {
    for command in [HALT, STOP, move_velocity(-100.0), move_absolute(-50.0)] {
        let (mut axis, mut master) = coupled(&PARAMETERS, 200.0);
        let mut differences = Differences::of(&axis);
        master.0.position += 50.0;
        for _ in 0..100 {
            master.lead(&mut axis, 1);
            differences.keep(&axis, &PARAMETERS);
        }
        assert_eq!(axis.tracking(), GuardState::CatchingUp);
        assert!(axis.distance() < -10.0);
        start(&mut axis, &command);
        for _ in 0..1_500 {
            master.lead(&mut axis, 1);
            differences.keep(&axis, &PARAMETERS);
        }
        assert_eq!(axis.tracking(), GuardState::Tracking);
        assert!(axis.distance().abs() < 1e-9);
    }
}

#[test]
fn a_coupled_slave_is_braked_before_its_software_limit() {
    let (mut axis, mut master) = coupled(&LIMITED, 900.0);
    master.lead(&mut axis, 5_000);
    assert_eq!(axis.status(), AxisStatus::ErrorStop);
    assert!(matches!(
        axis.error(),
        Some(SlaveError::Guard(GuardFault::SoftwareLimit { .. }))
    ));
    let rest = axis.set();
    assert!((998.0..=1_000.0).contains(&rest.position), "{rest:?}");
}

#[test]
fn sample_1_of_the_flying_gear_on_the_axis() {
    let mut axis = powered(&LIMITED);
    start(&mut axis, &move_absolute(500.0));
    run(&mut axis, 2_000);
    let mut master = Master::at(800.0, 0.0);
    master.lead(&mut axis, 1);
    let gear = FlyingGearParameters {
        ratio: 1.0,
        master_sync_position: 460.0,
        slave_sync_position: 450.0,
        slave_desync_position: 450.0,
        slave_stop_position: 500.0,
        default_slave_negative: false,
    };
    let job = start(&mut axis, &Command::from(gear));
    assert_eq!(axis.progress(job), CommandState::Waiting);
    let mut master = Master::at(800.0, -200.0);
    master.lead(&mut axis, 1_100);
    assert_eq!(axis.axis_struct(1).axis_state, AxisState::SlavePrephase);
    master.lead(&mut axis, 500);
    assert_eq!(axis.progress(job), CommandState::Active);
    assert_eq!(
        axis.axis_struct(1).axis_state,
        AxisState::SlaveSynchronizing
    );
    master.lead(&mut axis, 400);
    assert_eq!(axis.progress(job), CommandState::InSync);
    assert!((axis.set().position - 390.0).abs() < 1e-9);
    // The master reverses within the slave's limits.
    while master.0.velocity < 200.0 {
        master.0.velocity += 2.0;
        master.0.acceleration = 2_000.0;
        master.lead(&mut axis, 1);
    }
    master.0.acceleration = 0.0;
    master.lead(&mut axis, 3_000);
    assert_eq!(axis.error(), None);
    assert_eq!(axis.progress(job), CommandState::Waiting);
    assert_eq!(axis.set(), Kinematics::at_rest(500.0));
    start(&mut axis, &Command::GearOut {});
    assert_eq!(axis.status(), AxisStatus::Standstill);
}

#[test]
fn a_flying_gear_needs_a_slave_at_rest() {
    let (mut axis, mut master) = coupled(&PARAMETERS, 200.0);
    master.lead(&mut axis, 1);
    let gear = FlyingGearParameters {
        ratio: 1.0,
        master_sync_position: 460.0,
        slave_sync_position: 450.0,
        slave_desync_position: 450.0,
        slave_stop_position: 500.0,
        default_slave_negative: false,
    };
    let refused = axis.command(&Command::from(gear)).unwrap_err();
    assert_eq!(refused, Refusal::NotAtRest { velocity: 200.0 });
}

/// The window of 20 u of the slave, at a ratio of 1: 40 u of the master.
const SHORT: FlyingGearParameters = FlyingGearParameters {
    ratio: 1.0,
    master_sync_position: 500.0,
    slave_sync_position: 20.0,
    slave_desync_position: 120.0,
    slave_stop_position: 140.0,
    default_slave_negative: false,
};

#[test]
fn a_flying_gear_that_its_slave_cannot_follow_is_refused() {
    // At 300 u/s: 1.5·300²/40 = 3375 u/s², and 6·300³/40² = 101 250 u/s³.
    for (velocity, passes) in [(200.0, true), (298.0, true), (300.0, false), (900.0, false)] {
        let mut axis = powered(&PARAMETERS);
        let mut master = Master::at(0.0, velocity);
        let mut differences = Differences::of(&axis);
        master.lead(&mut axis, 5);
        let planned = axis.plan(&Command::from(SHORT));
        assert_eq!(planned.is_ok(), passes, "{velocity}");
        if let Err(refusal) = planned {
            assert_eq!(refusal.code(), 0x42dd);
            let text = std::string::ToString::to_string(&refusal);
            assert!(text.contains("lead it at up to 298.7"), "{text}");
            continue;
        }
        let job = start(&mut axis, &Command::from(SHORT));
        while axis.coupling_phase() != Some(CouplingPhase::Released) {
            master.lead(&mut axis, 1);
            differences.keep(&axis, &PARAMETERS);
        }
        assert_eq!(axis.progress(job), CommandState::Waiting);
        assert_eq!(axis.set(), Kinematics::at_rest(140.0));
    }
}

#[test]
fn a_master_that_comes_too_fast_finds_the_flying_gear_refused() {
    let mut axis = powered(&PARAMETERS);
    let mut master = Master::at(0.0, 200.0);
    master.lead(&mut axis, 1);
    let job = start(&mut axis, &Command::from(SHORT));
    master.0.velocity = 400.0;
    master.lead(&mut axis, 2_000);
    let CommandState::Failed(JobError::Refused(refusal)) = axis.progress(job) else {
        panic!("{:?}", axis.progress(job));
    };
    assert_eq!(refusal.code(), 0x42dd);
    assert_eq!(
        (axis.status(), axis.error()),
        (AxisStatus::Standstill, None)
    );
    assert_eq!(axis.set(), Kinematics::at_rest(0.0));
}

#[test]
fn a_flying_gear_beyond_the_software_limits_is_refused() {
    let mut axis = powered(&LIMITED);
    Master::at(0.0, 0.0).lead(&mut axis, 1);
    let far = FlyingGearParameters {
        slave_stop_position: 1_001.0,
        ..SHORT
    };
    let refused = axis.command(&Command::from(far)).unwrap_err();
    assert_eq!(refused.code(), 0x4229);
}
