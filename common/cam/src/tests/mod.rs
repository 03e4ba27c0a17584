//! Tests of couplings, on a master that is led by hand.

mod activation;
mod couple;
mod errors;
mod multi;
mod online;
mod peaks;
mod properties;
mod scaling;
mod select;

use std::vec::Vec;

use super::*;
use coaxle_axis::{CommandState, Job};
use coaxle_curve::profile::Kinematics;
use coaxle_plate::{Course, MotionFunction, MotionPoint, Plate};

/// Makes a point at rest that a quintic leaves.
const fn rest(index: u32, master: f64, slave: f64) -> MotionPoint {
    MotionPoint::rest(index, master, slave)
}

/// Up to 50 at 180 and down again at 360, cyclic without lift.
const BACK_AND_FORTH: TableId = 1;
/// 100 per 360, at rest at the seams, cyclic.
const WITH_LIFT: TableId = 2;
/// From 0 to 40 over 0 to 100, linear, at rest at both ends.
const LINEAR: TableId = 3;
/// As `BACK_AND_FORTH`, with a quarter of the height and half the period.
const SMALL: TableId = 4;
/// Spare plate with lift, for a fifth plate.
const SPARE: TableId = 5;

fn plate(points: &[(f64, f64)], course: Course) -> Plate {
    let points: Vec<MotionPoint> = (1..)
        .zip(points)
        .map(|(index, &(master, slave))| rest(index, master, slave))
        .collect();
    let function = MotionFunction::new(points).expect("a motion function");
    Plate::from_function(function, course)
}

/// Jumps of up to 1e-3 u, and any velocity.
// j·T³/6 = 6e33·1e-36/6 = 1e-3 u. The velocity may change by min(j·T²/2, a·T) = 3e9 u/s.
const LIMITS: CamLimits = CamLimits {
    velocity: 1e12,
    acceleration: 1e24,
    deceleration: 1e24,
    jerk: 6e33,
    cycle: 1e-12,
};

/// A slave, its coupling and its master.
struct Rig {
    tables: Tables,
    coupling: CamCoupling,
    master: Kinematics,
    slave: Kinematics,
}

impl Rig {
    fn new() -> Self {
        // Five plates, and room for those that a test adds.
        let mut tables = Tables::new(8);
        let plates = [
            (
                BACK_AND_FORTH,
                plate(&[(0.0, 0.0), (180.0, 50.0), (360.0, 0.0)], Course::Cyclic),
            ),
            (
                WITH_LIFT,
                plate(&[(0.0, 0.0), (360.0, 100.0)], Course::Cyclic),
            ),
            (LINEAR, plate(&[(0.0, 0.0), (100.0, 40.0)], Course::Linear)),
            (
                SMALL,
                plate(&[(0.0, 0.0), (90.0, 12.5), (180.0, 0.0)], Course::Cyclic),
            ),
            (SPARE, plate(&[(0.0, 0.0), (200.0, 10.0)], Course::Cyclic)),
        ];
        for (id, plate) in plates {
            tables.insert(id, plate).expect("room");
        }
        let coupling = CamCoupling::new(CouplingParameters {
            master_axis_id: 7,
            slave_axis_id: 8,
            limits: LIMITS,
        })
        .expect("parameters");
        Self {
            tables,
            coupling,
            master: Kinematics::at_rest(0.0),
            slave: Kinematics::at_rest(0.0),
        }
    }

    fn coupled(table: TableId) -> Self {
        let mut rig = Self::new();
        rig.start(CamRequest::from(CamIn {
            table,
            ..CamIn::default()
        }))
        .expect("a coupling");
        rig.go(0.0);
        rig
    }

    fn multi(table: TableId) -> Self {
        let mut rig = Self::new();
        rig.start(CamRequest::from(CamInV2 {
            table,
            ..CamInV2::default()
        }))
        .expect("a coupling");
        rig.go(0.0);
        rig
    }

    fn start(&mut self, command: CamRequest) -> Result<Job, CouplingError> {
        self.coupling
            .start(&mut self.tables, &command, &self.master, &self.slave)
    }

    /// Runs one cycle with the master at a position.
    fn go(&mut self, position: f64) -> f64 {
        self.master = Kinematics {
            position,
            // Cycles of a millisecond. A call with the same position is a master at standstill.
            velocity: (position - self.master.position) / 0.001,
            acceleration: 0.0,
        };
        self.slave = self.coupling.update(&mut self.tables, &self.master);
        self.slave.position
    }

    /// Leads the master to a position in steps of at most `step`; returns the largest step of the slave
    /// on the way.
    fn lead(&mut self, to: f64, step: f64) -> f64 {
        let mut largest = 0.0_f64;
        while self.master.position != to {
            let way = to - self.master.position;
            let next = if way.abs() <= step {
                to
            } else {
                self.master.position + step * way.signum()
            };
            let before = self.slave.position;
            largest = largest.max((self.go(next) - before).abs());
        }
        largest
    }

    fn state(&self, job: Job) -> CouplingState {
        self.coupling.state_of(job)
    }

    fn raw(&self, table: TableId, master: f64) -> f64 {
        self.tables
            .plate(table)
            .expect("a plate")
            .at(master)
            .position
    }
}

fn activation(mode: ActivationMode, position: f64) -> Activation {
    Activation::at(mode, position)
}

fn cam_in(table: TableId) -> CamIn {
    CamIn {
        table,
        ..CamIn::default()
    }
}

fn assert_near(value: f64, expected: f64) {
    // Relative above 1 u, absolute below, where expected values may be 0.
    let tolerance = 1e-9 * expected.abs().max(1.0);
    assert!(
        (value - expected).abs() <= tolerance,
        "{value}, expected {expected}"
    );
}
