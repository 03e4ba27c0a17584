//! TF5050 chapter 4.1: plates that are inserted and removed while the axis runs, and their readers.

use alloc::boxed::Box;
use alloc::sync::Arc;

use super::*;
use coaxle_plate::{Interpolation, PlateSource, SourceRows};

const ROOM: usize = 1_000;

fn prepared(plate: &Plate) -> Option<Box<PreparedTable>> {
    let source = Arc::new(plate.source());
    Some(Box::new(PreparedTable::new(source).expect("a plate")))
}

fn three(top: f64) -> Plate {
    plate(&[(0.0, 0.0), (180.0, top), (360.0, 0.0)], Course::Cyclic)
}

fn code(result: Result<(), CouplingError>) -> u32 {
    result.unwrap_err().code()
}

#[test]
fn a_table_comes_in_and_goes_out_again() {
    let mut tables = Tables::new(1);
    let mut table = prepared(&three(50.0));
    tables
        .plan_select(3, false, table.as_deref(), ROOM)
        .unwrap();
    tables.select(3, false, &mut table, ROOM).unwrap();
    assert!(table.is_none(), "nothing was replaced");
    assert_eq!(
        (tables.plate(3).unwrap().at(180.0).position, tables.rows()),
        (50.0, 3)
    );

    // There is one, and there is no room for another.
    let mut other = prepared(&three(20.0));
    assert_eq!(code(tables.select(3, false, &mut other, ROOM)), 0x4063);
    assert_eq!(code(tables.select(4, false, &mut other, ROOM)), 0x4A11);
    assert_eq!(code(tables.select(0, false, &mut other, ROOM)), 0x4B32);
    assert_eq!(code(tables.select(256, true, &mut None, ROOM)), 0x4B32);
    assert_eq!(code(tables.select(3, true, &mut None, ROOM)), 0x4B30);
    assert_eq!(tables.plate(3).unwrap().at(180.0).position, 50.0);

    tables.select(3, true, &mut other, ROOM).unwrap();
    assert_eq!(tables.plate(3).unwrap().at(180.0).position, 20.0);
    assert!(other.is_some(), "the one before");

    tables.plan_delete(3).unwrap();
    tables.delete(3, &mut other).unwrap();
    assert_eq!(code(tables.delete(3, &mut other)), 0x4216);
    assert_eq!(tables.rows(), 0);
}

#[test]
fn more_rows_than_there_is_room_for_are_refused() {
    let mut tables = Tables::new(2);
    tables
        .select(1, false, &mut prepared(&three(1.0)), 3)
        .unwrap();
    let refused = tables.select(2, false, &mut prepared(&three(1.0)), 2);
    assert_eq!(code(refused), 0x4A11);
    // The memory of the replaced plate counts as free.
    tables
        .select(1, true, &mut prepared(&three(2.0)), 0)
        .unwrap();
    let four = plate(
        &[(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (3.0, 3.0)],
        Course::Linear,
    );
    assert_eq!(
        code(tables.select(1, true, &mut prepared(&four), 0)),
        0x4A11
    );
    tables.select(1, true, &mut prepared(&four), 1).unwrap();
}

#[test]
fn a_plate_in_use_is_neither_deleted_nor_put_away() {
    let mut rig = Rig::coupled(BACK_AND_FORTH);
    let mut taken = None;
    assert_eq!(code(rig.tables.delete(BACK_AND_FORTH, &mut taken)), 0x4259);
    // Another number of points, another course, or no points at all: no online change.
    let rows = [(0.0, 0.0), (180.0, 50.0), (360.0, 0.0)];
    let table = PlateSource {
        course: Course::Cyclic,
        rows: SourceRows::Positions {
            rows: rows.to_vec(),
            interpolation: Interpolation::Linear,
            equidistant: false,
        },
    };
    for other in [
        plate(&[(0.0, 0.0), (360.0, 0.0)], Course::Cyclic),
        plate(&rows, Course::Linear),
        table.plate().unwrap(),
    ] {
        let mut other = prepared(&other);
        let refused = rig.tables.select(BACK_AND_FORTH, true, &mut other, ROOM);
        assert_eq!(code(refused), 0x4259);
        assert!(other.is_some(), "it goes back");
    }
    rig.lead(180.0, 1.0);
    assert_near(rig.slave.position, 50.0);

    let out = CamRequest::from(CamOut {});
    rig.start(out).unwrap();
    rig.tables.delete(BACK_AND_FORTH, &mut taken).unwrap();
}

#[test]
fn a_plate_in_use_is_replaced_as_an_online_change() {
    let mut rig = Rig::coupled(BACK_AND_FORTH);
    let at_seam = OnlineChangeMode {
        activation: Activation::new(ActivationMode::NextCycle),
        ..OnlineChangeMode::default()
    };
    rig.tables
        .set_online_change_mode(BACK_AND_FORTH, at_seam)
        .unwrap();
    rig.lead(100.0, 1.0);
    let mut other = prepared(&three(20.0));
    rig.tables
        .select(BACK_AND_FORTH, true, &mut other, ROOM)
        .unwrap();
    assert!(rig.tables.data_queued(BACK_AND_FORTH).unwrap());
    let most = rig.lead(180.0, 1.0);
    assert_near(rig.slave.position, 50.0);
    let most = most.max(rig.lead(360.0 + 180.0, 1.0));
    assert_near(rig.slave.position, 20.0);
    // 1.875·50/180 = 0.52 u in a step of 1.
    assert!(most < 0.6, "{most}");
    assert!(!rig.tables.data_queued(BACK_AND_FORTH).unwrap());
    // And points can be written on top of it.
    let written = [rest(2, 180.0, 30.0)];
    rig.tables.write(BACK_AND_FORTH, &written).unwrap();
    rig.lead(720.0 + 180.0, 1.0);
    assert_near(rig.slave.position, 30.0);
}

#[test]
fn a_change_that_is_off_or_half_done_stands_against_it() {
    let mut rig = Rig::coupled(BACK_AND_FORTH);
    let off = OnlineChangeMode {
        activation: Activation::new(ActivationMode::Off),
        ..OnlineChangeMode::default()
    };
    rig.tables
        .set_online_change_mode(BACK_AND_FORTH, off)
        .unwrap();
    let mut other = prepared(&three(20.0));
    let refused = rig.tables.select(BACK_AND_FORTH, true, &mut other, ROOM);
    assert_eq!(code(refused), 0x4283);
    let once = OnlineChangeMode {
        activation: Activation::new(ActivationMode::NextCycleOnce),
        ..OnlineChangeMode::default()
    };
    rig.tables
        .set_online_change_mode(BACK_AND_FORTH, once)
        .unwrap();
    rig.tables
        .write(BACK_AND_FORTH, &[rest(2, 180.0, 40.0)])
        .unwrap();
    rig.lead(370.0, 1.0);
    let refused = rig.tables.select(BACK_AND_FORTH, true, &mut other, ROOM);
    assert_eq!(code(refused), 0x4287, "it is in force for this cycle");
}

#[test]
fn a_plate_is_read_as_it_is_in_force() {
    let mut rig = Rig::coupled(BACK_AND_FORTH);
    let mut reading = PlateReading::default();
    assert!(reading.source().is_none());
    let at_top = |rig: &Rig, reading: &mut PlateReading| {
        rig.tables.read_plate(BACK_AND_FORTH, reading).unwrap();
        let plate = reading.source().unwrap().plate().unwrap();
        plate.at(180.0).position
    };
    assert_eq!(at_top(&rig, &mut reading), 50.0);
    let at_seam = OnlineChangeMode {
        activation: Activation::new(ActivationMode::NextCycle),
        ..OnlineChangeMode::default()
    };
    rig.tables
        .set_online_change_mode(BACK_AND_FORTH, at_seam)
        .unwrap();
    rig.lead(10.0, 1.0);
    rig.tables
        .write(BACK_AND_FORTH, &[rest(2, 180.0, 40.0)])
        .unwrap();
    assert_eq!(at_top(&rig, &mut reading), 50.0, "it waits");
    rig.lead(361.0, 1.0);
    assert_eq!(at_top(&rig, &mut reading), 40.0);
    let mut other = prepared(&three(20.0));
    rig.tables
        .select(BACK_AND_FORTH, true, &mut other, ROOM)
        .unwrap();
    assert_eq!(at_top(&rig, &mut reading), 40.0, "it waits");
    rig.lead(721.0, 1.0);
    assert_eq!(at_top(&rig, &mut reading), 20.0);
    let refused = rig.tables.read_plate(77, &mut reading);
    assert_eq!(code(refused), 0x4216);
}

#[test]
fn what_couples_the_slave_is_told_in_a_few_words() {
    let mut rig = Rig::new();
    assert_eq!(rig.coupling.cam_state(&rig.tables), None);
    rig = Rig::coupled(WITH_LIFT);
    rig.lead(2.0 * 360.0 + 90.0, 3.0);
    let state = rig.coupling.cam_state(&rig.tables).unwrap();
    let info = rig.coupling.info(&rig.tables, 0, None).unwrap();
    assert_eq!(state.table, WITH_LIFT);
    assert_eq!(state.master_cam_position, info.master_cam_position);
    assert_eq!(state.slave_cam_position, info.slave_cam_position);
    assert_near(state.master_cam_position, 90.0);
}
