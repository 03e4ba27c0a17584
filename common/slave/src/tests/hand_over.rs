//! Hand-over from any motion to any other: position, velocity and acceleration are continuous.

use super::saws::{beside, to_position};
use super::*;
use coaxle_axis::{AxisStatus, CommandState};
use coaxle_gear::{GearInMultiMaster, MultiMasterSync, Ratios};
use coaxle_saw::{GearInPos, GearInVelo, Ratio, SyncLimits, SyncMask, SyncMode, SyncStrategy};

const SUCCESSORS: usize = 16;

/// Successors of a saw.
fn successors(master: &Master, axis: &AxisWithPlates) -> [Command; SUCCESSORS] {
    let here = (master.0.position, axis.set().position);
    let further = GearInPos {
        ratio: Ratio::of(1.0),
        ..to_position((here.0 + 600.0, here.1 + 600.0), SyncMask::empty())
    };
    let by = |strategy| {
        Command::from(GearInPos {
            strategy: Some(strategy),
            ..further
        })
    };
    let to_velocity = |sync_mode| {
        Command::GearInVelo(GearInVelo {
            ratio: Ratio::of(0.5),
            sync_mode,
            limits: SyncLimits::default(),
        })
    };
    [
        HALT,
        STOP,
        Command::Power(false),
        move_absolute(here.1),
        Command::MoveRelative {
            distance: 300.0,
            velocity: None,
            dynamics: OWN,
        },
        move_velocity(-300.0),
        Command::GearIn(GearIn::of(-0.7)),
        Command::GearInMultiMaster(GearInMultiMaster {
            ratios: Ratios::new(&[1.5]).expect("a ratio"),
            dynamics: OWN,
            sync_mode: MultiMasterSync::PosSync1,
        }),
        Command::GearInMultiMaster(GearInMultiMaster {
            ratios: Ratios::new(&[1.5]).expect("a ratio"),
            dynamics: OWN,
            sync_mode: MultiMasterSync::PosSync2,
        }),
        Command::from(further),
        Command::from(GearInPos {
            master_start_distance: Some(500.0),
            ..further
        }),
        by(SyncStrategy::Late),
        by(SyncStrategy::Slow),
        by(SyncStrategy::Early),
        to_velocity(SyncMode::position_based(SyncMask::empty())),
        to_velocity(SyncMode::time_based(SyncMask::empty())),
    ]
}

/// Starts a saw that is led to its master within every limit.
fn saw(axis: &mut AxisWithPlates, master: &Master) {
    let sync = (master.0.position + 400.0, axis.set().position + 150.0);
    let command = to_position(sync, SyncMask::MAX_DYNAMICS);
    start(axis, &Command::from(command));
}

#[test]
fn a_saw_is_taken_over_at_any_moment_within_the_jerk() {
    let parameters = PARAMETERS;
    let mut accepted = [0; SUCCESSORS];
    for (which, accepted) in accepted.iter_mut().enumerate() {
        for moment in (1..1_900).step_by(97) {
            let (mut axis, mut master) = beside(&parameters, 200.0);
            let mut differences = Differences::of(&axis);
            let mut lead = |axis: &mut AxisWithPlates, master: &mut Master, cycles| {
                for _ in 0..cycles {
                    master.lead(axis, 1);
                    if axis.status() == AxisStatus::Disabled {
                        break;
                    }
                    if let Err(why) = differences.check(axis, &parameters) {
                        panic!("{which} after {moment}: {why}");
                    }
                }
            };
            lead(&mut axis, &mut master, 5);
            saw(&mut axis, &master);
            lead(&mut axis, &mut master, moment);
            let command = successors(&master, &axis)[which];
            if axis.command(&command).is_ok() {
                *accepted += 1;
            }
            lead(&mut axis, &mut master, 1_500);
            assert_eq!(axis.error(), None, "{command:?} after {moment}");
        }
    }
    assert!(accepted.iter().all(|&count| count > 3), "{accepted:?}");
}

#[test]
fn gear_out_leads_the_acceleration_to_zero() {
    for moment in (100..1_900).step_by(41) {
        let (mut axis, mut master) = beside(&PARAMETERS, 200.0);
        let mut differences = Differences::of(&axis);
        saw(&mut axis, &master);
        for _ in 0..moment {
            master.lead(&mut axis, 1);
            differences.keep(&axis, &PARAMETERS);
        }
        let velocity = axis.set().velocity;
        let out = start(&mut axis, &Command::GearOut {});
        assert_eq!(axis.progress(out), CommandState::Done);
        for _ in 0..200 {
            master.lead(&mut axis, 1);
            differences.keep(&axis, &PARAMETERS);
        }
        assert_eq!(
            (axis.set().velocity, axis.set().acceleration),
            (velocity, 0.0)
        );
    }
}
