//! Coupling: formulas, start modes, cycles with lift, jumps, ends.

use super::*;

/// Masters on and beside the seams, in both directions.
const MASTERS: [f64; 9] = [0.0, 1.0, 90.0, 359.0, 360.0, 361.0, 1000.0, -1.0, -500.0];

#[test]
fn positions_follow_the_manual_s_formulas() {
    for master in MASTERS {
        let mut rig = Rig::new();
        // Four different values, so that none can stand in for another.
        let (mo, so, ms, ss) = (15.0, -3.0, 2.0, 0.5);
        rig.start(CamRequest::from(CamIn {
            master_offset: mo,
            slave_offset: so,
            master_scaling: ms,
            slave_scaling: ss,
            jump: JumpHandling::Allow,
            ..cam_in(BACK_AND_FORTH)
        }))
        .unwrap();
        rig.go(0.0);
        rig.go(master);
        assert_near(
            rig.slave.position,
            rig.raw(BACK_AND_FORTH, (master + mo) / ms) * ss + so,
        );
    }
}

#[test]
fn velocity_and_acceleration_are_the_chain_rule_s() {
    let mut rig = Rig::new();
    rig.start(CamRequest::from(CamIn {
        master_scaling: -2.0,
        slave_scaling: 3.0,
        master_offset: 40.0,
        jump: JumpHandling::Allow,
        ..cam_in(WITH_LIFT)
    }))
    .unwrap();
    // The master at constant acceleration: the slave's derivatives must fit its positions.
    let master_at = |t: f64| Kinematics {
        position: 700.0 + 90.0 * t + 15.0 * t * t,
        velocity: 90.0 + 30.0 * t,
        acceleration: 30.0,
    };
    // Central differences: truncation h²/6 of the third derivative, far below the bounds.
    let h = 1e-4;
    for step in 0..40 {
        let t = f64::from(step) * 0.1;
        let mut slave_at = |t| rig.coupling.update(&mut rig.tables, &master_at(t));
        let (before, now, after) = (slave_at(t - h), slave_at(t), slave_at(t + h));
        let velocity = (after.position - before.position) / (2.0 * h);
        let acceleration = (after.velocity - before.velocity) / (2.0 * h);
        assert!((now.velocity - velocity).abs() < 1e-4, "{t}");
        assert!((now.acceleration - acceleration).abs() < 1e-3, "{t}");
    }
}

#[test]
fn start_modes_place_the_origin() {
    let (master, slave) = (70.0, 12.0);
    for (start_mode, origin) in [
        (StartMode::Absolute, (0.0, 0.0)),
        (StartMode::Relative, (master, slave)),
        (StartMode::MasterAbsoluteSlaveRelative, (0.0, slave)),
        (StartMode::MasterRelativeSlaveAbsolute, (master, 0.0)),
    ] {
        let mut rig = Rig::new();
        rig.master.position = master;
        rig.slave.position = slave;
        rig.start(CamRequest::from(CamIn {
            start_mode,
            master_offset: 5.0,
            slave_offset: 1.0,
            jump: JumpHandling::Allow,
            ..cam_in(BACK_AND_FORTH)
        }))
        .unwrap();
        for to in [70.0, 100.0, 333.0] {
            rig.go(to);
            let expected = rig.raw(BACK_AND_FORTH, to - origin.0 + 5.0) + origin.1 + 1.0;
            assert_near(rig.slave.position, expected);
        }
    }
}

#[test]
fn a_relative_master_counts_from_the_activation_position_whatever_the_cycle_time() {
    for step in [0.7, 3.0, 11.0] {
        let mut rig = Rig::new();
        rig.start(CamRequest::from(CamIn {
            start_mode: StartMode::MasterRelativeSlaveAbsolute,
            // Between two cycles for each of the steps.
            activation: activation(ActivationMode::AtMasterAxisPos, 50.5),
            ..cam_in(BACK_AND_FORTH)
        }))
        .unwrap();
        rig.lead(100.0, step);
        assert_near(rig.slave.position, rig.raw(BACK_AND_FORTH, 49.5));
    }
}

#[test]
fn lift_adds_up_in_both_directions_and_a_new_coupling_starts_in_the_base_cycle() {
    let mut rig = Rig::coupled(WITH_LIFT);
    rig.lead(360.0 * 3.0 + 90.0, 7.0);
    assert_near(rig.slave.position, 300.0 + rig.raw(WITH_LIFT, 90.0));
    // Two turns below the base cycle: two lifts less.
    rig.lead(-360.0 * 2.0 + 90.0, 7.0);
    assert_near(rig.slave.position, -200.0 + rig.raw(WITH_LIFT, 90.0));

    rig.start(CamOut {}.into()).unwrap();
    rig.slave.position = rig.raw(WITH_LIFT, 90.0);
    rig.start(CamRequest::from(cam_in(WITH_LIFT))).unwrap();
    rig.go(-360.0 * 2.0 + 91.0);
    assert_near(rig.slave.position, rig.raw(WITH_LIFT, 91.0));
    let info = rig.coupling.info(&rig.tables, 0, None).unwrap();
    assert_near(info.sum_of_slave_strokes, 0.0);
}

#[test]
fn a_linear_plate_holds_at_its_edges() {
    let mut rig = Rig::coupled(LINEAR);
    rig.lead(150.0, 5.0);
    assert_eq!(rig.slave, Kinematics::at_rest(40.0));
    rig.lead(-20.0, 5.0);
    assert_eq!(rig.slave, Kinematics::at_rest(0.0));
}

#[test]
fn a_jump_is_refused_and_nothing_has_changed() {
    let mut rig = Rig::new();
    rig.slave.position = 0.1;
    let at_once = rig.start(CamRequest::from(cam_in(BACK_AND_FORTH)));
    assert_eq!(at_once.unwrap_err().code(), 0x421A);
    assert_eq!(rig.coupling.state(), CommandState::Idle);
    // A waiting command is refused when it is due.
    let ticket = rig
        .start(CamRequest::from(CamIn {
            activation: activation(ActivationMode::AtMasterAxisPos, 0.5),
            ..cam_in(BACK_AND_FORTH)
        }))
        .unwrap();
    rig.go(1.0);
    let CommandState::Failed(error) = rig.state(ticket) else {
        panic!("{:?}", rig.state(ticket));
    };
    assert_eq!(error.code(), 0x421A);
    assert_eq!(rig.coupling.state(), CommandState::Idle);
    assert_eq!(rig.slave.position, 0.1);
    assert!(
        rig.tables.remove(BACK_AND_FORTH).is_ok(),
        "it is free again"
    );

    let mut rig = Rig::coupled(BACK_AND_FORTH);
    rig.lead(90.0, 1.0);
    assert!(rig.start(CamRequest::from(cam_in(LINEAR))).is_err());
    rig.go(91.0);
    assert_eq!(rig.coupling.state(), CommandState::InSync);
    assert_near(rig.slave.position, rig.raw(BACK_AND_FORTH, 91.0));
    assert!(rig.tables.remove(LINEAR).is_ok());
}

#[test]
fn a_ramp_leads_onto_the_plate_without_a_step() {
    let jump = JumpHandling::RampIn {
        master_length: 60.0,
    };
    for direction in [1.0, -1.0] {
        let mut rig = Rig::new();
        rig.master.position = 100.0;
        rig.slave.position = -20.0;
        let ticket = rig
            .start(CamRequest::from(CamIn {
                jump,
                ..cam_in(BACK_AND_FORTH)
            }))
            .unwrap();
        rig.go(100.0);
        assert_eq!(rig.slave.position, -20.0);
        assert_eq!(rig.state(ticket), CommandState::Active);
        rig.go(100.0 + direction * 1e-3);
        assert!((rig.slave.velocity / rig.master.velocity).abs() < 1e-4);
        let largest = rig.lead(100.0 + direction * 59.0, 0.1);
        // The ramp's slope is about 1.875·50/60, the plate's at most 0.52: 0.21 in a step of 0.1.
        assert!(largest < 0.3, "{largest}");
        assert_eq!(rig.state(ticket), CommandState::Active);
        rig.lead(100.0 + direction * 61.0, 0.1);
        assert_eq!(rig.state(ticket), CommandState::InSync);
        assert_near(
            rig.slave.position,
            rig.raw(BACK_AND_FORTH, rig.master.position),
        );
    }
}

#[test]
fn cam_out_leaves_the_velocity_without_acceleration() {
    let mut rig = Rig::coupled(BACK_AND_FORTH);
    rig.lead(60.0, 1.0);
    let before = rig.slave;
    assert!(before.acceleration != 0.0);
    let ticket = rig.start(CamOut {}.into()).unwrap();
    assert_eq!(rig.state(ticket), CommandState::Done);
    assert_eq!(rig.coupling.state(), CommandState::Idle);
    let after = Kinematics {
        acceleration: 0.0,
        ..before
    };
    assert_eq!(*rig.coupling.slave(), after);
    assert!(rig.tables.remove(BACK_AND_FORTH).is_ok());
}

#[test]
fn what_is_cut_short_is_aborted() {
    let mut rig = Rig::new();
    let first = rig.start(CamRequest::from(cam_in(BACK_AND_FORTH))).unwrap();
    rig.go(0.0);
    let queued = rig
        .start(CamRequest::from(CamIn {
            activation: Activation::new(ActivationMode::NextCycle),
            ..cam_in(SMALL)
        }))
        .unwrap();
    let scaling = rig
        .start(CamRequest::from(CamScaling {
            activation: activation(ActivationMode::AtMasterAxisPos, 50.0),
            ..CamScaling::default()
        }))
        .unwrap();
    assert_eq!(rig.state(first), CommandState::InSync);
    assert_eq!(rig.state(queued), CommandState::Active);
    assert_eq!(rig.tables.remove(SMALL).unwrap_err().code(), 0x4259);
    rig.start(CamOut {}.into()).unwrap();
    for ticket in [first, queued, scaling] {
        assert_eq!(rig.state(ticket), CommandState::Aborted);
    }
    assert!(rig.tables.remove(SMALL).is_ok());
}

#[test]
fn a_switch_aborts_the_block_before() {
    let mut rig = Rig::new();
    let first = rig.start(CamRequest::from(cam_in(BACK_AND_FORTH))).unwrap();
    rig.go(0.0);
    let second = rig
        .start(CamRequest::from(CamIn {
            activation: Activation::new(ActivationMode::NextCycle),
            ..cam_in(SMALL)
        }))
        .unwrap();
    rig.lead(370.0, 1.0);
    assert_eq!(rig.state(first), CommandState::Aborted);
    assert_eq!(rig.state(second), CommandState::InSync);
}

#[test]
fn info_tells_the_state_here_and_elsewhere_and_after_an_error() {
    let mut rig = Rig::new();
    rig.start(CamRequest::from(CamIn {
        master_scaling: 2.0,
        slave_scaling: 3.0,
        ..cam_in(WITH_LIFT)
    }))
    .unwrap();
    rig.lead(720.0 + 180.0, 4.0);
    let info = rig.coupling.info(&rig.tables, 0, None).unwrap();
    assert_eq!(
        (info.table, info.master_axis_id, info.slave_axis_id),
        (2, 7, 8)
    );
    assert_eq!((info.rows, info.columns), (2, 1));
    assert_near(info.raw_master_period, 360.0);
    assert_near(info.raw_slave_stroke, 100.0);
    assert_near(info.master_cam_position, 90.0);
    assert_near(info.slave_cam_position, rig.raw(WITH_LIFT, 90.0));
    // 900 of the master are 450 on the plate: one turn, and a stroke of 100·3.
    assert_near(info.sum_of_slave_strokes, 300.0);
    assert_near(info.slave_axis_position, rig.slave.position);
    assert_near(
        info.sum_of_slave_strokes + info.slave_scaling * info.slave_cam_position,
        info.slave_axis_position,
    );

    let elsewhere = rig
        .coupling
        .info(&rig.tables, WITH_LIFT, Some(-180.0))
        .unwrap();
    // -90 on the plate lies in the turn below.
    assert_near(elsewhere.master_cam_position, 270.0);
    assert_near(elsewhere.sum_of_slave_strokes, -300.0);
    assert_near(
        elsewhere.slave_axis_position,
        -300.0 + 3.0 * rig.raw(WITH_LIFT, 270.0),
    );

    rig.coupling.axis_error(&mut rig.tables, 0x4550);
    assert_eq!(rig.coupling.info(&rig.tables, 0, None).unwrap(), info);
    let held = rig.slave;
    rig.go(5_000.0);
    assert_eq!(rig.slave, held);
    assert!(matches!(rig.coupling.state(), CommandState::Failed(_)));
    rig.start(CamOut {}.into()).unwrap();
    assert_eq!(
        rig.coupling.info(&rig.tables, 0, None).unwrap_err().code(),
        0x4256
    );
}

#[test]
fn a_master_that_is_no_number_breaks_the_coupling_off() {
    let mut rig = Rig::coupled(BACK_AND_FORTH);
    rig.lead(50.0, 1.0);
    let held = rig.slave;
    rig.go(f64::NAN);
    assert_eq!(rig.slave, held);
    assert!(matches!(
        rig.coupling.state(),
        CommandState::Failed(CouplingError::AxisError { code: 0 })
    ));
}
