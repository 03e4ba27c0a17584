//! Couplings, the slave axis and its guard.

use std::hint::black_box;

use coaxle_axis::Dynamics;
use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
use coaxle_axis::set_value_guard::SetValueGuard;
use coaxle_cam::{
    CamCoupling, CamInV2, CamLimits, CamRequest, CouplingParameters, JumpHandling, Tables,
};
use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::law::MotionLaw;
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_gear::{FlyingGear, FlyingGearParameters, GearIn};
use coaxle_plate::{Course, MotionFunction, MotionPoint, Plate, PointType};
use coaxle_slave::{Command, SlaveAxis, SlaveParameters};

const CYCLE: Seconds = Seconds(0.001);

/// A master at 500 u/s.
fn master(cycle: u32) -> Kinematics {
    Kinematics {
        position: 0.5 * f64::from(cycle),
        velocity: 500.0,
        acceleration: 0.0,
    }
}

pub(super) fn guard(calls: u32) {
    let limits = Limits::new(1_000.0, 10_000.0, 10_000.0, 200_000.0).expect("above zero");
    let mut guard =
        SetValueGuard::new(&limits, -1e9, 1e9, CYCLE, &master(0)).expect("a cycle time");
    for cycle in 1..=calls {
        // Input and output are hidden from the optimiser, which would calculate a constant master once.
        let _ = black_box(guard.update(black_box(&master(cycle)), 1));
    }
}

/// Sixty-four rests, up and down and with a lift over all.
fn plate() -> Plate {
    let point = |row: u32| MotionPoint {
        index: row + 1,
        function: MotionLaw::Polynom5,
        point_type: PointType::Rest,
        relative_next: 1,
        // Uneven distances: a search that assumes equal ones would be flattered.
        master: f64::from(row) * 10.0 + f64::from(row % 3),
        slave: f64::from(row) + f64::from(row % 2) * 25.0,
        velocity: 0.0,
        acceleration: 0.0,
        jerk: 0.0,
    };
    let function = MotionFunction::new((0..64).map(point).collect());
    Plate::from_function(function.expect("the points are right"), Course::Cyclic)
}

/// A slave coupled by this number of plates.
fn coupled(plates: u32) -> (Tables, CamCoupling) {
    let mut tables = Tables::new(4);
    let parameters = CouplingParameters {
        master_axis_id: 1,
        slave_axis_id: 2,
        limits: CamLimits {
            velocity: 1e3,
            acceleration: 1e4,
            deceleration: 1e4,
            jerk: 1e6,
            cycle: CYCLE.0,
        },
    };
    let mut coupling = CamCoupling::new(parameters).expect("the parameters are right");
    for table in 1..=plates {
        tables.insert(table, plate()).expect("there is room");
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

fn cams(plates: u32, masters: impl Iterator<Item = f64>) {
    let (mut tables, mut coupling) = coupled(plates);
    for position in masters {
        let master = Kinematics {
            position,
            velocity: 100.0,
            acceleration: 10.0,
        };
        let _ = black_box(coupling.update(&mut tables, black_box(&master)));
    }
}

pub(super) fn cam(calls: u32) {
    cams(1, (0..calls).map(|cycle| 0.1 * f64::from(cycle)));
}

pub(super) fn four_cams(calls: u32) {
    // An odd factor reaches every place once.
    let place = |n: u32| f64::from(n.wrapping_mul(2_654_435_761) >> 20) * (640.0 / 4_096.0);
    cams(4, (0..calls).map(place));
}

fn axis() -> SlaveAxis {
    let parameters = SlaveParameters::new(1_000.0, 5_000.0, 100_000.0);
    let drive = SimulatedDrive::new(DriveParameters::default()).expect("in range");
    let cycle = CycleTime::new(Span::from_millis(1)).expect("in range");
    let mut axis = SlaveAxis::new(&parameters, Box::new(drive), cycle).expect("in range");
    axis.command(&mut Tables::new(0), &Command::Power(true))
        .expect("is off");
    axis.update(&mut Tables::new(0), Some(&master(0)), CYCLE);
    axis
}

/// From rest over engaging, engaged and releasing to rest, once in a thousand cycles.
pub(super) fn flying_gear(calls: u32) {
    let parameters = FlyingGearParameters {
        ratio: 1.0,
        master_sync_position: 200.0,
        slave_sync_position: 50.0,
        slave_desync_position: 150.0,
        slave_stop_position: 200.0,
        default_slave_negative: false,
    };
    let begin = FlyingGear::enable(&parameters, &master(0), 0.0).expect("a gear");
    let mut gear = begin;
    for cycle in 0..calls {
        // A gear that has released stays idle, which would cost next to nothing.
        if cycle % 1_000 == 0 {
            gear = begin;
        }
        let _ = black_box(gear.update(black_box(&master(cycle % 1_000))));
    }
}

pub(super) fn slave(calls: u32) {
    let mut axis = axis();
    let gear = Command::GearIn(GearIn {
        ratio: 1.0,
        dynamics: Dynamics::default(),
    });
    axis.command(&mut Tables::new(0), &gear).expect("couples");
    // In both runs of the measurement, so that settling cancels out.
    for cycle in 1..=SETTLED + calls {
        let _ = black_box(axis.update(&mut Tables::new(0), Some(black_box(&master(cycle))), CYCLE));
    }
}

/// Cycles after which a slave that was at rest is coupled.
const SETTLED: u32 = 1_000;

/// A thousand cycles there, a thousand back.
pub(super) fn slave_life(calls: u32) {
    let mut axis = axis();
    for cycle in 0..calls {
        if cycle % 1_000 == 0 {
            let there = Command::MoveAbsolute {
                position: if cycle % 2_000 == 0 { 100.0 } else { 0.0 },
                velocity: None,
                dynamics: Dynamics::default(),
            };
            axis.command(&mut Tables::new(0), &there)
                .expect("is accepted");
        }
        let _ = black_box(axis.update(&mut Tables::new(0), Some(black_box(&master(cycle))), CYCLE));
    }
}
