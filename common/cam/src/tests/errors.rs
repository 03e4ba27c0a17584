//! Refusals of every kind, with code and text.

use std::string::ToString;

use super::*;
use coaxle_plate::{Interpolation, PositionTable};

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

/// Plans a coupling to plate 30 at the next cycle, for a slave of 60 000 u/s² that rests at 0.
fn plan_next_cycle(tables: &Tables, position: f64, velocity: f64) -> Result<(), CouplingError> {
    let next_cycle = Activation::new(ActivationMode::NextCycle);
    plan_within(60_000.0, next_cycle, tables, position, velocity)
}

fn plan_within(
    acceleration: f64,
    activation: Activation,
    tables: &Tables,
    position: f64,
    velocity: f64,
) -> Result<(), CouplingError> {
    let parameters = CouplingParameters {
        master_axis_id: 7,
        slave_axis_id: 8,
        limits: CamLimits {
            velocity: 2_000.0,
            acceleration,
            deceleration: acceleration,
            jerk: 1e7,
            cycle: 0.001,
        },
    };
    let coupling = CamCoupling::new(parameters).expect("parameters");
    let master = Kinematics {
        position,
        velocity,
        acceleration: 0.0,
    };
    let command = CamRequest::from(CamIn {
        activation,
        ..cam_in(30)
    });
    let planned = coupling.plan(tables, &command, &master, &Kinematics::at_rest(0.0));
    planned.map(|_| ())
}

/// Returns a store with plate 30.
fn tables_with(plate: Plate) -> Tables {
    let mut tables = Tables::new(1);
    tables.insert(30, plate).expect("room");
    tables
}

/// Quintic of 40 u over 1.2 u of the master, as narrow as three of 360 degrees.
const NARROW_PEAK: [(f64, f64); 4] = [(102.3, 0.0), (103.5, 40.0), (200.0, 40.0), (360.0, 0.0)];

/// Returns the narrow peak after this number of rests from 0 on, as far apart as `step`.
fn after_rests(count: u32, step: f64) -> Vec<(f64, f64)> {
    let rests = (0..count).map(|row| (f64::from(row) * step, 0.0));
    rests.chain(NARROW_PEAK).collect()
}

/// `narrow-peak`: a plate ten times too fast for its slave was accepted or refused depending on the
/// millisecond.
#[test]
fn a_narrow_peak_is_seen_wherever_the_master_is() {
    let tables = tables_with(plate(&after_rests(1, 0.0), Course::Cyclic));
    // Of the quintic, 5.7735 · 40 / 1.2² u/u²: more than 60 000 u/s² from 19.3 u/s of the master on.
    for (velocity, passes) in [(19.0, true), (19.7, false), (320.0, false), (-19.7, false)] {
        for place in 0..300 {
            // No divisor of the distance of the places, 360/128: each start looks at other ones.
            let position = 0.377 * f64::from(place);
            match plan_next_cycle(&tables, position, velocity) {
                Ok(()) => assert!(passes, "{velocity} at {position}"),
                Err(CouplingError::BeyondLimits { .. }) => assert!(!passes, "{velocity}"),
                Err(other) => panic!("{velocity}: {other}"),
            }
        }
    }
}

/// Of plates with more than 256 segments only the ends of segments were searched.
#[test]
fn a_narrow_peak_is_seen_in_a_plate_of_any_length() {
    for (count, step) in [(252, 0.3), (299, 0.3), (4_092, 0.025)] {
        let tables = tables_with(plate(&after_rests(count, step), Course::Cyclic));
        for (velocity, passes) in [(19.0, true), (19.7, false), (-21.0, false), (21.0, false)] {
            for place in 0..300 {
                let position = 0.377 * f64::from(place);
                let planned = plan_next_cycle(&tables, position, velocity);
                let is_refused = matches!(planned, Err(CouplingError::BeyondLimits { .. }));
                assert_eq!(is_refused, !passes, "{count}, {velocity}: {planned:?}");
                assert_eq!(planned.is_ok(), passes, "{planned:?}");
            }
        }
    }
}

/// Cubics of a table are steepest inside, too.
#[test]
fn a_steep_place_between_two_rows_of_a_long_table_is_seen() {
    let rows = after_rests(299, 0.3);
    let next_cycle = Activation::new(ActivationMode::NextCycle);
    for kind in [Interpolation::Spline, Interpolation::SlidingSpline] {
        let table = PositionTable::new(&rows, kind, Course::Cyclic).expect("a table");
        let table = Plate::from_table(table);
        let velocity = table
            .characteristics(1.0)
            .expect("figures")
            .extremes
            .velocity;
        let steepest = velocity.maximum.value.max(-velocity.minimum.value);
        // Of the cubic over 1.2 u, the ends are less steep by a third.
        let tables = tables_with(table);
        for place in 0..300 {
            for (part, passes) in [(0.999, true), (1.001, false)] {
                let velocity = part * 2_000.0 / steepest;
                let position = 0.377 * f64::from(place);
                let planned = plan_within(1e9, next_cycle, &tables, position, velocity);
                assert_eq!(planned.is_ok(), passes, "{kind:?}: {planned:?}");
            }
        }
    }
}

/// A linear plate is passed once: what lies behind the master does not count, however long the plate.
#[test]
fn a_narrow_peak_behind_the_master_of_a_linear_plate_does_not_count() {
    let tables = tables_with(plate(&after_rests(299, 0.3), Course::Linear));
    for (position, velocity, passes) in [
        (100.0, 21.0, false),
        (110.0, 21.0, true),
        (110.0, -21.0, false),
        (100.0, -21.0, true),
    ] {
        let later = Activation::at(ActivationMode::AtMasterAxisPos, 1e6 * velocity);
        let planned = plan_within(60_000.0, later, &tables, position, velocity);
        assert_eq!(
            planned.is_ok(),
            passes,
            "{position}, {velocity}: {planned:?}"
        );
    }
}

/// Two plates with peaks that only together are too great, in the same narrow place.
#[test]
fn the_peaks_of_several_plates_add_up() {
    let points = [(0.0, 0.0), (102.3, 0.0), (103.5, 10.0), (360.0, 0.0)];
    let mut rig = Rig::new();
    for id in [30, 31] {
        rig.tables
            .insert(id, plate(&points, Course::Cyclic))
            .expect("room");
    }
    rig.coupling = CamCoupling::new(CouplingParameters {
        master_axis_id: 7,
        slave_axis_id: 8,
        limits: CamLimits {
            velocity: 2_000.0,
            acceleration: 60_000.0,
            deceleration: 60_000.0,
            jerk: 1e9,
            cycle: 0.001,
        },
    })
    .expect("parameters");
    rig.go(-0.03);
    let add = |table, velocity: f64, rig: &mut Rig| {
        rig.master.velocity = velocity;
        let request = CamRequest::from(CamInV2 {
            table,
            ..CamInV2::default()
        });
        rig.start(request)
    };
    // 40.1 · v² for one of them, 60 000 u/s² for both at 27.4 u/s.
    add(30, 30.0, &mut rig).expect("one is slow enough");
    rig.go(0.0);
    rig.master.velocity = 30.0;
    let second = CamRequest::from(CamAdd {
        table: 31,
        ..CamAdd::default()
    });
    let refused = rig.start(second).expect_err("both are not");
    assert!(
        matches!(refused, CouplingError::BeyondLimits { .. }),
        "{refused}"
    );
}
