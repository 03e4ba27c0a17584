//! Changes of cam plates that the axis cannot follow: refused, with figures, and never an error stop.

use super::cams::plate;
use super::*;
use crate::JobError;
use coaxle_axis::{AxisStatus, CommandState};
use coaxle_cam::{
    Activation, ActivationMode, AxisScaling, CamIn, CamScaling, JumpHandling, ScalingData,
    ScalingMode, Tables,
};
use std::string::{String, ToString};

/// An axis at `slave` with the plates 1 (up to 40 u), 2 (up to 30 u) and 3 (up to 400 u), all over
/// 200 u, and a master.
fn rig(slave: f64, velocity: f64) -> (AxisWithPlates, Master) {
    let mut axis = powered(&PARAMETERS);
    let mut tables = Tables::new(3);
    for (id, top) in [(1, 40.0), (2, 30.0), (3, 400.0)] {
        tables.insert(id, plate(top)).expect("room");
    }
    axis.select_cams(tables, 7, 8).expect("limits");
    if slave != 0.0 {
        start(&mut axis, &move_absolute(slave));
        run(&mut axis, 3_000);
    }
    let mut master = Master::at(-20.0, velocity);
    master.lead(&mut axis, 1);
    (axis, master)
}

fn next_cycle(table: u32) -> CamIn {
    CamIn {
        table,
        activation: Activation::new(ActivationMode::NextCycle),
        ..CamIn::default()
    }
}

/// Leads the axis, which never fails, and keeps its limits in its differences.
fn lead(axis: &mut AxisWithPlates, master: &mut Master, cycles: u32) {
    let mut differences = Differences::of(axis);
    for _ in 0..cycles {
        master.lead(axis, 1);
        differences.keep(axis, &PARAMETERS);
        assert_eq!(axis.error(), None);
    }
}

/// Coupled by the first plate, in the middle of its rise.
fn rising() -> (AxisWithPlates, Master) {
    let (mut axis, mut master) = rig(0.0, 200.0);
    let job = start(&mut axis, &Command::CamIn(next_cycle(1)));
    lead(&mut axis, &mut master, 350);
    assert_eq!(axis.progress(job), CommandState::InSync);
    assert!(axis.set().velocity > 100.0, "{:?}", axis.set());
    (axis, master)
}

/// Asserts a refusal, by dry run and by command, with its code; returns its text. The axis is unchanged.
fn refused(axis: &mut AxisWithPlates, command: &Command, code: u32) -> String {
    let planned = axis.plan(command).unwrap_err();
    let refused = axis.command(command).unwrap_err();
    assert_eq!(planned, refused);
    assert_eq!(refused.code(), code, "{refused}");
    refused.to_string()
}

#[test]
fn a_plate_that_is_a_little_off_is_no_small_jump() {
    // 0.9 u in a cycle of 1 ms are within 1000 u/s, but impossible for the axis.
    for off in [0.9, 0.01, 1e-4] {
        let (mut axis, mut master) = rig(off, 0.0);
        let at_once = CamIn {
            activation: Activation::default(),
            master_offset: 20.0,
            ..next_cycle(1)
        };
        let text = refused(&mut axis, &Command::CamIn(at_once), 0x421a);
        assert!(text.contains("expected at most 1.66667e-5 u"), "{text}");
        master.0.velocity = 200.0;
        let job = start(&mut axis, &Command::CamIn(next_cycle(1)));
        lead(&mut axis, &mut master, 300);
        let CommandState::Failed(JobError::Refused(refusal)) = axis.progress(job) else {
            panic!("{:?}", axis.progress(job));
        };
        assert_eq!(refusal.code(), 0x421a);
        assert_eq!(axis.status(), AxisStatus::Standstill);
    }
    let (mut axis, mut master) = rig(1e-5, 200.0);
    let job = start(&mut axis, &Command::CamIn(next_cycle(1)));
    lead(&mut axis, &mut master, 2_000);
    assert_eq!(axis.progress(job), CommandState::InSync);
}

#[test]
fn another_plate_with_another_slope_is_a_jump_of_the_velocity() {
    let (mut axis, mut master) = rising();
    let other = CamIn {
        activation: Activation::default(),
        slave_scaling_mode: ScalingMode::AutoOffset,
        ..next_cycle(2)
    };
    let text = refused(&mut axis, &Command::CamIn(other), 0x421a);
    assert!(text.contains("velocity would jump by -"), "{text}");
    lead(&mut axis, &mut master, 2_000);
    // At the transition of the cycles, both are at rest.
    let job = start(&mut axis, &Command::CamIn(next_cycle(2)));
    lead(&mut axis, &mut master, 2_000);
    assert_eq!(axis.progress(job), CommandState::InSync);
}

#[test]
fn a_scaling_in_motion_is_a_jump_of_the_velocity() {
    let (mut axis, mut master) = rising();
    let scaling = |jump| {
        Command::CamScaling(CamScaling {
            scaling: ScalingData {
                slave: AxisScaling {
                    mode: ScalingMode::AutoOffset,
                    scaling: 2.0,
                    ..AxisScaling::default()
                },
                ..ScalingData::default()
            },
            jump,
            ..CamScaling::default()
        })
    };
    refused(&mut axis, &scaling(JumpHandling::Refuse), 0x421a);
    let short = JumpHandling::RampIn { master_length: 1.0 };
    let text = refused(&mut axis, &scaling(short), 0x42dd);
    assert!(text.contains("a longer ramp"), "{text}");
    let job = start(
        &mut axis,
        &scaling(JumpHandling::RampIn {
            master_length: 60.0,
        }),
    );
    lead(&mut axis, &mut master, 2_000);
    assert_eq!(axis.progress(job), CommandState::Done);
}

#[test]
fn a_ramp_over_too_short_a_way_is_refused() {
    for (master_length, passes) in [(2.0, false), (20.0, false), (150.0, true)] {
        let (mut axis, mut master) = rig(15.0, 200.0);
        let command = Command::CamIn(CamIn {
            activation: Activation::default(),
            jump: JumpHandling::RampIn { master_length },
            ..next_cycle(1)
        });
        if passes {
            let job = start(&mut axis, &command);
            lead(&mut axis, &mut master, 2_000);
            assert_eq!(axis.progress(job), CommandState::InSync);
        } else {
            refused(&mut axis, &command, 0x42dd);
        }
    }
}

#[test]
fn a_plate_beyond_the_limits_is_refused() {
    let (mut axis, mut master) = rig(0.0, 200.0);
    // 400 u over 100 u of the master: 1500 u/s and 5.77·400·2² u/s² at 200 u/s.
    let text = refused(&mut axis, &Command::CamIn(next_cycle(3)), 0x42dd);
    assert!(
        text.contains("expected at most") && text.contains("lead it at up to"),
        "{text}"
    );
    // A master that becomes too fast while it waits is detected when it is due.
    master.0.velocity = 50.0;
    master.lead(&mut axis, 1);
    let job = start(&mut axis, &Command::CamIn(next_cycle(3)));
    master.0.velocity = 200.0;
    lead(&mut axis, &mut master, 1_000);
    assert!(matches!(
        axis.progress(job),
        CommandState::Failed(JobError::Refused(_))
    ));
    assert_eq!(axis.status(), AxisStatus::Standstill);
}
