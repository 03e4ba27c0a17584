//! Cam plates of any points and laws: their greatest demands are those of a fine scan, before and after an online
//! change, and a coupling by one is accepted only if the scan keeps the slave's limits.

use coaxle_cam::{
    Activation, ActivationMode, CamCoupling, CamIn, CamLimits, CouplingError, CouplingParameters,
    JumpHandling, Tables,
};
use coaxle_curve::law::{Motion, MotionLaw};
use coaxle_curve::profile::Kinematics;
use coaxle_plate::{
    Course, Cursor, Interpolation, MotionFunction, MotionPoint, Plate, PointType, PositionTable,
};

use crate::Outcome;
use crate::bytes::Bytes;

/// Most points of a plate: each segment is scanned.
const MOST_POINTS: usize = 12;
/// Places of a scan in each segment.
const SCANNED: u32 = 64;
/// Rounding of a law near its peak, relative: couplings allow as much beyond a limit.
const ROUNDING: f64 = 1e-6;
/// Least length of a segment, relative to the largest master, that a look ahead resolves to that rounding.
const LEAST: f64 = 1e-7;
/// Number of the plate.
const TABLE: u32 = 30;

/// A plate, its online changes, and a coupling by it.
pub(crate) fn plate(data: &[u8]) -> Outcome {
    let mut bytes = Bytes::new(data);
    let made = make(&mut bytes).ok_or_else(|| "ends within the points".to_owned())?;
    let mut plate = made?;
    examine(&plate);
    couple(&plate, &mut bytes);
    while let Some(points) = points(&mut bytes) {
        change(&mut plate, &points);
        couple(&plate, &mut bytes);
    }
    Ok(())
}

fn make(bytes: &mut Bytes<'_>) -> Option<Result<Plate, String>> {
    let course = bytes.one_of(&[Course::Cyclic, Course::Linear])?;
    let kind = bytes.byte()?;
    let points = points(bytes)?;
    let function = |points| Ok(Plate::from_function(MotionFunction::new(points)?, course));
    let table = |kind| {
        let rows: Vec<_> = points
            .iter()
            .map(|point| (point.master, point.slave))
            .collect();
        Ok(Plate::from_table(PositionTable::new(&rows, kind, course)?))
    };
    let made: Result<Plate, coaxle_plate::CamError> = match kind % 8 {
        0 => table(Interpolation::Linear),
        1 => table(Interpolation::Spline),
        2 => table(Interpolation::SlidingSpline),
        _ => function(points),
    };
    Some(made.map_err(|error| error.to_string()))
}

/// Points with ascending masters; none at the end of the input.
fn points(bytes: &mut Bytes<'_>) -> Option<Vec<MotionPoint>> {
    let count = 1 + usize::from(bytes.byte()?) % MOST_POINTS;
    // Masters of an hour, slaves of a micrometre and back.
    let (wide, high) = (bytes.decades(-3.0, 6.0)?, bytes.decades(-6.0, 6.0)?);
    let mut master = wide * bytes.share()?;
    let point = |index: u32| {
        let law = bytes.one_of(MotionLaw::ALL)?;
        let kind = bytes.byte()?;
        let mut point = MotionPoint {
            function: law,
            point_type: kind_of(kind),
            ..MotionPoint::rest(index, master, high * bytes.share()?)
        };
        // Derivatives in the order of those that the plate itself may have.
        if kind & 0x40 != 0 {
            point.velocity = high / wide * 4.0 * bytes.share()?;
            point.acceleration = high / (wide * wide) * 16.0 * bytes.share()?;
        }
        master += wide * bytes.decades(-4.0, 1.0)?;
        Some(point)
    };
    (1..).take(count).map(point).collect()
}

const fn kind_of(byte: u8) -> PointType {
    match byte % 8 {
        0 | 1 => PointType::Rest,
        2 => PointType::Velocity,
        3 => PointType::Turn,
        4 | 5 => PointType::Motion,
        6 => PointType::Activation,
        _ => PointType::Ignore,
    }
}

/// Masters of the points or rows.
fn joints(plate: &Plate) -> Vec<f64> {
    match (plate.function(), plate.table()) {
        (Some(function), _) => {
            let points = function.points().iter();
            points.map(|point| point.master).collect()
        }
        (_, Some(table)) => table.rows().iter().map(|row| row.0).collect(),
        _ => Vec::new(),
    }
}

/// Masters of a scan: a grid in each segment, and its ends.
fn scanned(plate: &Plate) -> Vec<f64> {
    let joints = joints(plate);
    let segments = joints.windows(2);
    let grid = segments.flat_map(|ends| {
        let step = (ends[1] - ends[0]) / f64::from(SCANNED);
        (0..SCANNED).map(move |place| ends[0] + step * (f64::from(place) + 0.5))
    });
    let (start, end) = plate.master_range();
    grid.filter(|master| (start..=end).contains(master))
        .collect()
}

/// Checks the greatest demands against a scan, and each value by a cursor against the one without.
fn examine(plate: &Plate) {
    let most = plate.greatest_demands();
    let mut cursor = Cursor::default();
    let (mut slope, mut curvature) = (0.0_f64, 0.0_f64);
    for master in scanned(plate) {
        let motion = plate.at(master);
        assert_eq!(plate.along(&mut cursor, master), motion, "at {master}");
        assert!(is_finite(&motion), "{motion:?} at {master}");
        slope = slope.max(motion.velocity.abs());
        curvature = curvature.max(motion.acceleration.abs());
    }
    let within = |value: f64, most: f64| value <= most * (1.0 + ROUNDING);
    assert!(within(slope, most.slope), "{slope} {most:?}");
    assert!(within(curvature, most.curvature()), "{curvature} {most:?}");
    // They are attained, or a look ahead would refuse what the slave can follow.
    let at_peaks = plate.peaks(|_| true).map(|master| plate.at(master));
    let steepest = at_peaks
        .map(|motion| motion.velocity.abs())
        .fold(0.0, f64::max);
    assert!(within(most.slope, steepest), "{steepest} {most:?}");
}

/// Writes points into the plate: it is then as if made of them, or unchanged.
fn change(plate: &mut Plate, points: &[MotionPoint]) {
    let before = plate.clone();
    let planned = plate.check_change(points);
    let done = plate.change(points);
    assert_eq!(planned, done, "a check differs from the change");
    let Some(function) = plate.function() else {
        assert!(done.is_err(), "points were written into a table");
        return;
    };
    if done.is_err() {
        let kept = before.function().map(MotionFunction::points);
        assert_eq!(Some(function.points()), kept, "a refused change");
        return;
    }
    let made = MotionFunction::new(function.points().to_vec());
    let made = Plate::from_function(made.expect("points of a plate"), plate.course());
    assert_eq!(plate.greatest_demands(), made.greatest_demands());
    for master in scanned(&made) {
        assert_eq!(plate.at(master), made.at(master), "at {master}");
    }
    examine(plate);
}

/// Plans a coupling, scaled, to a steady master.
fn couple(plate: &Plate, bytes: &mut Bytes<'_>) -> Option<()> {
    let speed = plate.period() * bytes.decades(-2.0, 2.0)?;
    let kind = bytes.byte()?;
    let jump = if kind & 2 == 0 {
        JumpHandling::Refuse
    } else {
        JumpHandling::RampIn {
            master_length: plate.period() * bytes.decades(-2.0, 0.0)?,
        }
    };
    let cam_in = CamIn {
        master_scaling: 4.0 * bytes.share()?,
        slave_scaling: 4.0 * bytes.share()?,
        activation: Activation::new(ActivationMode::Instantaneous),
        jump,
        table: TABLE,
        ..CamIn::default()
    };
    let velocity = if kind & 1 == 1 { -speed } else { speed };
    let start = plate.master_range().0 + plate.period() * bytes.share()?;
    let master = Kinematics {
        position: start * cam_in.master_scaling,
        velocity,
        acceleration: 0.0,
    };
    let on = placed(plate, &cam_in, &master);
    let most = plate.greatest_demands();
    let (by_master, by_slave) = (
        (velocity / cam_in.master_scaling).abs(),
        cam_in.slave_scaling.abs(),
    );
    let needed = [
        most.slope * by_master * by_slave,
        most.curvature() * by_master * by_master * by_slave,
    ];
    // From a third of what the plate demands to three times that.
    let limits = CamLimits {
        velocity: needed[0] * bytes.decades(-0.5, 0.5)?,
        acceleration: needed[1] * bytes.decades(-0.5, 0.5)?,
        deceleration: needed[1] * bytes.decades(-0.5, 0.5)?,
        jerk: needed[1] * by_master * 1e6,
        cycle: 1e-3,
    };
    let parameters = CouplingParameters {
        master_axis_id: 1,
        slave_axis_id: 2,
        limits,
    };
    let mut coupling = CamCoupling::new(parameters).ok()?;
    let mut tables = Tables::new(1);
    tables.insert(TABLE, plate.clone()).expect("room for it");
    let started = coupling.start(&mut tables, &cam_in.into(), &master, &on);
    // A ramp has demands of its own, and what lies behind the master of a linear plate does not count.
    let is_alone = jump == JumpHandling::Refuse && is_resolved(plate);
    match started {
        Ok(_) if is_alone && plate.course() == Course::Cyclic => {
            let found = scan(plate, &cam_in, &master, &limits);
            assert!(found.is_none(), "accepted, {found:?} beyond {limits:?}");
        }
        Err(error @ CouplingError::BeyondLimits { .. }) if is_alone => {
            let is_beyond = needed[0] > limits.velocity * (1.0 - ROUNDING)
                || needed[1] > limits.acceleration.min(limits.deceleration) * (1.0 - ROUNDING);
            assert!(is_beyond, "refused, {needed:?} within {limits:?}: {error}");
        }
        _ => {}
    }
    for cycle in 1..=50 {
        let master = Kinematics {
            position: master.position + velocity * 1e-3 * f64::from(cycle),
            ..master
        };
        let set = coupling.update(&mut tables, &master);
        let numbers = [set.position, set.velocity, set.acceleration];
        assert!(numbers.into_iter().all(f64::is_finite), "{set:?}");
    }
    Some(())
}

/// True if the masters of the next cycles resolve each segment.
fn is_resolved(plate: &Plate) -> bool {
    let joints = joints(plate);
    let largest = joints
        .iter()
        .fold(0.0_f64, |most, joint| most.max(joint.abs()));
    joints
        .windows(2)
        .all(|ends| ends[1] - ends[0] >= LEAST * largest)
}

/// Slave of the placed plate at a master.
fn placed(plate: &Plate, cam_in: &CamIn, master: &Kinematics) -> Kinematics {
    let on_plate = Kinematics {
        position: master.position / cam_in.master_scaling,
        velocity: master.velocity / cam_in.master_scaling,
        acceleration: 0.0,
    };
    let Kinematics {
        position,
        velocity,
        acceleration,
    } = plate.slave_dynamics(&on_plate);
    Kinematics {
        position: position * cam_in.slave_scaling,
        velocity: velocity * cam_in.slave_scaling,
        acceleration: acceleration * cam_in.slave_scaling,
    }
}

/// First set values of a scan that are beyond the limits.
fn scan(
    plate: &Plate,
    cam_in: &CamIn,
    master: &Kinematics,
    limits: &CamLimits,
) -> Option<Kinematics> {
    let places = scanned(plate).into_iter().map(|place| {
        let master = Kinematics {
            position: place * cam_in.master_scaling,
            ..*master
        };
        placed(plate, cam_in, &master)
    });
    let mut beyond = places.filter(|set| {
        let brakes = set.velocity * set.acceleration < 0.0;
        let most = if brakes {
            limits.deceleration
        } else {
            limits.acceleration
        };
        // Where the slave reverses, rounding decides between both.
        let slow = set.velocity.abs() <= 1e-3 * limits.velocity;
        set.velocity.abs() > limits.velocity * (1.0 + 2.0 * ROUNDING)
            || !slow && set.acceleration.abs() > most * (1.0 + 2.0 * ROUNDING)
    });
    beyond.next()
}

fn is_finite(motion: &Motion) -> bool {
    let numbers = [motion.position, motion.velocity, motion.acceleration];
    numbers.into_iter().all(f64::is_finite)
}

/// A plate of each kind.
pub(crate) fn good_plates() -> Vec<(String, Vec<u8>)> {
    // Four points, a unit apart: rest, law, slave, distance to the next.
    let point = |law: u8, kind: u8, slave: u8| [law, kind, 0, slave, 204];
    let points = [
        point(8, 0, 0),
        point(8, 0, 63),
        point(8, 0, 31),
        point(8, 0, 0),
    ]
    .concat();
    let named = |name: &str, kind: u8, rest: &[u8]| {
        let head = [0, kind, 3, 85, 127, 0, 0];
        (name.to_owned(), [&head, points.as_slice(), rest].concat())
    };
    vec![
        named(
            "function",
            3,
            &[128, 0, 255, 31, 255, 31, 200, 0, 0, 200, 200, 200],
        ),
        named("table", 1, &[]),
        named("linear-table", 0, &[]),
    ]
}
