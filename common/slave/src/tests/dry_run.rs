//! A dry run gives the result of the command, without a trace.

use proptest::prelude::*;
use std::{format, vec};

use super::*;
use coaxle_axis::Origin;
use coaxle_saw::{GearInPos, GearInVelo, Ratio, SyncLimits, SyncMask, SyncMode};

fn commands() -> impl Strategy<Value = Command> {
    prop_oneof![
        any::<bool>().prop_map(Command::Power),
        Just(Command::Power(true)),
        Just(Command::Reset {}),
        (-200.0..1_200.0).prop_map(move_absolute),
        (-1_200.0..1_200.0).prop_map(move_velocity),
        Just(HALT),
        Just(Command::Stop { dynamics: OWN }),
        (-2.0..2.0).prop_map(|ratio| Command::GearIn(GearIn::of(ratio))),
        Just(Command::GearOut {}),
        Just(Command::ReadFlyingSawCharacteristics {}),
        (1.0..500.0, -200.0..500.0).prop_map(|(master, slave)| saw_ahead(master, slave)),
        any::<bool>().prop_map(gear_in_velo),
        (-100.0..1_000.0).prop_map(|position| Command::Home { position }),
    ]
}

fn saw_ahead(master_sync_position: f64, slave_sync_position: f64) -> Command {
    Command::from(GearInPos {
        ratio: Ratio::of(0.5),
        master_sync_position,
        slave_sync_position,
        master_start_distance: None,
        strategy: None,
        sync_mode: SyncMode::default(),
        limits: SyncLimits::default(),
    })
}

fn gear_in_velo(time_based: bool) -> Command {
    Command::GearInVelo(GearInVelo {
        ratio: Ratio::of(-2.0),
        sync_mode: if time_based {
            SyncMode::time_based(SyncMask::empty())
        } else {
            SyncMode::default()
        },
        limits: SyncLimits::default(),
    })
}

proptest! {
    #[test]
    fn it_answers_as_the_command_does_and_changes_nothing(
        steps in proptest::collection::vec((commands(), 0_u32..200, -50.0..50.0), 1..30),
    ) {
        let mut axis = axis(&LIMITED);
        let mut master = Master::at(0.0, 0.0);
        for (command, cycles, velocity) in steps {
            let before = format!("{axis:?}");
            let said = axis.plan(&command);
            prop_assert_eq!(format!("{:?}", axis), before);
            let foreseen = said.as_ref().ok().and_then(|change| change.saw_plan().copied());
            let answer = axis.command(&command);
            prop_assert_eq!(said.err(), answer.err());
            if foreseen.is_some() {
                prop_assert_eq!(axis.saw_plan().copied(), foreseen);
            }
            master.0.velocity = velocity;
            master.lead(&mut axis, cycles);
        }
    }
}

#[test]
fn a_change_is_not_applied_to_an_axis_that_has_gone_on() {
    let mut axis = powered(&PARAMETERS);
    let change = axis.plan(&move_absolute(10.0)).unwrap();
    run(&mut axis, 1);
    let applied = std::panic::catch_unwind(core::panic::AssertUnwindSafe(|| {
        axis.apply(change, Origin::Order)
    }));
    assert!(applied.is_err());
}
