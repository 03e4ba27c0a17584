//! The PLC interface: levels, edges and booleans.

use std::vec::Vec;

use coaxle_axis::CommandState;
use coaxle_cam::{
    Activation, ActivationMode, CamCoupling, CamIn, CamLimits, CamOut, CamRequest, CamScaling,
    CouplingParameters, JumpHandling, TableId, Tables,
};
use coaxle_curve::profile::Kinematics;
use coaxle_plate::{Course, MotionFunction, MotionPoint, Plate};

use crate::{CouplingBlock, Outputs, TableBlock};

/// Up to 50 at 180 and down again at 360, cyclic without lift.
const BACK_AND_FORTH: TableId = 1;
/// 100 per 360, at rest at the seams, cyclic.
const WITH_LIFT: TableId = 2;

fn plate(points: &[(f64, f64)], course: Course) -> Plate {
    let points: Vec<MotionPoint> = (1..)
        .zip(points)
        .map(|(index, &(master, slave))| MotionPoint::rest(index, master, slave))
        .collect();
    let function = MotionFunction::new(points).expect("a motion function");
    Plate::from_function(function, course)
}

/// A slave, its coupling and its master.
struct Rig {
    tables: Tables,
    coupling: CamCoupling,
    master: Kinematics,
    slave: Kinematics,
}

impl Rig {
    fn new() -> Self {
        let mut tables = Tables::new(8);
        let back_and_forth = [(0.0, 0.0), (180.0, 50.0), (360.0, 0.0)];
        let with_lift = [(0.0, 0.0), (360.0, 100.0)];
        for (id, points) in [
            (BACK_AND_FORTH, &back_and_forth[..]),
            (WITH_LIFT, &with_lift),
        ] {
            tables
                .insert(id, plate(points, Course::Cyclic))
                .expect("room");
        }
        let coupling = CamCoupling::new(CouplingParameters {
            master_axis_id: 7,
            slave_axis_id: 8,
            limits: CamLimits {
                // So wide that no limit takes part: the outputs of the blocks are the subject.
                velocity: 1e9,
                acceleration: 1e12,
                deceleration: 1e12,
                jerk: 6e15,
                cycle: 1e-6,
            },
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
        let command = CamRequest::from(cam_in(table));
        rig.coupling
            .start(&mut rig.tables, &command, &rig.master, &rig.slave)
            .expect("a coupling");
        rig.go(0.0);
        rig
    }

    /// Runs one cycle with the master at a position.
    fn go(&mut self, position: f64) {
        self.master = Kinematics {
            position,
            velocity: (position - self.master.position) / 0.001,
            acceleration: 0.0,
        };
        self.slave = self.coupling.update(&mut self.tables, &self.master);
    }
}

fn cam_in(table: TableId) -> CamIn {
    CamIn {
        table,
        ..CamIn::default()
    }
}

fn scan(block: &mut CouplingBlock, rig: &mut Rig, execute: bool, command: CamRequest) -> Outputs {
    let outputs = block.scan(
        execute,
        &command,
        &mut rig.tables,
        &mut rig.coupling,
        [&rig.master, &rig.slave],
    );
    // A degree per scan, so that a test can count the scans to a master position.
    let next = rig.master.position + 1.0;
    rig.go(next);
    outputs
}

#[test]
fn cam_in_waits_becomes_in_sync_and_is_aborted() {
    let mut rig = Rig::new();
    rig.master.position = -2.5;
    let mut cam_in_block = CouplingBlock::default();
    let command = CamRequest::from(CamIn {
        activation: Activation::new(ActivationMode::NextCycle),
        jump: JumpHandling::Allow,
        ..cam_in(BACK_AND_FORTH)
    });
    let off = Outputs::default();
    let busy = Outputs { busy: true, ..off };
    let in_sync = Outputs {
        active: true,
        in_sync: true,
        ..busy
    };
    let outputs: Vec<Outputs> = [false, true, true, true, true, true, true]
        .into_iter()
        .map(|execute| scan(&mut cam_in_block, &mut rig, execute, command))
        .collect();
    // From -2.5 in steps of 1, the seam is passed after the fourth scan.
    assert_eq!(
        outputs,
        [off, busy, busy, in_sync, in_sync, in_sync, in_sync]
    );

    let mut cam_out = CouplingBlock::default();
    let done = scan(&mut cam_out, &mut rig, true, CamOut {}.into());
    assert_eq!(done, Outputs { done: true, ..off });
    let aborted = Outputs {
        command_aborted: true,
        ..off
    };
    assert_eq!(scan(&mut cam_in_block, &mut rig, true, command), aborted);
    assert_eq!(scan(&mut cam_in_block, &mut rig, false, command), off);
}

#[test]
fn a_scaling_shows_done_after_a_pulse_of_one_scan() {
    let mut rig = Rig::coupled(BACK_AND_FORTH);
    let mut block = CouplingBlock::default();
    let command = CamRequest::from(CamScaling {
        activation: Activation::at(ActivationMode::AtMasterAxisPos, 2.5),
        jump: JumpHandling::Allow,
        ..CamScaling::default()
    });
    let off = Outputs::default();
    let active = Outputs {
        busy: true,
        active: true,
        ..off
    };
    let done = Outputs { done: true, ..off };
    let outputs = [true, false, false, false, false]
        .map(|execute| scan(&mut block, &mut rig, execute, command));
    // Master positions 0 to 4: 2.5 is passed between the third and the fourth scan.
    assert_eq!(outputs, [active, active, active, done, off]);
}

#[test]
fn a_refusal_shows_its_number_while_execute_is_held() {
    let mut rig = Rig::new();
    let mut block = CouplingBlock::default();
    let refused = Outputs {
        error: true,
        error_id: 0x4216,
        ..Outputs::default()
    };
    for execute in [true, true] {
        let outputs = scan(&mut block, &mut rig, execute, CamRequest::from(cam_in(77)));
        assert_eq!(outputs, refused);
    }
    assert!(matches!(block.state(), CommandState::Failed(_)));
    let outputs = scan(&mut block, &mut rig, false, CamRequest::from(cam_in(77)));
    assert_eq!(outputs, Outputs::default());
}

#[test]
fn a_jump_shows_as_an_error_of_the_block() {
    let mut rig = Rig::new();
    // The plate begins at 0, and no jump is permitted by default.
    rig.slave.position = 5.0;
    let mut block = CouplingBlock::default();
    let command = CamRequest::from(cam_in(BACK_AND_FORTH));
    let outputs = scan(&mut block, &mut rig, true, command);
    assert_eq!((outputs.error, outputs.error_id), (true, 0x421A));
}

#[test]
fn the_other_blocks_are_done_at_once_and_have_a_value() {
    let mut rig = Rig::coupled(WITH_LIFT);
    let mut info = TableBlock::default();
    let outputs = info.scan(true, &mut rig, |rig| {
        rig.coupling.info(&rig.tables, 0, Some(360.0))
    });
    assert!(outputs.done && !outputs.busy);
    // Once up over the whole turn, 100.
    let strokes = info.value().unwrap().sum_of_slave_strokes;
    assert!((strokes - 100.0).abs() <= 1e-7, "{strokes}");

    let mut select = TableBlock::default();
    let plate = plate(&[(0.0, 0.0), (1.0, 1.0)], Course::Linear);
    let outputs = select.scan(true, &mut rig.tables, |tables| tables.insert(9, plate));
    assert!(outputs.done);
    assert!(rig.tables.plate(9).is_ok());
}
