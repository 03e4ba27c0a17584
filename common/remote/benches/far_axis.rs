//! Cost of a far axis in a cycle: moved from its newest frame to now, shown later between two frames, and by its plan.

use std::f64::consts::TAU;
use std::hint::black_box;

use coaxle_axis::motion_plan::MotionPiece;
use coaxle_clock::{CycleIndex, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_remote::{
    AxisSyncParameters, FarAxis, FarCorrection, FarSync, FrameHistory, KnownMotion, PlannedAhead,
    PlannedMotion, ReceivedPlan, ShownLater,
};
use criterion::{Criterion, criterion_group, criterion_main};

const CYCLE: Span = Span::from_millis(1);
/// Frames of a sender, in a ring: those of a second.
const FRAMES: u64 = 1_000;
/// Time by which the axis is shown later.
const LATER: Seconds = Seconds(20e-3);

/// An axis that swings once a second, in the n-th cycle.
fn master(count: u64) -> Kinematics {
    let (sine, cosine) = (TAU * count as f64 * 1e-3).sin_cos();
    Kinematics {
        position: -350.0 / TAU * cosine,
        velocity: 350.0 * sine,
        acceleration: 350.0 * TAU * cosine,
    }
}

/// The correction of a clock that is known: the newest frame is 2.3 ms old.
fn correction() -> FarCorrection {
    let mut clock = FarSync::start(CYCLE, &AxisSyncParameters::default()).expect("in range");
    clock.update_by_clock(CycleIndex(0), Some(Seconds(2.3e-3)), 1)
}

fn axis() -> FarAxis {
    FarAxis::start(CYCLE, &AxisSyncParameters::default()).expect("in range")
}

fn far_axes(c: &mut Criterion) {
    let correction = correction();
    let sets: Vec<_> = (0..FRAMES).map(master).collect();
    let mut group = c.benchmark_group("far axis, a cycle");
    group.bench_function("extrapolated", |b| {
        let (mut axis, mut n) = (axis(), 0);
        b.iter(|| {
            n = (n + 1) % sets.len();
            axis.update(black_box(&sets[n]), &correction, KnownMotion::default(), 1)
        });
    });
    group.bench_function("between two frames", |b| {
        let (mut axis, mut count) = (axis(), 0);
        let mut frames = FrameHistory::new(CYCLE);
        b.iter(|| {
            count += 1;
            let set = black_box(&sets[(count % FRAMES) as usize]);
            frames.take(count, set, LATER.to_span());
            let later = Some(ShownLater {
                frames: &frames,
                by: LATER,
            });
            let known = KnownMotion {
                later,
                planned: None,
            };
            axis.update(set, &correction, known, 1)
        });
    });
    group.bench_function("by its plan", |b| {
        let (mut axis, mut n) = (axis(), 0);
        let motion = promised(&sets);
        b.iter(|| {
            n = (n + 1) % sets.len();
            let planned = Some(PlannedAhead {
                motion: &motion,
                newest: CYCLE * n as i64,
            });
            let known = KnownMotion {
                later: None,
                planned,
            };
            axis.update(black_box(&sets[n]), &correction, known, 1)
        });
    });
    group.finish();
}

/// Eight pieces over all frames, which the first one confirms.
fn promised(sets: &[Kinematics]) -> PlannedMotion {
    let lasts = CYCLE * (sets.len() as i64 / 8 + 1);
    let mut from = sets[0];
    let pieces = [0, 1, 2, 3, 4, 5, 6, 7].map(|n| {
        let piece = MotionPiece {
            start: lasts * n,
            duration: lasts,
            from,
            jerk: if n % 2 == 0 { 1_000.0 } else { -1_000.0 },
        };
        from = piece.at(piece.end(), Seconds::ZERO);
        piece
    });
    let mut motion = PlannedMotion::default();
    let plan = ReceivedPlan {
        count: 0,
        pieces: &pieces,
        promised_until: pieces[7].end(),
    };
    motion.take(&plan).expect("a plan");
    motion.check(Span::ZERO, &sets[0]).expect("its own state");
    motion
}

criterion_group!(benches, far_axes);
criterion_main!(benches);
