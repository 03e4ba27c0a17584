//! Cost of evaluating a cam plate (position, velocity and acceleration, along a path and at random), of a
//! change of a point in place, and of a coupled slave per cycle.

use std::hint::black_box;

use coaxle_cam::{
    CamCoupling, CamInV2, CamLimits, CamRequest, CouplingParameters, JumpHandling, Tables,
};
use coaxle_curve::law::{Motion, MotionLaw};
use coaxle_curve::profile::Kinematics;
use coaxle_plate::{
    Course, Cursor, Interpolation, MotionFunction, MotionPoint, Plate, PointType, PositionTable,
};
use criterion::{Criterion, criterion_group, criterion_main};

const POINTS: u32 = 64;

/// Rests at unequal distances, up and down and with a lift over all.
fn points(law: MotionLaw) -> Vec<MotionPoint> {
    (0..POINTS)
        .map(|row| MotionPoint {
            index: row + 1,
            function: law,
            point_type: PointType::Rest,
            relative_next: 1,
            master: f64::from(row) * 10.0 + f64::from(row % 3),
            slave: f64::from(row) + f64::from(row % 2) * 25.0,
            velocity: 0.0,
            acceleration: 0.0,
            jerk: 0.0,
        })
        .collect()
}

fn function(law: MotionLaw) -> Plate {
    let function = MotionFunction::new(points(law)).expect("the points are right");
    Plate::from_function(function, Course::Cyclic)
}

fn table(interpolation: Interpolation) -> Plate {
    let rows: Vec<_> = (0..=3_600)
        .map(|row| f64::from(row) * 0.1)
        .map(|master| (master, 50.0 * (master.to_radians()).sin()))
        .collect();
    let table = PositionTable::equidistant(&rows, interpolation, Course::Cyclic);
    Plate::from_table(table.expect("the rows are right"))
}

/// Returns the masters over three cycles: in small steps, and in random order.
fn masters(plate: &Plate) -> [Vec<f64>; 2] {
    let (start, _) = plate.master_range();
    let share = |i: u32| f64::from(i) / 4_096.0;
    let place = |share: f64| start + (3.0 * share - 1.0) * plate.period();
    let path = (0..4_096).map(|i| place(share(i))).collect();
    let random = (0..4_096_u32)
        // About 2³² divided by the golden ratio: the upper twelve bits scatter over 3687 of the 4096 places.
        .map(|i| place(share(i.wrapping_mul(2_654_435_761) >> 20)))
        .collect();
    [path, random]
}

fn bench_plate(c: &mut Criterion, name: &str, plate: &Plate) {
    // No jerk: the coupling needs none, and the compiler may drop its computation there as well.
    let shown = |motion: Motion| black_box((motion.position, motion.velocity, motion.acceleration));
    let [path, random] = masters(plate);
    c.bench_function(&format!("{name}, along a path"), |b| {
        let (mut cursor, mut masters) = (Cursor::default(), path.iter().cycle());
        b.iter(|| masters.next().map(|&m| shown(plate.along(&mut cursor, m))));
    });
    c.bench_function(&format!("{name}, at random"), |b| {
        let mut masters = random.iter().cycle();
        b.iter(|| masters.next().map(|&m| shown(plate.at(m))));
    });
}

fn plates(c: &mut Criterion) {
    for law in [
        MotionLaw::Polynom5,
        MotionLaw::Polynom7,
        MotionLaw::Peisekah11,
        MotionLaw::Modsinuslinie,
        MotionLaw::Beschltrapez,
        MotionLaw::SplineNatural,
    ] {
        bench_plate(c, &format!("64 points, {law:?}"), &function(law));
    }
    for interpolation in [Interpolation::Linear, Interpolation::Spline] {
        let name = format!("3601 rows, {interpolation:?}");
        bench_plate(c, &name, &table(interpolation));
    }
}

fn change(c: &mut Criterion) {
    let mut plate = function(MotionLaw::Polynom5);
    let point = points(MotionLaw::Polynom5)[30];
    c.bench_function("64 points, change one", |b| {
        b.iter(|| plate.change(black_box(&[point])));
    });
}

/// Makes a slave coupled by this number of plates of 64 points.
fn coupled(plates: u32) -> (Tables, CamCoupling) {
    let mut tables = Tables::new(4);
    let mut coupling = CamCoupling::new(CouplingParameters {
        master_axis_id: 1,
        slave_axis_id: 2,
        limits: CamLimits {
            velocity: 1e3,
            acceleration: 1e4,
            deceleration: 1e4,
            jerk: 1e6,
            cycle: 1e-3,
        },
    })
    .expect("the parameters are right");
    for table in 1..=plates {
        let plate = function(MotionLaw::Polynom5);
        tables.insert(table, plate).expect("there is room");
        let add = CamRequest::from(CamInV2 {
            table,
            jump: JumpHandling::Allow,
            ..CamInV2::default()
        });
        let axis = Kinematics::default();
        coupling
            .start(&mut tables, &add, &axis, &axis)
            .expect("the command is right");
    }
    (tables, coupling)
}

fn couplings(c: &mut Criterion) {
    let [path, random] = masters(&function(MotionLaw::Polynom5));
    for (name, masters) in [("along a path", path), ("at random", random)] {
        for plates in [1, 4] {
            let (mut tables, mut coupling) = coupled(plates);
            c.bench_function(&format!("slave of {plates}, {name}"), |b| {
                let mut masters = masters.iter().cycle();
                b.iter(|| {
                    masters.next().map(|&position| {
                        let master = Kinematics {
                            position,
                            velocity: 100.0,
                            acceleration: 10.0,
                        };
                        black_box(coupling.update(&mut tables, black_box(&master)))
                    })
                });
            });
        }
    }
}

criterion_group!(cam, plates, change, couplings);
criterion_main!(cam);
