//! TF5050 chapter 8.3, mode by operation: modes that the manual allows take effect at the right place,
//! all others are refused.

mod multi;

use std::format;

use super::*;
use ActivationMode::{
    AsSoonAsPossible, AtMasterAxisPos, AtMasterAxisPosNegativeDirection,
    AtMasterAxisPosPositiveDirection, AtMasterCamPos, DeleteQueuedData, Instantaneous, NextCycle,
    NextCycleOnce, Off,
};

/// Effect of a mode with an operation.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ActivationEffect {
    /// Takes effect where the master, led from 100 up, reaches this position; for downward modes, from
    /// there down.
    At(f64),
    /// Takes effect at 360 and returns a cycle later.
    Once,
    /// Accepted; nothing changes.
    Nothing,
    /// Refused with this code.
    No(u32),
}
use ActivationEffect::{At, No, Nothing, Once};

/// The activation position, where one is needed: a quarter of a cycle beyond the master.
const POSITION: f64 = 190.0;

#[rustfmt::skip]
const MANUAL: [(ActivationMode, ActivationEffect, ActivationEffect, ActivationEffect, ActivationEffect); 10] = [
    // mode                            couple      switch      scale       online change
    (Instantaneous,                    At(100.0),  At(100.0),  At(100.0),  At(100.0)),
    (AtMasterCamPos,                   At(190.0),  At(190.0),  At(190.0),  At(190.0)),
    (AtMasterAxisPos,                  At(190.0),  At(190.0),  At(190.0),  At(190.0)),
    (NextCycle,                        At(360.0),  At(360.0),  At(360.0),  At(360.0)),
    (NextCycleOnce,                    Once,       Once,       Once,       Once),
    (AsSoonAsPossible,                 No(0x4B04), No(0x4B04), No(0x4B04), At(180.0)),
    (Off,                              No(0x4B04), No(0x4B04), Nothing,    Nothing),
    (DeleteQueuedData,                 No(0x4B04), Nothing,    No(0x4B04), Nothing),
    (AtMasterAxisPosPositiveDirection, At(190.0),  At(190.0),  No(0x4B04), No(0x4283)),
    (AtMasterAxisPosNegativeDirection, At(40.0),   At(40.0),   No(0x4B04), No(0x4283)),
];

/// Returns the activation position: downwards another one is passed.
fn position(mode: ActivationMode) -> f64 {
    if mode == AtMasterAxisPosNegativeDirection {
        40.0
    } else {
        POSITION
    }
}

#[test]
fn the_rules_are_those_of_the_table() {
    for (mode, couple, switch, scale, online) in MANUAL {
        let operations = [
            (Operation::Couple, couple),
            (Operation::Switch, switch),
            (Operation::Scale, scale),
            (Operation::OnlineChange, online),
        ];
        for (operation, is) in operations {
            assert_eq!(
                operation.allows(mode),
                !matches!(is, No(_)),
                "{mode:?} {operation:?}"
            );
        }
    }
}

/// Leads the master from 100 and compares the slave with the old course and the new one all along.
fn follow(
    rig: &mut Rig,
    is: ActivationEffect,
    cycle: f64,
    name: &str,
    old: impl Fn(&Rig, f64) -> f64,
    new: impl Fn(&Rig, f64) -> f64,
) {
    // To 750, beyond two seams, in steps that meet all positions of the table exactly.
    let mut up: Vec<f64> = (0..=260).map(|i| 100.0 + 2.5 * f64::from(i)).collect();
    if let At(at) = is
        && at < 100.0
    {
        // To 10: above the seam at 0, which would be another cycle.
        up = (0..=36).map(|i| 100.0 - 2.5 * f64::from(i)).collect();
    }
    for (step, &master) in up.iter().enumerate() {
        let slave = rig.go(master);
        let changed = match is {
            At(at) if at < 100.0 => master <= at,
            At(at) => master >= at && (step > 0 || at == 100.0),
            Once => (360.0..360.0 + cycle).contains(&master),
            Nothing | No(_) => false,
        };
        let expected = if changed {
            new(rig, master)
        } else {
            old(rig, master)
        };
        assert!(
            (slave - expected).abs() < 1e-9,
            "{name} at {master}: {slave}, expected {expected}"
        );
    }
}

#[test]
fn couple() {
    for (mode, is, ..) in MANUAL {
        let mut rig = Rig::new();
        rig.master.position = 100.0;
        rig.slave.position = 3.0;
        let started = rig.start(CamRequest::from(CamIn {
            activation: activation(mode, position(mode)),
            jump: JumpHandling::Allow,
            ..cam_in(BACK_AND_FORTH)
        }));
        if let No(code) = is {
            assert_eq!(started.unwrap_err().code(), code, "{mode:?}");
            assert_eq!(rig.coupling.state(), CommandState::Idle);
            continue;
        }
        let ticket = started.unwrap();
        if is == Once {
            // There is no previous plate to return to: the coupling lasts one cycle.
            rig.lead(359.0, 2.5);
            assert_eq!(rig.state(ticket), CommandState::Waiting);
            rig.lead(700.0, 2.5);
            assert_near(rig.slave.position, rig.raw(BACK_AND_FORTH, 700.0));
            assert_eq!(rig.state(ticket), CommandState::InSync);
            rig.lead(730.0, 2.5);
            assert_eq!(rig.coupling.state(), CommandState::Idle);
            assert_eq!(rig.state(ticket), CommandState::Done);
            assert_eq!(
                rig.slave,
                Kinematics::at_rest(rig.raw(BACK_AND_FORTH, 720.0))
            );
            continue;
        }
        let cam = |rig: &Rig, master| rig.raw(BACK_AND_FORTH, master);
        follow(&mut rig, is, 360.0, &format!("{mode:?}"), |_, _| 3.0, cam);
        assert_eq!(rig.state(ticket), CommandState::InSync);
    }
}

#[test]
fn switch() {
    for (mode, _, is, ..) in MANUAL {
        let mut rig = Rig::coupled(BACK_AND_FORTH);
        rig.lead(100.0, 1.0);
        let started = rig.start(CamRequest::from(CamIn {
            activation: activation(mode, position(mode)),
            jump: JumpHandling::Allow,
            ..cam_in(SMALL)
        }));
        if let No(code) = is {
            assert_eq!(started.unwrap_err().code(), code, "{mode:?}");
            continue;
        }
        let queued = rig.coupling.state_word(&rig.tables);
        assert_eq!(
            queued.contains(coaxle_axis::StateWord::CAM_TABLE_QUEUED),
            is != Nothing,
            "{mode:?}"
        );
        let old = |rig: &Rig, master| rig.raw(BACK_AND_FORTH, master);
        let new = |rig: &Rig, master| rig.raw(SMALL, master);
        follow(&mut rig, is, 180.0, &format!("{mode:?}"), old, new);
        let expected = if is == Once {
            CommandState::Done
        } else {
            CommandState::InSync
        };
        assert_eq!(rig.state(started.unwrap()), expected);
        assert!(rig.coupling.state_word(&rig.tables).is_empty());
    }
}

#[test]
fn scale() {
    for (mode, _, _, is, _) in MANUAL {
        let mut rig = Rig::coupled(BACK_AND_FORTH);
        rig.lead(100.0, 1.0);
        let started = rig.start(CamRequest::from(CamScaling {
            activation: activation(mode, position(mode)),
            scaling: ScalingData {
                slave: AxisScaling {
                    scaling: 3.0,
                    ..AxisScaling::default()
                },
                ..ScalingData::default()
            },
            jump: JumpHandling::Allow,
        }));
        if let No(code) = is {
            assert_eq!(started.unwrap_err().code(), code, "{mode:?}");
            continue;
        }
        let queued = rig.coupling.state_word(&rig.tables);
        assert_eq!(
            queued.contains(coaxle_axis::StateWord::CAM_SCALING_PENDING),
            is != Nothing,
            "{mode:?}"
        );
        let old = |rig: &Rig, master| rig.raw(BACK_AND_FORTH, master);
        let new = |rig: &Rig, master| 3.0 * rig.raw(BACK_AND_FORTH, master);
        follow(&mut rig, is, 360.0, &format!("{mode:?}"), old, new);
        assert_eq!(rig.state(started.unwrap()), CommandState::Done, "{mode:?}");
    }
}

#[test]
fn online_change() {
    let changed = plate(
        &[(0.0, 0.0), (180.0, 50.0), (270.0, 20.0), (360.0, 0.0)],
        Course::Cyclic,
    );
    for (mode, _, _, _, is) in MANUAL {
        let mut rig = Rig::new();
        let four = [(0.0, 0.0), (90.0, 30.0), (180.0, 50.0), (360.0, 0.0)];
        let before = plate(&four, Course::Cyclic);
        rig.tables.insert(9, before.clone()).unwrap();
        rig.start(CamRequest::from(cam_in(9))).unwrap();
        rig.lead(100.0, 1.0);
        let set = rig.tables.set_online_change_mode(
            9,
            OnlineChangeMode {
                activation: activation(mode, position(mode)),
                jump: JumpHandling::Allow,
                ..OnlineChangeMode::default()
            },
        );
        if let No(code) = is {
            assert_eq!(set.unwrap_err().code(), code, "{mode:?}");
            continue;
        }
        set.unwrap();
        // The discarding mode is not for writing, so the points are written before.
        let points = if mode == AsSoonAsPossible {
            // Only the first half changes, and that is where the slave is.
            std::vec![rest(2, 90.0, 25.0)]
        } else {
            std::vec![rest(2, 180.0, 50.0), rest(3, 270.0, 20.0)]
        };
        if mode == DeleteQueuedData {
            let next = OnlineChangeMode {
                activation: Activation::new(NextCycle),
                ..OnlineChangeMode::default()
            };
            rig.tables.set_online_change_mode(9, next).unwrap();
        }
        rig.tables.write(9, &points).unwrap();
        let is_queued = |rig: &Rig| {
            let word = rig.coupling.state_word(&rig.tables);
            word.contains(coaxle_axis::StateWord::CAM_DATA_QUEUED)
        };
        assert_eq!(is_queued(&rig), mode != Off, "{mode:?}");
        if mode == DeleteQueuedData {
            let delete = OnlineChangeMode {
                activation: Activation::new(DeleteQueuedData),
                ..OnlineChangeMode::default()
            };
            rig.tables.set_online_change_mode(9, delete).unwrap();
            assert!(!is_queued(&rig));
        }
        let new = if mode == AsSoonAsPossible {
            plate(
                &[(0.0, 0.0), (90.0, 25.0), (180.0, 50.0), (360.0, 0.0)],
                Course::Cyclic,
            )
        } else {
            changed.clone()
        };
        follow(
            &mut rig,
            is,
            360.0,
            &format!("{mode:?}"),
            |_, master| before.at(master).position,
            |_, master| new.at(master).position,
        );
        assert!(!is_queued(&rig));
    }
}

#[test]
fn a_linear_plate_has_no_next_cycle_except_to_switch_at_its_edges() {
    let mode = Activation::new(NextCycle);
    let refused = Rig::new().start(CamRequest::from(CamIn {
        activation: mode,
        ..cam_in(LINEAR)
    }));
    assert_eq!(refused.unwrap_err().code(), 0x4283);

    for (from, to) in [(40.0, 130.0), (40.0, -30.0)] {
        let mut rig = Rig::coupled(LINEAR);
        rig.lead(from, 1.0);
        let scaling = CamRequest::from(CamScaling {
            activation: mode,
            ..CamScaling::default()
        });
        assert_eq!(rig.start(scaling).unwrap_err().code(), 0x4283);
        rig.start(CamRequest::from(CamIn {
            activation: mode,
            jump: JumpHandling::Allow,
            ..cam_in(SMALL)
        }))
        .unwrap();
        rig.lead(if to > from { 99.0 } else { 1.0 }, 1.0);
        assert_near(rig.slave.position, rig.raw(LINEAR, rig.master.position));
        rig.lead(to, 1.0);
        assert_near(rig.slave.position, rig.raw(SMALL, to));
    }

    let mut rig = Rig::new();
    let set = rig.tables.set_online_change_mode(
        LINEAR,
        OnlineChangeMode {
            activation: mode,
            ..OnlineChangeMode::default()
        },
    );
    assert_eq!(set.unwrap_err().code(), 0x4283);
}

#[test]
fn a_direction_counts_only_its_own_passes() {
    let mut rig = Rig::new();
    rig.master.position = 100.0;
    let ticket = rig
        .start(CamRequest::from(CamIn {
            activation: activation(AtMasterAxisPosPositiveDirection, 90.0),
            jump: JumpHandling::Allow,
            ..cam_in(BACK_AND_FORTH)
        }))
        .unwrap();
    rig.lead(80.0, 1.0);
    assert_eq!(rig.state(ticket), CommandState::Waiting);
    rig.lead(95.0, 1.0);
    assert_eq!(rig.state(ticket), CommandState::InSync);
}

#[test]
fn a_master_on_the_position_is_enough() {
    for mode in [AtMasterAxisPos, AtMasterCamPos] {
        let mut rig = Rig::new();
        rig.master.position = 360.0;
        // 360 of the axis is 0 on the plate.
        let position = if mode == AtMasterCamPos { 0.0 } else { 360.0 };
        let ticket = rig
            .start(CamRequest::from(CamIn {
                activation: activation(mode, position),
                ..cam_in(BACK_AND_FORTH)
            }))
            .unwrap();
        rig.go(360.0);
        assert_eq!(rig.state(ticket), CommandState::InSync, "{mode:?}");
    }
}
