//! Cost of planning and running the flying saw, beside `rsruckig` in the same run.

use std::hint::black_box;

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_saw::{
    CouplingMoment, GearInPos, GearInVelo, Ratio, SawCommand, SawCoupling, SawTolerances,
    SlaveLimits, SyncLimits, SyncMask, SyncMode,
};
use criterion::{Criterion, criterion_group, criterion_main};
use rsruckig::prelude::{ControlInterface, IgnoreErrorHandler, InputParameter, Ruckig, Trajectory};

fn moment(slave: Kinematics) -> CouplingMoment {
    CouplingMoment {
        master: Kinematics {
            position: -500.0,
            velocity: 500.0,
            acceleration: 0.0,
        },
        encoder: None,
        slave,
        axis: SlaveLimits {
            dynamics: Limits::new(2_000.0, 2_500.0, 2_500.0, 5_000.0).expect("above zero"),
            min_position: Some(-1e4),
            max_position: Some(1e4),
            guard: None,
        },
    }
}

fn moving(velocity: f64) -> Kinematics {
    Kinematics {
        position: -250.0,
        velocity,
        acceleration: 0.0,
    }
}

fn to_position(mask: SyncMask) -> GearInPos {
    GearInPos {
        ratio: Ratio::of(1.0),
        master_sync_position: 1_000.0,
        slave_sync_position: 1_000.0,
        master_start_distance: None,
        strategy: None,
        sync_mode: SyncMode::position_based(mask),
        limits: SyncLimits {
            // Above the 506 u/s at which the quintic peaks, so that it passes its checks.
            velocity: Some(550.0),
            min_position: Some(-1e4),
            max_position: Some(1e4),
            ..SyncLimits::default()
        },
    }
}

fn to_velocity(sync_mode: SyncMode) -> GearInVelo {
    GearInVelo {
        ratio: Ratio::of(1.0),
        sync_mode,
        limits: SyncLimits::default(),
    }
}

fn planning(c: &mut Criterion) {
    let mut group = c.benchmark_group("plan");
    let start = moment(moving(250.0));
    // Overshoots of velocity are allowed here, or the path would not be a quintic.
    let shoots = SyncMask::OVERSHOOT_VELO | SyncMask::UNDERSHOOT_VELO;
    let all = SyncMask::CHECKS - shoots;
    group.bench_function("quintic, no check", |b| {
        let command = to_position(SyncMask::empty());
        b.iter(|| black_box(&command).plan(black_box(&start)));
    });
    group.bench_function("quintic, all checks", |b| {
        let command = to_position(all);
        b.iter(|| black_box(&command).plan(black_box(&start)).expect("passes"));
    });
    group.bench_function("P5+P1, all checks", |b| {
        let command = to_position(SyncMask::CHECKS);
        b.iter(|| black_box(&command).plan(black_box(&start)).expect("passes"));
    });
    group.bench_function("P5+P1+P5 at the acceleration limit", |b| {
        let command = to_position(SyncMask::PREFER_CONST_VELO | SyncMask::MAX_JERK);
        b.iter(|| black_box(&command).plan(black_box(&start)).expect("passes"));
    });
    group.bench_function("quintic from a reversal, position and dynamics", |b| {
        let start = moment(moving(-250.0));
        let command = to_position(SyncMask::MAX_DYNAMICS - SyncMask::MAX_VELO);
        b.iter(|| black_box(&command).plan(black_box(&start)).expect("passes"));
    });
    group.bench_function("ramp", |b| {
        let command = to_velocity(SyncMode::default());
        b.iter(|| black_box(&command).plan(black_box(&start)).expect("passes"));
    });
    group.bench_function("ramp from acceleration", |b| {
        let mut start = start;
        start.slave.acceleration = 500.0;
        let command = to_velocity(SyncMode::default());
        b.iter(|| black_box(&command).plan(black_box(&start)).expect("passes"));
    });
    group.bench_function("time-based", |b| {
        let command = to_velocity(SyncMode::time_based(SyncMask::empty()));
        b.iter(|| black_box(&command).plan(black_box(&start)).expect("passes"));
    });
    group.bench_function("time-based, rsruckig", |b| {
        let mut input = InputParameter::<1>::new(None);
        input.control_interface = ControlInterface::Velocity;
        input.current_position[0] = -250.0;
        input.current_velocity[0] = 250.0;
        input.target_velocity[0] = 500.0;
        input.max_velocity[0] = 2_000.0;
        input.max_acceleration[0] = 2_500.0;
        input.max_jerk[0] = 5_000.0;
        let mut ruckig = Ruckig::<1, IgnoreErrorHandler>::new(None, 1e-3);
        let mut trajectory = Trajectory::<1>::new(None);
        b.iter(|| ruckig.calculate(black_box(&input), &mut trajectory).is_ok());
    });
    group.finish();
}

fn running(c: &mut Criterion) {
    let mut group = c.benchmark_group("cycle");
    let cycle = Seconds(1e-3);
    let coupling = |start| {
        let command = SawCommand::GearInPos(to_position(SyncMask::empty()));
        SawCoupling::start(command, &start, SawTolerances::default()).expect("couples")
    };
    // At 0 the master is within the synchronisation phase, at 2000 beyond it.
    let master = |position: f64| Kinematics {
        position,
        velocity: 500.0,
        acceleration: 0.0,
    };
    group.bench_function("synchronising", |b| {
        let mut coupling = coupling(moment(moving(250.0)));
        b.iter(|| coupling.update(black_box(&master(0.0)), cycle));
    });
    group.bench_function("synchronous", |b| {
        let mut coupling = coupling(moment(moving(250.0)));
        b.iter(|| coupling.update(black_box(&master(2_000.0)), cycle));
    });
    group.finish();
}

criterion_group!(benches, planning, running);
criterion_main!(benches);
