//! Plates that are loaded, replaced and deleted while the axis runs, judged by the differences of
//! its set positions.

use std::boxed::Box;
use std::sync::Arc;

use super::cams::{next_cycle, plate};
use super::saws::to_velocity;
use super::*;
use crate::CouplingPhase;
use coaxle_axis::{AxisStatus, StateWord};
use coaxle_cam::{CamIn, MOST_TABLES, OnlineChangeMode, PlateReading, PreparedTable, Tables};
use coaxle_saw::SyncMode;

pub(super) const ROOM: usize = 1_000;

pub(super) fn prepared(top: f64) -> Option<Box<PreparedTable>> {
    let source = Arc::new(plate(top).source());
    Some(Box::new(PreparedTable::new(source).expect("a plate")))
}

/// An axis without plates, but with room for them, and a master at 200 u/s.
fn rig() -> (AxisWithPlates, Master, Differences) {
    let mut axis = powered(&PARAMETERS);
    axis.select_cams(Tables::new(MOST_TABLES), 7, 8)
        .expect("limits");
    let mut master = Master::at(-20.0, 200.0);
    master.lead(&mut axis, 1);
    let differences = Differences::of(&axis);
    (axis, master, differences)
}

fn lead(rig: &mut (AxisWithPlates, Master, Differences), cycles: u32) {
    let (axis, master, differences) = rig;
    for _ in 0..cycles {
        master.lead(axis, 1);
        differences.keep(axis, &PARAMETERS);
    }
}

fn couple(axis: &mut AxisWithPlates) {
    let cam_in = CamIn {
        table: 1,
        activation: next_cycle(),
        ..CamIn::default()
    };
    start(axis, &Command::CamIn(cam_in));
}

#[test]
fn a_plate_is_loaded_coupled_replaced_while_the_slave_is_on_it_and_deleted() {
    let mut rig = rig();
    let cam_in = Command::CamIn(CamIn {
        table: 1,
        ..CamIn::default()
    });
    let refused = rig.0.plan(&cam_in).unwrap_err();
    assert_eq!(refused.code(), 0x4216, "there is none yet");

    let mut table = prepared(40.0);
    rig.0.select_cam(1, false, &mut table, ROOM).unwrap();
    assert!(table.is_none());
    couple(&mut rig.0);
    assert!(rig.0.cam_queued().contains(StateWord::CAM_TABLE_QUEUED));
    lead(&mut rig, 600);
    assert_eq!(rig.0.coupling_phase(), Some(CouplingPhase::InSync));
    assert!((rig.0.set().position - 40.0).abs() < 0.1);
    let state = rig.0.cam_state().expect("a plate");
    assert_eq!(state.table, 1);
    assert!((state.master_cam_position - 100.0).abs() < 1.0, "{state:?}");
    assert!((state.slave_cam_position - 40.0).abs() < 0.1, "{state:?}");

    let mode = OnlineChangeMode {
        activation: next_cycle(),
        ..OnlineChangeMode::default()
    };
    start(
        &mut rig.0,
        &Command::SetCamOnlineChangeMode { table: 1, mode },
    );
    assert_eq!(rig.0.delete_cam(1, &mut table).unwrap_err().code(), 0x4259);
    let mut table = prepared(30.0);
    let planned = rig.0.plan_select_cam(1, false, table.as_deref(), ROOM);
    assert_eq!(planned.unwrap_err().code(), 0x4063);
    rig.0
        .plan_select_cam(1, true, table.as_deref(), ROOM)
        .unwrap();
    rig.0.select_cam(1, true, &mut table, ROOM).unwrap();
    assert!(rig.0.cam_queued().contains(StateWord::CAM_DATA_QUEUED));
    lead(&mut rig, 1_000);
    assert!(
        (rig.0.set().position - 30.0).abs() < 0.1,
        "{:?}",
        rig.0.set()
    );
    assert_eq!(rig.0.cam_queued(), StateWord::empty());

    start(&mut rig.0, &Command::CamOut {});
    lead(&mut rig, 20);
    rig.0.delete_cam(1, &mut table).unwrap();
    start(&mut rig.0, &HALT);
    lead(&mut rig, 300);
    assert_eq!(rig.0.status(), AxisStatus::Standstill);
    assert_eq!(rig.0.cam_state(), None);
}

#[test]
fn what_waits_for_a_plate_holds_it() {
    let mut rig = rig();
    rig.0
        .select_cam(1, false, &mut prepared(40.0), ROOM)
        .unwrap();
    couple(&mut rig.0);
    let mut table = None;
    assert_eq!(rig.0.delete_cam(1, &mut table).unwrap_err().code(), 0x4259);
    // The plate is not in use yet, so it is replaced at once.
    rig.0
        .select_cam(1, true, &mut prepared(30.0), ROOM)
        .unwrap();
    lead(&mut rig, 600);
    assert!(
        (rig.0.set().position - 30.0).abs() < 0.1,
        "{:?}",
        rig.0.set()
    );
}

/// Interrupted while a replacement is pending: it takes effect at once, since the plate is not in use.
#[test]
fn a_replacement_that_waits_is_in_force_once_the_slave_has_left() {
    let mut rig = rig();
    rig.0
        .select_cam(1, false, &mut prepared(40.0), ROOM)
        .unwrap();
    couple(&mut rig.0);
    lead(&mut rig, 300);
    let mode = OnlineChangeMode {
        activation: next_cycle(),
        ..OnlineChangeMode::default()
    };
    start(
        &mut rig.0,
        &Command::SetCamOnlineChangeMode { table: 1, mode },
    );
    rig.0
        .select_cam(1, true, &mut prepared(30.0), ROOM)
        .unwrap();
    let mut reading = PlateReading::default();
    let top = |rig: &(AxisWithPlates, Master, Differences), reading: &mut PlateReading| {
        rig.0.read_plate(1, reading).unwrap();
        let plate = reading.source().unwrap().plate().unwrap();
        plate.at(100.0).position
    };
    assert_eq!(top(&rig, &mut reading), 40.0);
    start(&mut rig.0, &HALT);
    lead(&mut rig, 300);
    assert_eq!(rig.0.status(), AxisStatus::Standstill);
    assert_eq!(top(&rig, &mut reading), 30.0);
}

/// A flying saw keeps its profile under the id 256 - axis id, which a plate may take from it and release.
#[test]
fn a_plate_can_take_the_table_of_a_flying_saw() {
    let (mut axis, ..) = rig();
    let saw = to_velocity(SyncMode::default());
    let code = |axis: &AxisWithPlates| axis.plan(&saw).err().map(|refusal| refusal.code());
    assert_ne!(code(&axis), Some(0x4063));
    axis.select_cam(248, false, &mut prepared(1.0), ROOM)
        .unwrap();
    assert_eq!(code(&axis), Some(0x4063));
    axis.delete_cam(248, &mut None).unwrap();
    assert_ne!(code(&axis), Some(0x4063));
}

#[test]
fn an_axis_that_never_had_a_store_says_that_it_is_full() {
    let mut axis = powered(&PARAMETERS);
    let refused = axis.select_cam(1, false, &mut prepared(1.0), ROOM);
    assert_eq!(refused.unwrap_err().code(), 0x4A11);
    let refused = axis.read_plate(1, &mut PlateReading::default());
    assert_eq!(refused.unwrap_err().code(), 0x4216);
}
