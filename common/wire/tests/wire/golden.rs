//! Names and texts that others rely on, as reviewed tables: the spelling of commands and responses on the
//! wire, and the texts of refusals and faults, with their NC codes.
//!
//! The names that serde gives are the wire format. A snapshot that changes here changes
//! `docs/WIRE.md` and every client.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use std::fmt::{Display, Write as _};

use crate::document::section;
use coaxle_axis::drive::DriveFault;
use coaxle_axis::guard::{GuardFault, GuardRefusal};
use coaxle_axis::{Awaits, AxisStatus, Transition};
use coaxle_cam::{
    ActivationMode, CouplingError, JumpHandling, OperationMode, ScalingMode, StartMode,
};
use coaxle_curve::law::MotionLaw;
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_gear::{FlyingGearError, RatioZero};
use coaxle_plate::PointType;
use coaxle_saw::{
    CouplingMoment, GearInSyncMode, LimitGuard, SawFault, SawRefusal, SlaveLimits, SyncMask,
};
use coaxle_slave::{
    CouplingFault, CouplingPhase, CouplingRefusal, OnMasterLoss, Refusal, SlaveError,
};
use coaxle_wire::command::{
    CommandAnswer, CommandOrder, CommandOutcome, FarName, MAX_KNOWN, NotTaken, SawAttempt, SawView,
    SlaveName, SlaveOrder, SlaveView,
};
use serde::Serialize;

/// Returns the examples of `docs/WIRE.md`, which has one of every command.
fn documented_commands() -> impl Iterator<Item = &'static str> {
    let commands = section("\n## Commands\n");
    let (_, table) = commands.split_once("### What a slave can be told").unwrap();
    let rows = table.lines().filter(|line| line.starts_with("| `{"));
    rows.map(|row| row.split('`').nth(1).unwrap())
}

fn any_order(command: &str) -> CommandOrder {
    let text = format!(r#"{{ "version": 1, "slave": "s", "command": {command} }}"#);
    CommandOrder::from_json(text.as_bytes()).unwrap()
}

fn order(command: &str) -> SlaveOrder {
    match any_order(command) {
        CommandOrder::Slave(order) => order,
        other => panic!("{other:?}"),
    }
}

/// Every field of every command, those left out in the document too.
#[test]
fn commands() {
    let mut lines = String::new();
    for command in documented_commands() {
        writeln!(lines, "{}", any_order(command).to_json()).unwrap();
    }
    insta::assert_snapshot!(lines);
}

/// Writes spelling of the values of an enumeration.
fn spelled<T: Serialize>(lines: &mut String, name: &str, values: &[T]) {
    let values: Vec<_> = values
        .iter()
        .map(|value| serde_json::to_string(value).unwrap())
        .collect();
    writeln!(lines, "{name}: {}", values.join(" ")).unwrap();
}

/// Values of the enumerations in commands and responses.
#[test]
fn enumerations() {
    let mut lines = String::new();
    let lines_of = &mut lines;
    spelled(lines_of, "activation mode", &ActivationMode::ALL);
    spelled(
        lines_of,
        "scaling mode",
        &[
            ScalingMode::UserDefined,
            ScalingMode::AutoOffset,
            ScalingMode::Off,
        ],
    );
    spelled(
        lines_of,
        "start mode",
        &[
            StartMode::Absolute,
            StartMode::Relative,
            StartMode::MasterAbsoluteSlaveRelative,
            StartMode::MasterRelativeSlaveAbsolute,
        ],
    );
    spelled(
        lines_of,
        "operation mode",
        &[
            OperationMode::Default,
            OperationMode::Additive,
            OperationMode::Exchange,
            OperationMode::Remove,
        ],
    );
    let master_length = 90.0;
    spelled(
        lines_of,
        "jump",
        &[
            JumpHandling::Refuse,
            JumpHandling::Allow,
            JumpHandling::RampIn { master_length },
        ],
    );
    spelled(lines_of, "law", MotionLaw::ALL);
    spelled(lines_of, "point type", &PointType::ALL);
    spelled(
        lines_of,
        "sync mode",
        &[GearInSyncMode::PositionBased, GearInSyncMode::TimeBased],
    );
    spelled(lines_of, "sync mask", &[SyncMask::all()]);
    spelled(
        lines_of,
        "on master loss",
        &[OnMasterLoss::Stop, OnMasterLoss::QuickStop],
    );
    spelled(lines_of, "status", &AxisStatus::ALL);
    spelled(
        lines_of,
        "coupling phase",
        &[
            CouplingPhase::Waiting,
            CouplingPhase::Synchronizing,
            CouplingPhase::InSync,
            CouplingPhase::Releasing,
            CouplingPhase::Released,
        ],
    );
    insta::assert_snapshot!(lines);
}

const STANDING: SlaveView = SlaveView {
    status: AxisStatus::Standstill,
    coupling: None,
    position: 1.5,
    velocity: 0.0,
};

const FOLLOWING: SlaveView = SlaveView {
    status: AxisStatus::SynchronizedMotion,
    coupling: Some(CouplingPhase::InSync),
    position: 812.25,
    velocity: 250.0,
};

const SAW: &str = r#"{ "gear-in-pos": {
    "ratio": { "numerator": 1.0 }, "master-sync-position": 100.0, "slave-sync-position": 50.0 } }"#;

/// Returns a saw at rest beside a master of this speed, u/s.
fn beside(master_speed: f64) -> CouplingMoment {
    CouplingMoment {
        master: Kinematics {
            velocity: master_speed,
            ..Kinematics::default()
        },
        encoder: None,
        slave: Kinematics::default(),
        axis: SlaveLimits {
            dynamics: Limits::new(2000.0, 5000.0, 5000.0, 1e6).unwrap(),
            min_position: None,
            max_position: None,
            guard: Some(LimitGuard { reserve: 0.01 }),
        },
    }
}

/// Response of each kind.
#[test]
fn answers() {
    let (slow, fast) = (beside(100.0), beside(1000.0));
    let saw = order(SAW).command.as_saw().unwrap();
    let plan = saw.plan(&slow).unwrap();
    let view = |axis_id| Some(SawView { plan, axis_id });
    let mut far_known = [None; MAX_KNOWN];
    far_known[0] = Some(FarName::new("conveyor").unwrap());
    let mut known = [None; MAX_KNOWN];
    known[0] = Some(SlaveName::new("carriage").unwrap());
    let mut lines = String::new();
    let mut answer = |command: &str, dry_run: bool, outcome: CommandOutcome| {
        let order = CommandOrder::from(SlaveOrder {
            dry_run,
            ..order(command)
        });
        writeln!(lines, "{}", CommandAnswer::new(&order, &outcome).to_json()).unwrap();
    };
    let accepted = |job, slave, saw| CommandOutcome::Accepted {
        job,
        awaits: Awaits::empty(),
        slave,
        sync_positions: None,
        saw,
    };
    let job = Some(7);
    answer(r#"{"power":true}"#, false, accepted(None, STANDING, None));
    answer(r#"{"gear-out":{}}"#, false, accepted(job, FOLLOWING, None));
    answer(r#"{"gear-out":{}}"#, true, accepted(job, FOLLOWING, None));
    answer(SAW, false, accepted(job, FOLLOWING, view(3)));
    answer(
        r#"{"read-flying-saw-characteristics":{}}"#,
        false,
        accepted(None, FOLLOWING, view(3)),
    );
    answer(
        SAW,
        true,
        CommandOutcome::Refused {
            refusal: coupling(saw.plan(&fast).unwrap_err()),
            slave: STANDING,
            saw: Some(SawAttempt {
                command: saw,
                moment: fast,
            }),
        },
    );
    for refusal in refusals() {
        answer(
            r#"{"gear-out":{}}"#,
            false,
            CommandOutcome::Refused {
                refusal,
                slave: FOLLOWING,
                saw: None,
            },
        );
    }
    for reason in [
        NotTaken::NoSlaves,
        NotTaken::UnknownSlave {
            received: SlaveName::new("cariage").unwrap(),
            known,
        },
        NotTaken::NoFarNodes,
        NotTaken::UnknownFarNode {
            received: FarName::new("conveyer").unwrap(),
            known: far_known,
        },
        NotTaken::Busy,
        NotTaken::NoAnswer,
        NotTaken::Stopped,
    ] {
        answer(
            r#"{"gear-out":{}}"#,
            false,
            CommandOutcome::NotTaken(reason),
        );
    }
    insta::assert_snapshot!(lines);
}

fn coupling(refusal: impl Into<CouplingRefusal>) -> Refusal {
    Refusal::Coupling(refusal.into())
}

/// Returns a refusal of each kind.
fn refusals() -> Vec<Refusal> {
    let command = "MC_GearOut";
    let status = |status, transition| Refusal::Status {
        command,
        transition,
        status,
    };
    vec![
        status(AxisStatus::Disabled, Transition::Move),
        status(AxisStatus::Stopping, Transition::Halt),
        status(AxisStatus::ErrorStop, Transition::Couple),
        status(AxisStatus::Standstill, Transition::Uncouple),
        status(AxisStatus::Homing, Transition::MoveWithoutEnd),
        Refusal::NotAtRest { velocity: 2.5 },
        GuardRefusal::Value {
            field: "distance",
            received: 1e13,
            expected: "a number of at most 1e12",
        }
        .into(),
        GuardRefusal::AboveLimit {
            field: "velocity",
            received: 900.0,
            limit: 500.0,
        }
        .into(),
        GuardRefusal::SoftwareLimit {
            reached: 1200.0,
            limit: 1000.0,
        }
        .into(),
        Refusal::NoMaster,
        Refusal::FollowsItself {
            command: "MC_GearIn",
        },
        coupling(RatioZero {
            ratio: 0.0,
            offset: 0.0,
        }),
        coupling(FlyingGearError::MasterPastStart {
            master: 12.0,
            start: 10.0,
        }),
        coupling(CouplingError::TableUnknown { table: 9 }),
        coupling(SawRefusal::TimeBasedPosition),
        Refusal::NoCharacteristics,
    ]
}

fn coded(lines: &mut String, code: u32, text: &dyn Display) {
    writeln!(lines, "{code:#06x} | {text}").unwrap();
}

/// Faults that bring a slave to an error stop, by their NC codes.
#[test]
fn faults() {
    let mut lines = String::new();
    for error in [
        DriveFault::FollowingError {
            following_error: 1.25,
        }
        .into(),
        DriveFault::NotAttached.into(),
        DriveFault::NotReady { cycles: 1000 }.into(),
        DriveFault::Silent {
            cycles: 21,
            most: 20,
        }
        .into(),
        DriveFault::Reported { error: 0x8611 }.into(),
        DriveFault::PowerLost.into(),
        DriveFault::PositionMismatch {
            received: 5000.0,
            expected: 1000.0,
            window: 5.0,
        }
        .into(),
        DriveFault::UnknownState { received: 7 }.into(),
        DriveFault::Implausible {
            field: "actual position",
            received: f64::NAN,
        }
        .into(),
        SlaveError::MasterLost,
        SlaveError::FollowsItself,
        GuardFault::SoftwareLimit {
            reached: 1200.0,
            limit: 1000.0,
        }
        .into(),
        GuardFault::OutOfRange {
            quantity: "set position",
            received: 1e13,
        }
        .into(),
        GuardFault::LeftBehind {
            distance: -12.5,
            window: 10.0,
        }
        .into(),
        CouplingFault::Cam(CouplingError::NotCoupled).into(),
        CouplingFault::Saw(SawFault::Refused(SawRefusal::TimeBasedPosition)).into(),
    ] {
        coded(&mut lines, error.code(), &error);
    }
    insta::assert_snapshot!(lines);
}
