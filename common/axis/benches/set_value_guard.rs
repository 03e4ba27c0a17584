//! Cost of the guard of the set values per cycle: passing, and catching up.

use std::hint::black_box;

use coaxle_axis::set_value_guard::{GuardState, SetValueGuard};
use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};

const T: f64 = 0.001;

fn guard(min: f64, max: f64, here: &Kinematics) -> SetValueGuard {
    let limits = Limits::new(1_000.0, 10_000.0, 10_000.0, 200_000.0).expect("above zero");
    SetValueGuard::new(&limits, min, max, Seconds(T), here).expect("a cycle time")
}

fn moving(cycle: u32) -> Kinematics {
    Kinematics {
        position: 0.5 * f64::from(cycle),
        velocity: 500.0,
        acceleration: 0.0,
    }
}

/// The guards on the way to a target far ahead, one per cycle.
fn catching_up(min: f64, max: f64) -> Vec<(SetValueGuard, Kinematics)> {
    let mut guard = guard(min, max, &Kinematics::at_rest(0.0));
    (100..)
        .map(|cycle| {
            let before = guard;
            let target = moving(cycle);
            (guard.update(&target, 1).state, (before, target))
        })
        .take_while(|(state, _)| *state != GuardState::Tracking)
        .map(|(_, update)| update)
        .collect()
}

fn passing(c: &mut Criterion) {
    let mut group = c.benchmark_group("passing");
    for (name, wall) in [("no walls", f64::INFINITY), ("walls far off", 1e9)] {
        group.bench_function(name, |b| {
            let mut guard = guard(-wall, wall, &moving(0));
            let mut cycle = 0;
            b.iter(|| {
                cycle += 1;
                guard.update(black_box(&moving(cycle)), 1)
            });
            assert_eq!(
                guard.update(&moving(cycle + 1), 1).state,
                GuardState::Tracking
            );
        });
    }
    group.finish();
}

fn departed(c: &mut Criterion) {
    let mut group = c.benchmark_group("catching up");
    for (name, wall) in [("walls far off", 1e9), ("walls near", 250.0)] {
        let updates = catching_up(-wall, wall);
        let mut next = (0..updates.len()).cycle();
        group.bench_function(name, |b| {
            b.iter_batched_ref(
                || updates[next.next().expect("without end")],
                |(guard, target)| guard.update(target, 1),
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, passing, departed);
criterion_main!(benches);
