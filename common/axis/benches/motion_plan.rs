//! Cost of a planned motion: a state of it, the instant of a position, and the check of a new plan.

use std::hint::black_box;

use coaxle_axis::motion_plan::{AwaitedPosition, MOST_PIECES, MotionPiece, MotionPlan};
use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::{Kinematics, Limits};
use criterion::{Criterion, criterion_group, criterion_main};

/// Eight pieces of 50 ms, with a jerk to and fro.
fn pieces() -> [MotionPiece; MOST_PIECES] {
    let mut from = Kinematics::at_rest(0.0);
    std::array::from_fn(|n| {
        let piece = MotionPiece {
            start: Span::from_millis(50 * n as i64),
            duration: Span::from_millis(50),
            from,
            jerk: if n % 4 < 2 { 1_000.0 } else { -1_000.0 },
        };
        from = piece.at(piece.end(), Seconds::ZERO);
        piece
    })
}

fn plans(c: &mut Criterion) {
    let limits = Limits::new(1_000.0, 10_000.0, 10_000.0, 200_000.0).expect("above zero");
    let pieces = pieces();
    let end = pieces[MOST_PIECES - 1].end();
    let plan = MotionPlan::new(&pieces, end, &limits).expect("a plan");
    c.bench_function("planned state", |b| {
        let mut t = 0.0;
        b.iter(|| {
            t = if t > 0.39 { 0.0 } else { t + 1e-3 };
            black_box(&plan).at(Span::ZERO, Seconds(black_box(t)))
        });
    });
    c.bench_function("piece evaluated", |b| {
        let mut t = 0.0;
        b.iter(|| {
            t = if t > 0.049 { 0.0 } else { t + 1e-3 };
            black_box(&pieces[3]).at(pieces[3].start, Seconds(black_box(t)))
        });
    });
    let passage = |position: f64| {
        let awaited = AwaitedPosition {
            position,
            modulo: None,
            direction: None,
        };
        plan.passage(Span::ZERO, &awaited)
    };
    let last = passage(plan.at(end, Seconds::ZERO).expect("promised").position);
    assert!(last.is_some_and(|passage| passage.at > pieces[MOST_PIECES - 1].start));
    c.bench_function("instant of a position in the last of eight pieces", |b| {
        let position = last.expect("it is reached").state.position - 1.0;
        b.iter(|| passage(black_box(position)));
    });
    c.bench_function("no instant of a position in eight pieces", |b| {
        b.iter(|| passage(black_box(1e6)));
    });
    c.bench_function("check of a plan", |b| {
        b.iter(|| MotionPlan::new(black_box(&pieces), end, &limits).is_ok());
    });
}

criterion_group!(benches, plans);
criterion_main!(benches);
