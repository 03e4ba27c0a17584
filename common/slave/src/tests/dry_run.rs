//! A dry run says what the command would, and leaves no trace.

use proptest::prelude::*;
use std::{format, vec};

use super::*;
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
        (-2.0..2.0).prop_map(|ratio| Command::GearIn { ratio }),
        Just(Command::GearOut {}),
        Just(Command::ReadFlyingSawCharacteristics {}),
        (1.0..500.0, -200.0..500.0).prop_map(|(master, slave)| saw_ahead(master, slave)),
        any::<bool>().prop_map(gear_in_velo),
        (-100.0..1_000.0).prop_map(|position| Command::Home { position }),
    ]
}

fn saw_ahead(master_sync_position: f64, slave_sync_position: f64) -> Command {
    Command::GearInPos(GearInPos {
        ratio: Ratio::of(0.5),
        master_sync_position,
        slave_sync_position,
        master_start_distance: None,
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
            let said = axis.dry_run(&command);
            prop_assert_eq!(format!("{:?}", axis), before);
            let foreseen = command.as_saw().and_then(|saw| axis.foresee(saw).ok());
            let answer = axis.command(&command);
            prop_assert_eq!(said, Some(answer));
            if answer.is_ok() && foreseen.is_some() {
                prop_assert_eq!(axis.saw_plan().copied(), foreseen);
            }
            master.0.velocity = velocity;
            master.lead(&mut axis, cycles);
        }
    }
}

#[test]
fn what_changes_plates_cannot_be_tried() {
    let mut axis = powered(&PARAMETERS);
    let before = format!("{axis:?}");
    assert_eq!(axis.dry_run(&Command::CamIn(<_>::default())), None);
    assert_eq!(format!("{axis:?}"), before);
}
