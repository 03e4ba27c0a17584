//! TF5050 chapter 5: superposed plates.

use super::*;

fn add(table: TableId) -> CamRequest {
    CamRequest::from(CamAdd {
        table,
        ..CamAdd::default()
    })
}

#[test]
fn plates_add_up_in_position_velocity_and_acceleration() {
    let mut rig = Rig::multi(BACK_AND_FORTH);
    for table in [WITH_LIFT, SMALL, SPARE] {
        rig.start(add(table)).unwrap();
    }
    rig.go(0.0);
    for master in [17.0, 123.0, 399.0, 1111.0, -77.0] {
        rig.go(master);
        let moving = rig.master;
        let mut sum = Kinematics::default();
        for table in [BACK_AND_FORTH, WITH_LIFT, SMALL, SPARE] {
            let slave = rig.tables.plate(table).unwrap().slave_dynamics(&moving);
            sum.position += slave.position;
            sum.velocity += slave.velocity;
            sum.acceleration += slave.acceleration;
        }
        assert_near(rig.slave.position, sum.position);
        assert_near(rig.slave.velocity, sum.velocity);
        assert!((rig.slave.acceleration / sum.acceleration - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_fifth_plate_is_refused() {
    let mut rig = Rig::multi(BACK_AND_FORTH);
    for table in [WITH_LIFT, SMALL, SPARE] {
        rig.start(add(table)).unwrap();
    }
    // Those that are queued count, too.
    assert_eq!(rig.start(add(LINEAR)).unwrap_err().code(), 0x425E);
    rig.go(0.0);
    assert_eq!(rig.start(add(LINEAR)).unwrap_err().code(), 0x425E);
    assert!(rig.tables.remove(LINEAR).is_ok());
}

#[test]
fn the_two_worlds_exclude_each_other() {
    let mut single = Rig::coupled(BACK_AND_FORTH);
    let v2 = CamRequest::from(CamInV2 {
        table: SMALL,
        ..CamInV2::default()
    });
    let scaling_v2 = CamRequest::from(CamScalingV2::default());
    for command in [v2, add(SMALL), scaling_v2] {
        assert_eq!(single.start(command).unwrap_err().code(), 0x425C);
    }
    let mut multi = Rig::multi(BACK_AND_FORTH);
    for command in [
        CamRequest::from(cam_in(SMALL)),
        CamRequest::from(CamScaling::default()),
    ] {
        assert_eq!(multi.start(command).unwrap_err().code(), 0x425C);
    }
    single.start(CamOut {}.into()).unwrap();
    single.slave = *single.coupling.slave();
    single.start(v2).unwrap();
}

#[test]
fn operations_of_cam_in_v2_do_what_the_blocks_do() {
    let mut rig = Rig::multi(BACK_AND_FORTH);
    let v2 = |operation, table, reference| {
        CamRequest::from(CamInV2 {
            operation,
            table,
            reference,
            ..CamInV2::default()
        })
    };
    rig.start(v2(OperationMode::Additive, SMALL, 0)).unwrap();
    rig.lead(180.0 * 2.0, 1.0);
    // Its placement in the axes is absolute, so it would jump to its position after 360.
    let jumps = rig.start(v2(OperationMode::Exchange, SPARE, SMALL));
    assert_eq!(jumps.unwrap_err().code(), 0x421A);
    rig.go(360.0);
    let ids = |rig: &Rig| {
        [BACK_AND_FORTH, SMALL, SPARE].map(|id| rig.coupling.info(&rig.tables, id, None).is_ok())
    };
    assert_eq!(ids(&rig), [true, true, false]);
    let mut exchange = CamInV2 {
        operation: OperationMode::Exchange,
        table: SPARE,
        reference: SMALL,
        ..CamInV2::default()
    };
    exchange.scaling.slave.mode = ScalingMode::AutoOffset;
    rig.start(CamRequest::from(exchange)).unwrap();
    rig.go(360.0);
    assert_eq!(ids(&rig), [true, false, true]);
    assert_near(rig.slave.position, 0.0);
    let ticket = rig.start(v2(OperationMode::Remove, SPARE, 0)).unwrap();
    rig.go(360.0);
    assert_eq!(rig.state(ticket), CommandState::Done);
    assert_eq!(ids(&rig), [true, false, false]);
}

#[test]
fn an_ambiguous_reference_is_refused() {
    let mut rig = Rig::multi(BACK_AND_FORTH);
    rig.start(add(SMALL)).unwrap();
    rig.go(0.0);
    let exchange = |reference| {
        CamRequest::from(CamExchange {
            table: SPARE,
            reference,
            ..CamExchange::default()
        })
    };
    assert_eq!(rig.start(exchange(0)).unwrap_err().code(), 0x4261);
    assert_eq!(rig.start(exchange(LINEAR)).unwrap_err().code(), 0x4261);
    assert_eq!(rig.start(add(SMALL)).unwrap_err().code(), 0x4261);
    assert!(rig.coupling.info(&rig.tables, 0, None).is_err());
    rig.start(exchange(SMALL)).unwrap();
}

#[test]
fn one_plate_is_scaled_and_the_others_are_not() {
    let mut rig = Rig::multi(BACK_AND_FORTH);
    rig.start(add(SMALL)).unwrap();
    rig.go(0.0);
    let mut scaling = CamScalingV2 {
        table: SMALL,
        ..CamScalingV2::default()
    };
    scaling.scaling.slave.scaling = -2.0;
    rig.start(CamRequest::from(scaling)).unwrap();
    rig.lead(100.0, 1.0);
    assert_near(
        rig.slave.position,
        rig.raw(BACK_AND_FORTH, 100.0) - 2.0 * rig.raw(SMALL, 100.0),
    );
}

#[test]
fn a_plate_relative_to_the_slave_adds_to_it() {
    let mut rig = Rig::multi(BACK_AND_FORTH);
    rig.lead(90.0, 1.0);
    let mut relative = CamAdd {
        table: SMALL,
        ..CamAdd::default()
    };
    relative.scaling.master.relative = true;
    relative.scaling.slave.relative = true;
    rig.start(CamRequest::from(relative)).unwrap();
    rig.lead(120.0, 1.0);
    assert_near(
        rig.slave.position,
        // 30 from its origin at 90.
        rig.raw(BACK_AND_FORTH, 120.0) + rig.raw(SMALL, 30.0),
    );
}

#[test]
fn a_plate_is_removed_on_a_ramp() {
    let mut rig = Rig::multi(BACK_AND_FORTH);
    rig.start(add(SMALL)).unwrap();
    rig.lead(80.0, 1.0);
    let remove = |jump| {
        CamRequest::from(CamRemove {
            table: SMALL,
            jump,
            ..CamRemove::default()
        })
    };
    assert!(rig.start(remove(JumpHandling::Refuse)).is_err());
    rig.go(80.0);
    rig.start(remove(JumpHandling::RampIn {
        master_length: 40.0,
    }))
    .unwrap();
    let largest = rig.lead(130.0, 0.1);
    // The plate's slope is at most 0.52 and that of the ramp 1.875·12.5/40 = 0.59, in steps of 0.1.
    assert!(largest < 0.12, "{largest}");
    assert_near(rig.slave.position, rig.raw(BACK_AND_FORTH, 130.0));
    assert_eq!(rig.coupling.state(), CommandState::InSync);
}

#[test]
fn without_its_last_plate_the_coupling_ends() {
    let mut rig = Rig::multi(BACK_AND_FORTH);
    rig.lead(90.0, 1.0);
    let before = rig.slave;
    let ticket = rig
        .start(CamRequest::from(CamRemove {
            table: BACK_AND_FORTH,
            ..CamRemove::default()
        }))
        .unwrap();
    rig.go(91.0);
    assert_eq!(rig.state(ticket), CommandState::Done);
    assert_eq!(rig.coupling.state(), CommandState::Idle);
    assert_near(rig.slave.position, before.position);
    assert_near(rig.slave.velocity, before.velocity);
    assert_eq!(rig.slave.acceleration, 0.0);
}

/// All that four places can hold ends with the coupling: of 21 ends only 16 were remembered and reported.
#[test]
fn every_command_that_ends_with_the_coupling_is_known() {
    let mut rig = Rig::new();
    rig.tables = Tables::new(8);
    for table in 1..=8 {
        let plate = plate(&[(0.0, 0.0), (180.0, 1.0), (360.0, 0.0)], Course::Cyclic);
        rig.tables.insert(table, plate).expect("room");
    }
    let exchange = |reference, table, activation| {
        CamRequest::from(CamExchange {
            table,
            reference,
            activation,
            ..CamExchange::default()
        })
    };
    let never = Activation::at(ActivationMode::AtMasterAxisPos, 1e6);
    let once = Activation::new(ActivationMode::NextCycleOnce);
    let first = CamRequest::from(CamInV2 {
        table: 1,
        ..CamInV2::default()
    });
    let mut jobs: Vec<Job> = [first, add(2), add(3), add(4)]
        .map(|request| rig.start(request).unwrap())
        .into();
    rig.lead(10.0, 1.0);
    jobs.extend((1..=4).map(|table| rig.start(exchange(table, table + 4, once)).unwrap()));
    // Each place now keeps its first plate, to return to.
    rig.lead(370.0, 1.0);
    for table in 5..=8 {
        let scaling = CamRequest::from(CamScalingV2 {
            table,
            activation: never,
            ..CamScalingV2::default()
        });
        jobs.push(rig.start(scaling).unwrap());
        jobs.push(rig.start(exchange(table, table - 4, never)).unwrap());
    }
    assert_eq!(rig.coupling.next_ended(), None);
    let out = rig.start(CamRequest::from(CamOut {})).unwrap();
    for job in &jobs {
        assert_eq!(rig.state(*job), CommandState::Aborted, "{job:?}");
    }
    assert_eq!(rig.state(out), CommandState::Done);
    // The first job's end is its owner's to see.
    jobs.remove(0);
    jobs.push(out);
    let mut reported = Vec::new();
    while let Some(job) = rig.coupling.next_ended() {
        assert!(!reported.contains(&job), "once: {job:?}");
        reported.push(job);
    }
    reported.sort_by_key(|job| job.number);
    assert_eq!(reported, jobs);
}
