//! TF5050 chapters 6.3 to 6.5: points that change while slaves are on them.

use super::*;

/// Three segments: 0 to 120, to 240, to 360.
const PLATE: TableId = 9;
const POINTS: [(f64, f64); 4] = [(0.0, 0.0), (120.0, 30.0), (240.0, 50.0), (360.0, 0.0)];

fn rig() -> Rig {
    let mut rig = Rig::new();
    rig.tables
        .insert(PLATE, plate(&POINTS, Course::Cyclic))
        .expect("room");
    rig.start(CamRequest::from(cam_in(PLATE)))
        .expect("a coupling");
    rig.go(0.0);
    rig
}

fn set(rig: &mut Rig, mode: OnlineChangeMode) {
    rig.tables
        .set_online_change_mode(PLATE, mode)
        .expect("a mode");
}

fn queued(rig: &Rig) -> bool {
    rig.tables.data_queued(PLATE).expect("a table")
}

fn mode(mode: ActivationMode) -> OnlineChangeMode {
    OnlineChangeMode {
        activation: Activation::new(mode),
        ..OnlineChangeMode::default()
    }
}

#[test]
fn a_change_that_would_make_the_slave_jump_waits() {
    let mut rig = rig();
    rig.lead(60.0, 1.0);
    rig.tables.write(PLATE, &[rest(2, 120.0, 20.0)]).unwrap();
    let largest = rig.lead(220.0, 1.0);
    assert!(largest < 1.0, "{largest}");
    // Moving point 2 changes both segments around it, from 0 to 240.
    assert!(queued(&rig), "the second segment changes, too");
    rig.lead(242.0, 1.0);
    assert!(!queued(&rig));
    rig.lead(360.0 + 120.0, 1.0);
    assert_near(rig.slave.position, 20.0);
}

#[test]
fn what_waits_adds_up_and_the_later_point_counts() {
    let mut rig = rig();
    set(&mut rig, mode(ActivationMode::NextCycle));
    rig.lead(60.0, 1.0);
    rig.tables.write(PLATE, &[rest(2, 120.0, 20.0)]).unwrap();
    rig.tables
        .write(PLATE, &[rest(3, 240.0, 40.0), rest(2, 130.0, 25.0)])
        .unwrap();
    assert_eq!(rig.tables.read(PLATE, 2, 1).unwrap()[0].slave, 30.0);
    rig.lead(360.0 + 130.0, 1.0);
    assert_near(rig.slave.position, 25.0);
    rig.lead(360.0 + 240.0, 1.0);
    assert_near(rig.slave.position, 40.0);
    let points = rig.tables.read(PLATE, 1, 0).unwrap();
    assert_eq!(points.len(), 4);
    assert_eq!((points[1].master, points[1].slave), (130.0, 25.0));
}

#[test]
fn a_plate_without_slaves_changes_at_once() {
    let mut rig = Rig::new();
    rig.tables
        .insert(PLATE, plate(&POINTS, Course::Cyclic))
        .unwrap();
    set(&mut rig, mode(ActivationMode::NextCycle));
    rig.tables.write(PLATE, &[rest(2, 120.0, 20.0)]).unwrap();
    assert_eq!(rig.raw(PLATE, 120.0), 20.0);
}

#[test]
fn a_refused_write_leaves_the_queue_as_it_is() {
    let mut rig = rig();
    set(&mut rig, mode(ActivationMode::NextCycle));
    rig.tables.write(PLATE, &[rest(2, 120.0, 20.0)]).unwrap();
    assert!(rig.tables.write(PLATE, &[rest(3, 110.0, 1.0)]).is_err());
    assert!(rig.tables.write(PLATE, &[rest(9, 110.0, 1.0)]).is_err());
    rig.lead(360.0 + 120.0, 1.0);
    assert_near(rig.slave.position, 20.0);
    rig.lead(360.0 + 240.0, 1.0);
    assert_near(rig.slave.position, 50.0);
}

/// A check without effect was against the points before the last change.
#[test]
fn points_are_checked_against_those_in_force() {
    let mut tables = Tables::new(1);
    let points = [(0.0, 0.0), (120.0, 30.0), (240.0, 50.0), (360.0, 0.0)];
    tables
        .insert(PLATE, plate(&points, Course::Cyclic))
        .unwrap();
    tables.write(PLATE, &[rest(2, 200.0, 30.0)]).unwrap();
    let before_it = [rest(3, 150.0, 50.0)];
    let refused = |tables: &mut Tables| {
        let planned = tables.plan_write(PLATE, &before_it).unwrap_err();
        let written = tables.write(PLATE, &before_it).unwrap_err();
        assert_eq!(planned, written);
        written.code()
    };
    assert_eq!(refused(&mut tables), 0x4A06);
    tables
        .set_online_change_mode(PLATE, mode(ActivationMode::Off))
        .unwrap();
    assert_eq!(refused(&mut tables), 0x4A06);
    // Allowed with the points in force only.
    tables.write(PLATE, &[rest(2, 230.0, 30.0)]).unwrap();
    assert_eq!(tables.read(PLATE, 2, 1).unwrap()[0].master, 200.0);
}

#[test]
fn a_deleted_change_leaves_no_trace_in_the_next() {
    let mut rig = rig();
    set(&mut rig, mode(ActivationMode::NextCycle));
    rig.tables.write(PLATE, &[rest(2, 120.0, 20.0)]).unwrap();
    set(&mut rig, mode(ActivationMode::DeleteQueuedData));
    rig.tables.write(PLATE, &[rest(3, 240.0, 40.0)]).unwrap();
    rig.lead(360.0 + 120.0, 1.0);
    assert_near(rig.slave.position, 30.0);
    rig.lead(360.0 + 240.0, 1.0);
    assert_near(rig.slave.position, 40.0);
}

#[test]
fn every_slave_takes_the_change_at_its_own_moment() {
    let mut rig = rig();
    let mut other = CamCoupling::new(CouplingParameters {
        master_axis_id: 7,
        slave_axis_id: 9,
        limits: LIMITS,
    })
    .unwrap();
    // The other slave is half a cycle behind.
    let shifted = CamRequest::from(CamIn {
        master_offset: -180.0,
        jump: JumpHandling::Allow,
        ..cam_in(PLATE)
    });
    other
        .start(&mut rig.tables, &shifted, &rig.master, &rig.slave)
        .unwrap();
    other.update(&mut rig.tables, &rig.master);
    set(&mut rig, mode(ActivationMode::NextCycle));
    rig.tables.write(PLATE, &[rest(2, 120.0, 20.0)]).unwrap();
    let old = plate(&POINTS, Course::Cyclic);
    let mut points = POINTS;
    points[1].1 = 20.0;
    let new = plate(&points, Course::Cyclic);
    for step in 0..=600 {
        let master = f64::from(step);
        let first = rig.go(master);
        let second = other.update(&mut rig.tables, &rig.master).position;
        let of = |is_new, master| if is_new { new.at(master) } else { old.at(master) }.position;
        assert_near(first, of(step >= 360, master));
        assert_near(second, of(step >= 180, master - 180.0));
        if (181..360).contains(&step) {
            let refused = rig.tables.write(PLATE, &[rest(2, 120.0, 21.0)]);
            assert_eq!(refused.unwrap_err().code(), 0x4287);
        }
    }
    assert!(!queued(&rig));
}

#[test]
fn a_longer_period_keeps_the_master_s_part_of_the_cycle() {
    let mut rig = rig();
    let automatic = OnlineChangeMode {
        activation: activation(ActivationMode::AtMasterCamPos, 300.0),
        master_scaling_mode: ScalingMode::AutoOffset,
        slave_scaling_mode: ScalingMode::AutoOffset,
        jump: JumpHandling::Refuse,
    };
    set(&mut rig, automatic);
    rig.lead(2.0 * 360.0 + 290.0, 1.0);
    rig.tables.write(PLATE, &[rest(4, 480.0, 0.0)]).unwrap();
    let largest = rig.lead(2.0 * 360.0 + 310.0, 1.0);
    assert!(largest < 2.0, "{largest}");
    let info = rig
        .coupling
        .info(&rig.tables, 0, Some(2.0 * 360.0 + 300.0))
        .unwrap();
    assert_near(info.raw_master_period, 480.0);
    // 300 of 360 are 400 of 480.
    assert_near(info.master_cam_position, 400.0);
}

#[test]
fn a_new_lift_does_not_move_the_cycles_that_are_done() {
    let mut rig = Rig::coupled(WITH_LIFT);
    rig.lead(5.0 * 360.0 + 100.0, 3.0);
    let at_seam = mode(ActivationMode::AsSoonAsPossible);
    rig.tables
        .set_online_change_mode(WITH_LIFT, at_seam)
        .unwrap();
    rig.tables
        .write(WITH_LIFT, &[rest(2, 360.0, 80.0)])
        .unwrap();
    let largest = rig.lead(7.0 * 360.0, 0.5);
    assert!(largest < 0.5, "{largest}");
    // Six cycles of the old lift: its only segment changes, so the change waits for the seam at 6·360.
    assert_near(rig.slave.position, 600.0 + 80.0);
}

#[test]
fn a_change_for_one_cycle_leaves_the_points_as_they_were() {
    let mut rig = rig();
    set(&mut rig, mode(ActivationMode::NextCycleOnce));
    rig.tables.write(PLATE, &[rest(2, 120.0, 20.0)]).unwrap();
    rig.lead(360.0 + 120.0, 1.0);
    assert_near(rig.slave.position, 20.0);
    rig.lead(720.0 + 120.0, 1.0);
    assert_near(rig.slave.position, 30.0);
    assert!(!queued(&rig));
    assert_eq!(rig.tables.read(PLATE, 2, 1).unwrap()[0].slave, 30.0);
    // And the next change starts from there.
    rig.tables.write(PLATE, &[rest(3, 240.0, 40.0)]).unwrap();
    rig.lead(1080.0 + 120.0, 1.0);
    assert_near(rig.slave.position, 30.0);
    rig.lead(1080.0 + 240.0, 1.0);
    assert_near(rig.slave.position, 40.0);
}

#[test]
fn a_position_table_takes_no_points() {
    use coaxle_plate::{Interpolation, PositionTable};
    let rows = [(0.0, 0.0), (1.0, 1.0)];
    let table = PositionTable::new(&rows, Interpolation::Linear, Course::Linear).unwrap();
    let mut tables = Tables::new(1);
    tables.insert(1, Plate::from_table(table)).unwrap();
    let code = |result: Result<(), CouplingError>| result.unwrap_err().code();
    assert_eq!(code(tables.write(1, &[rest(1, 0.0, 0.0)])), 0x4262);
    assert_eq!(
        code(tables.set_online_change_mode(1, OnlineChangeMode::default())),
        0x4262
    );
    assert_eq!(tables.read(1, 1, 1).unwrap_err().code(), 0x4262);
}

/// `own-points-waiting`: the slave took the waiting points at once, 32 u in a cycle, although a jump
/// should be refused.
#[test]
fn coupled_again_while_its_own_points_wait_they_go_on_waiting() {
    for jump in [
        JumpHandling::Refuse,
        JumpHandling::RampIn {
            master_length: 60.0,
        },
    ] {
        for slave_scaling_mode in [ScalingMode::UserDefined, ScalingMode::AutoOffset] {
            let mut rig = rig();
            // Beyond the end of the test, so that only coupling again could bring the points.
            let never = Activation::at(ActivationMode::AtMasterAxisPos, 1e6);
            set(
                &mut rig,
                OnlineChangeMode {
                    activation: never,
                    ..OnlineChangeMode::default()
                },
            );
            rig.lead(100.0, 1.0);
            rig.tables.write(PLATE, &[rest(2, 120.0, 80.0)]).unwrap();
            let again = CamRequest::from(CamIn {
                activation: activation(ActivationMode::AtMasterAxisPos, 150.0),
                slave_scaling_mode,
                jump,
                ..cam_in(PLATE)
            });
            let job = rig.start(again).expect("it is taken");
            let largest = rig.lead(800.0, 1.0);
            assert!(largest < 1.0, "{jump:?} {slave_scaling_mode:?}: {largest}");
            assert_eq!(rig.state(job), CommandState::InSync);
            assert!(queued(&rig), "{jump:?} {slave_scaling_mode:?}");
            assert_eq!(rig.raw(PLATE, 120.0), 30.0);
        }
    }
}

/// Points for a place of the plate where they make the slave jump waited for ever, without a report.
#[test]
fn what_is_held_back_is_said_once() {
    let mut rig = rig();
    set(
        &mut rig,
        OnlineChangeMode {
            activation: Activation::at(ActivationMode::AtMasterCamPos, 100.0),
            ..OnlineChangeMode::default()
        },
    );
    rig.lead(60.0, 1.0);
    rig.tables.write(PLATE, &[rest(2, 120.0, 20.0)]).unwrap();
    rig.lead(99.0, 1.0);
    assert_eq!(rig.coupling.take_rejected_points(), None);
    rig.lead(101.0, 1.0);
    let why = rig.coupling.take_rejected_points().expect("it is said");
    assert_eq!(why.code(), 0x421A, "{why}");
    rig.lead(360.0 + 101.0, 1.0);
    assert_eq!(rig.coupling.take_rejected_points(), None, "once");
    assert!(queued(&rig));
    rig.tables.write(PLATE, &[rest(2, 120.0, 21.0)]).unwrap();
    rig.lead(720.0 + 101.0, 1.0);
    assert!(rig.coupling.take_rejected_points().is_some());
}
