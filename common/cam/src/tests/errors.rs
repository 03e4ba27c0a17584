//! Refusals of every kind, with code and text.

use std::string::ToString;

use super::*;

fn refused(rig: &mut Rig, command: CamRequest) -> CouplingError {
    rig.start(command).expect_err("a refusal")
}

/// Checks the code, and that the text begins with it.
fn is_refused(error: CouplingError, code: u32, says: &str) {
    assert_eq!(error.code(), code, "{error}");
    let text = error.to_string();
    assert!(text.starts_with(&std::format!("{code:#06x}: ")), "{text}");
    assert!(text.contains(says), "{text}");
}

fn at(mode: ActivationMode, position: f64) -> CamRequest {
    CamRequest::from(CamIn {
        activation: activation(mode, position),
        ..cam_in(BACK_AND_FORTH)
    })
}

#[test]
fn of_the_store() {
    let mut tables = Tables::new(1);
    let any = || plate(&[(0.0, 0.0), (1.0, 1.0)], Course::Linear);
    for id in [0, 256] {
        is_refused(tables.insert(id, any()).unwrap_err(), 0x4B32, "1 to 255");
    }
    tables.insert(255, any()).unwrap();
    is_refused(tables.insert(255, any()).unwrap_err(), 0x4063, "255");
    is_refused(tables.insert(1, any()).unwrap_err(), 0x4A11, "full");
    is_refused(tables.remove(1).unwrap_err(), 0x4216, "table id 1");
    is_refused(tables.read(255, 3, 1).unwrap_err(), 0x4B33, "1 to 2");
    is_refused(tables.write(255, &[]).unwrap_err(), 0x4B34, "no points");
    assert_eq!(tables.ids().collect::<Vec<_>>(), [255]);
}

#[test]
fn of_a_table_in_use() {
    let mut rig = Rig::coupled(BACK_AND_FORTH);
    let error = rig.tables.remove(BACK_AND_FORTH).unwrap_err();
    is_refused(error, 0x4259, "table 1");
}

#[test]
fn of_a_first_coupling() {
    let mut rig = Rig::new();
    is_refused(refused(&mut rig, CamOut {}.into()), 0x4256, "not coupled");
    is_refused(
        refused(&mut rig, CamRequest::from(CamScaling::default())),
        0x4256,
        "not coupled",
    );
    is_refused(
        refused(&mut rig, CamRequest::from(cam_in(77))),
        0x4216,
        "77",
    );
    let scalings = [
        (0.0, 1.0, 0.0, 0x425B, "master scaling: received 0"),
        (f64::NAN, 1.0, 0.0, 0x425B, "master scaling"),
        (1.0, f64::INFINITY, 0.0, 0x425B, "slave scaling"),
        (1.0, 1.0, f64::NAN, 0x4A17, "slave offset"),
    ];
    for (master_scaling, slave_scaling, slave_offset, code, says) in scalings {
        let command = CamRequest::from(CamIn {
            master_scaling,
            slave_scaling,
            slave_offset,
            ..cam_in(1)
        });
        is_refused(refused(&mut rig, command), code, says);
    }
    let automatic = CamIn {
        master_scaling_mode: ScalingMode::AutoOffset,
        ..cam_in(1)
    };
    is_refused(
        refused(&mut rig, CamRequest::from(automatic)),
        0x4219,
        "no plate",
    );
    for start_mode in [StartMode::Relative, StartMode::MasterRelativeSlaveAbsolute] {
        let relative = CamRequest::from(CamIn {
            start_mode,
            ..automatic
        });
        is_refused(refused(&mut rig, relative), 0x425F, "relative master");
        for mode in [ActivationMode::AtMasterCamPos, ActivationMode::NextCycle] {
            let command = CamRequest::from(CamIn {
                start_mode,
                activation: Activation::new(mode),
                ..cam_in(1)
            });
            is_refused(refused(&mut rig, command), 0x4250, "relative master");
        }
    }
    for position in [-1.0, 361.0, f64::NAN] {
        let command = at(ActivationMode::AtMasterCamPos, position);
        is_refused(refused(&mut rig, command), 0x422B, "0 to 360");
    }
    for master_length in [0.0, -1.0, f64::NAN] {
        let command = CamRequest::from(CamIn {
            jump: JumpHandling::RampIn { master_length },
            ..cam_in(1)
        });
        is_refused(refused(&mut rig, command), 0x4A1C, "above 0");
    }
    assert_eq!(rig.coupling.state(), CommandState::Idle);
}

#[test]
fn of_axes_that_are_not_fit_for_it() {
    let mut rig = Rig::new();
    rig.master = Kinematics {
        position: 100.0,
        velocity: 5.0,
        acceleration: 0.0,
    };
    let command = at(ActivationMode::AtMasterAxisPos, 99.0);
    is_refused(
        refused(&mut rig, command),
        0x426D,
        "ahead of the master at 100",
    );
    rig.slave.velocity = 1.0;
    let command = at(ActivationMode::AtMasterAxisPos, 101.0);
    is_refused(refused(&mut rig, command), 0x426F, "1 u/s");
    rig.master.position = f64::NAN;
    is_refused(
        refused(&mut rig, CamRequest::from(cam_in(1))),
        0x42A0,
        "master or the slave",
    );
    assert!(
        CamCoupling::new(CouplingParameters {
            master_axis_id: 1,
            slave_axis_id: 2,
            limits: CamLimits {
                jerk: -1.0,
                ..LIMITS
            },
        })
        .is_err_and(|error| error.code() == 0x4A1C)
    );
}

#[test]
fn of_a_slave_that_moves_while_a_standing_master_should_lead_it() {
    let mut rig = Rig::new();
    rig.slave.velocity = 1.0;
    let command = CamRequest::from(CamIn {
        jump: JumpHandling::RampIn { master_length: 9.0 },
        ..cam_in(1)
    });
    is_refused(refused(&mut rig, command), 0x426F, "standstill");
}

#[test]
fn of_a_second_change_of_the_same_kind() {
    let mut rig = Rig::coupled(BACK_AND_FORTH);
    let switch = |mode| {
        CamRequest::from(CamIn {
            activation: Activation::new(mode),
            ..cam_in(SMALL)
        })
    };
    let scale = CamRequest::from(CamScaling {
        activation: Activation::new(ActivationMode::NextCycle),
        ..CamScaling::default()
    });
    rig.start(switch(ActivationMode::NextCycle)).unwrap();
    rig.start(scale).unwrap();
    let again = refused(&mut rig, switch(ActivationMode::NextCycle));
    is_refused(again, 0x4287, "table 1");
    is_refused(refused(&mut rig, scale), 0x4287, "table 1");
    // Discarding makes room.
    rig.start(switch(ActivationMode::DeleteQueuedData)).unwrap();
    rig.start(switch(ActivationMode::NextCycle)).unwrap();
}

#[test]
fn of_values_too_extreme_to_be_numbers() {
    let mut rig = Rig::new();
    rig.start(CamRequest::from(CamIn {
        // 50·1e308 is infinite, while 0·1e308 at the start is not.
        slave_scaling: 1e308,
        ..cam_in(BACK_AND_FORTH)
    }))
    .unwrap();
    rig.go(0.0);
    rig.go(180.0);
    let CommandState::Failed(error) = rig.coupling.state() else {
        panic!("{:?}", rig.coupling.state());
    };
    is_refused(error, 0x42DC, "numbers");
    assert_eq!(rig.slave.position, 0.0);
    let after = refused(&mut rig, CamRequest::from(cam_in(1)));
    assert_eq!(after, error, "until it is uncoupled");
}
