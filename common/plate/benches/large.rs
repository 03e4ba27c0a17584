//! Cost of large plates: made of as many points as a long table has rows, checked, and judged.

use std::hint::black_box;

use coaxle_curve::law::MotionLaw;
use coaxle_plate::{
    Course, Interpolation, MotionFunction, MotionPoint, Plate, PointType, PositionTable,
};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};

const POINTS: u32 = 100_000;

/// Returns a row of a wave with all derivatives, so that the slave has extremes inside segments and every
/// segment differs.
fn wave(row: u32) -> MotionPoint {
    let (sin, cos) = (f64::from(row) * 0.7).sin_cos();
    MotionPoint {
        index: row + 1,
        function: MotionLaw::Polynom5Mm,
        point_type: PointType::Motion,
        relative_next: 1,
        master: f64::from(row),
        // 50·sin(0.7x), with the factors 0.7 and 0.49 in its derivatives.
        slave: 50.0 * sin,
        velocity: 35.0 * cos,
        acceleration: -24.5 * sin,
        jerk: 0.0,
    }
}

fn points(law: MotionLaw) -> Vec<MotionPoint> {
    (0..POINTS)
        .map(wave)
        .map(|point| match law {
            MotionLaw::Polynom5Mm => point,
            function => MotionPoint {
                function,
                ..MotionPoint::rest(point.index, point.master, point.slave)
            },
        })
        .collect()
}

fn function(points: Vec<MotionPoint>) -> Plate {
    let function = MotionFunction::new(points).expect("the points are right");
    Plate::from_function(function, Course::Cyclic)
}

fn table(rows: &[(f64, f64)]) -> Plate {
    let table = PositionTable::new(rows, Interpolation::Spline, Course::Linear);
    Plate::from_table(table.expect("the rows are right"))
}

fn functions(c: &mut Criterion) {
    let mut group = c.benchmark_group("100 000 points");
    group.sample_size(10);
    for law in [
        MotionLaw::Polynom5Mm,
        MotionLaw::Polynom5,
        MotionLaw::Modsinuslinie,
    ] {
        let points = points(law);
        group.bench_function(format!("{law:?}, made"), |b| {
            b.iter_batched(|| points.clone(), function, BatchSize::LargeInput);
        });
        let plate = function(points);
        judged(&mut group, &format!("{law:?}"), &plate);
    }
    let rows: Vec<_> = (0..POINTS)
        .map(wave)
        .map(|point| (point.master, point.slave))
        .collect();
    group.bench_function("table, made", |b| b.iter(|| table(black_box(&rows))));
    judged(&mut group, "table", &table(&rows));
    group.finish();
}

fn judged(
    group: &mut criterion::BenchmarkGroup<'_, criterion::measurement::WallTime>,
    name: &str,
    plate: &Plate,
) {
    group.bench_function(format!("{name}, characteristics"), |b| {
        b.iter(|| black_box(plate).characteristics(1.0));
    });
    group.bench_function(format!("{name}, joints"), |b| {
        b.iter(|| {
            plate
                .joints()
                .filter(|joint| joint.steps()[0] != 0.0)
                .count()
        });
    });
}

criterion_group!(large, functions);
criterion_main!(large);
