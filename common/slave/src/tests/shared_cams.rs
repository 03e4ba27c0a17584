//! Two axes of a node on one plate, judged by the differences of their set positions.

use super::cam_select::{ROOM, prepared};
use super::cams::{next_cycle, plate};
use super::saws::to_velocity;
use super::*;
use crate::{CamPoints, CouplingPhase};
use coaxle_axis::{AxisStatus, CommandState, StateWord};
use coaxle_cam::{
    AxisScaling, CamIn, CamScaling, CouplingError, MOST_TABLES, OnlineChangeMode, ScalingData,
    ScalingMode, Tables,
};
use coaxle_plate::MotionPoint;
use coaxle_saw::SyncMode;

/// Axes with one store of plates, which has one plate with the number 1 and its top at 40 u; and a
/// master at 200 u/s.
struct Node {
    axes: [(AxisWithPlates, Differences); 2],
    plates: Tables,
    master: Master,
    /// True for each axis that has lost its master.
    lost: [bool; 2],
}

impl Node {
    fn new() -> Self {
        let axis = |id| {
            let mut axis = powered(&PARAMETERS);
            axis.prepare_cams(7, id).expect("limits");
            let differences = Differences::of(&axis);
            (axis, differences)
        };
        let mut tables = Tables::new(MOST_TABLES);
        tables.insert(1, plate(40.0)).expect("room");
        let mut node = Self {
            axes: [axis(8), axis(9)],
            plates: tables,
            master: Master::at(-20.0, 200.0),
            lost: [false; 2],
        };
        node.run(1);
        node
    }

    /// Runs `act` on an axis with the plates of the node.
    fn with<T>(&mut self, n: usize, act: impl FnOnce(&mut AxisWithPlates) -> T) -> T {
        let (axis, _) = &mut self.axes[n];
        core::mem::swap(&mut self.plates, &mut axis.plates);
        let done = act(axis);
        core::mem::swap(&mut self.plates, &mut axis.plates);
        done
    }

    fn run(&mut self, cycles: u32) {
        for _ in 0..cycles {
            self.master.0.position += self.master.0.velocity * CYCLE.0;
            for n in 0..self.axes.len() {
                let master = (!self.lost[n]).then_some(self.master.0);
                self.with(n, |axis| axis.update(master.as_ref(), CYCLE));
                let (axis, differences) = &mut self.axes[n];
                differences.keep(axis, &PARAMETERS);
            }
        }
    }

    /// Runs until the master has reached the position.
    fn run_to(&mut self, position: f64) {
        while self.master.0.position < position - 1e-9 {
            self.run(1);
        }
    }

    /// Couples an axis to the plate, which begins for it with the master at `start_at`, and every
    /// 200 u from there.
    fn couple(&mut self, n: usize, start_at: f64) {
        let cam_in = CamIn {
            table: 1,
            master_offset: -start_at,
            activation: next_cycle(),
            ..CamIn::default()
        };
        self.with(n, |axis| start(axis, &Command::CamIn(cam_in)));
    }

    /// Sets changes of the plate to take effect from each axis's next cycle.
    fn change_at_next_cycle(&mut self) {
        let mode = OnlineChangeMode {
            activation: next_cycle(),
            ..OnlineChangeMode::default()
        };
        let command = Command::SetCamOnlineChangeMode { table: 1, mode };
        self.with(0, |axis| start(axis, &command));
    }

    /// Replaces the plate.
    fn replace(&mut self, n: usize, top: f64) -> Result<(), u32> {
        let code = |error: CouplingError| error.code();
        self.with(n, |axis| {
            axis.select_cam(1, true, &mut prepared(top), ROOM)
                .map_err(code)
        })
    }

    fn delete(&mut self, n: usize) -> Result<(), u32> {
        let code = |error: CouplingError| error.code();
        self.with(n, |axis| axis.delete_cam(1, &mut None).map_err(code))
    }

    fn positions(&self) -> [f64; 2] {
        [0, 1].map(|n| self.axes[n].0.set().position)
    }

    fn queued(&mut self, n: usize) -> StateWord {
        self.with(n, |axis| axis.cam_queued())
    }
}

fn near(received: [f64; 2], expected: [f64; 2]) {
    for (received_one, expected_one) in received.into_iter().zip(expected) {
        assert!(
            (received_one - expected_one).abs() < 0.1,
            "received {received:?}, expected {expected:?}"
        );
    }
}

/// Two axes on the plate, the second 80 u of the master behind the first, and the master at 300.
fn coupled() -> Node {
    let mut node = Node::new();
    node.couple(0, 0.0);
    node.couple(1, 80.0);
    node.run_to(300.0);
    near(node.positions(), [40.0, at(40.0, 20.0)]);
    node
}

/// Position of an axis on a plate with this top.
fn at(top: f64, master: f64) -> f64 {
    plate(top).at(master).position
}

#[test]
fn two_slaves_are_on_one_plate_each_at_its_own_place_and_scaled_on_its_own() {
    let mut node = coupled();
    node.run_to(380.0);
    near(node.positions(), [at(40.0, 180.0), 40.0]);
    let scaling = Command::CamScaling(CamScaling {
        activation: next_cycle(),
        scaling: ScalingData {
            master: AxisScaling {
                mode: ScalingMode::Off,
                ..AxisScaling::default()
            },
            slave: AxisScaling {
                scaling: 0.5,
                ..AxisScaling::default()
            },
        },
        ..CamScaling::default()
    });
    node.with(1, |axis| start(axis, &scaling));
    node.run_to(780.0);
    near(node.positions(), [at(40.0, 180.0), 20.0]);
}

#[test]
fn a_plate_that_is_replaced_changes_for_each_slave_at_its_own_seam() {
    let mut node = coupled();
    node.change_at_next_cycle();
    node.replace(0, 30.0).unwrap();
    for n in [0, 1] {
        assert!(node.queued(n).contains(StateWord::CAM_DATA_QUEUED));
    }
    // The first has passed its seam, at 400, and the second not yet, at 480.
    node.run_to(450.0);
    near(node.positions(), [at(30.0, 50.0), at(40.0, 170.0)]);
    assert_eq!(
        node.replace(1, 20.0),
        Err(0x4287),
        "the change is under way"
    );
    node.run_to(580.0);
    near(node.positions(), [at(30.0, 180.0), 30.0]);
    for n in [0, 1] {
        assert_eq!(node.queued(n), StateWord::empty());
    }
    node.replace(1, 20.0).unwrap();
    node.run_to(980.0);
    near(node.positions(), [at(20.0, 180.0), 20.0]);
}

#[test]
fn points_written_by_one_slave_are_those_of_the_other() {
    let mut node = coupled();
    node.change_at_next_cycle();
    let points = CamPoints::new(&[MotionPoint::rest(2, 100.0, 25.0)]).unwrap();
    let write = Command::WriteMotionFunction { table: 1, points };
    node.with(1, |axis| start(axis, &write));
    node.run_to(700.0);
    near(node.positions(), [25.0, at(25.0, 20.0)]);
}

#[test]
fn a_plate_is_deleted_once_the_last_slave_has_left_it() {
    let mut node = coupled();
    node.with(0, |axis| start(axis, &Command::CamOut {}));
    assert_eq!(node.delete(0), Err(0x4259), "the other is on it");
    node.with(1, |axis| start(axis, &Command::CamOut {}));
    node.delete(0).unwrap();
    for n in [0, 1] {
        node.with(n, |axis| start(axis, &HALT));
    }
    node.run(500);
    for n in [0, 1] {
        assert_eq!(node.axes[n].0.status(), AxisStatus::Standstill);
    }
    let cam_in = Command::CamIn(CamIn {
        table: 1,
        ..CamIn::default()
    });
    let refused = node.with(1, |axis| axis.plan(&cam_in).unwrap_err().code());
    assert_eq!(refused, 0x4216);
}

/// A slave in error stop keeps the plate, so that its values stay readable, and no change waits for it.
#[test]
fn a_slave_in_error_does_not_keep_the_others_from_changing_the_plate() {
    let mut node = coupled();
    node.change_at_next_cycle();
    node.replace(0, 30.0).unwrap();
    node.run_to(450.0);
    node.lost[1] = true;
    node.run_to(780.0);
    assert_eq!(node.axes[1].0.status(), AxisStatus::ErrorStop);
    assert_eq!(node.queued(0), StateWord::empty());
    near([node.positions()[0]; 2], [at(30.0, 180.0); 2]);

    node.replace(0, 20.0).unwrap();
    node.run_to(1_180.0);
    near([node.positions()[0]; 2], [at(20.0, 180.0); 2]);
    let info = node.with(1, |axis| axis.cam_info(0, None)).unwrap();
    assert_eq!(info.table, 1);
    node.with(0, |axis| start(axis, &Command::CamOut {}));
    assert_eq!(node.delete(0), Err(0x4259));
    node.with(1, |axis| start(axis, &Command::Reset {}));
    node.delete(0).unwrap();
}

/// A change taken by one axis takes effect once the other has left.
#[test]
fn a_slave_that_leaves_is_not_waited_for() {
    let mut node = coupled();
    node.change_at_next_cycle();
    node.replace(0, 30.0).unwrap();
    node.run_to(450.0);
    node.with(1, |axis| start(axis, &HALT));
    assert_eq!(node.queued(0), StateWord::empty());
    node.run_to(700.0);
    assert!((node.positions()[0] - 30.0).abs() < 0.1);
    // The other axis returns, onto the plate in effect.
    node.with(1, |axis| start(axis, &move_absolute(0.0)));
    node.run_to(1_000.0);
    node.couple(1, 80.0);
    node.run_to(1_380.0);
    near(node.positions(), [at(30.0, 180.0), 30.0]);
}

#[test]
fn a_plate_that_one_slave_loads_takes_the_table_of_the_others_flying_saw() {
    let mut node = Node::new();
    let saw = to_velocity(SyncMode::default());
    let code = |node: &mut Node| {
        node.with(1, |axis| {
            axis.plan(&saw).err().map(|refusal| refusal.code())
        })
    };
    assert_ne!(code(&mut node), Some(0x4063));
    let table = &mut prepared(1.0);
    node.with(0, |axis| axis.select_cam(256 - 9, false, table, ROOM))
        .unwrap();
    assert_eq!(code(&mut node), Some(0x4063));
    node.with(0, |axis| axis.delete_cam(256 - 9, &mut None))
        .unwrap();
    assert_ne!(code(&mut node), Some(0x4063));
}

#[test]
#[should_panic(expected = "before anything else happens")]
fn what_was_planned_before_others_had_the_plates_is_not_applied() {
    let mut node = coupled();
    let change = node.with(0, |axis| axis.plan(&Command::CamOut {}).unwrap());
    node.with(1, |axis| start(axis, &Command::CamOut {}));
    node.with(0, |axis| axis.apply(change, coaxle_axis::Origin::Program));
}

/// A node that passes other plates to it: the axis fails, within its limits.
#[test]
fn an_axis_that_is_not_lent_the_plates_it_is_on_stops() {
    let mut node = coupled();
    let (axis, differences) = &mut node.axes[0];
    for _ in 0..600 {
        node.master.lead(axis, 1);
        differences.keep(axis, &PARAMETERS);
    }
    assert_eq!(axis.status(), AxisStatus::ErrorStop);
    assert_eq!(axis.coupling_phase(), None::<CouplingPhase>);
    assert!(matches!(axis.job().1, CommandState::Failed(_)));
}
