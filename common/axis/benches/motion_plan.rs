//! Cost of a planned motion: a state of it, and the check of a new plan.

use std::hint::black_box;

use coaxle_axis::motion_plan::{MOST_PIECES, MotionPiece, MotionPlan};
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
    c.bench_function("check of a plan", |b| {
        b.iter(|| MotionPlan::new(black_box(&pieces), end, &limits).is_ok());
    });
}

criterion_group!(benches, plans);
criterion_main!(benches);
