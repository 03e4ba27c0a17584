//! Synchronisation positions relative to now: to the axes' positions, or within their modulo periods.

use super::saws::to_position;
use super::*;
use crate::{CouplingRefusal, Refusal, SyncPosition, WrongSyncPosition};
use coaxle_axis::{CommandState, Modulo, SyncPositions};
use coaxle_gear::{FlyingGearError, FlyingGearParameters};
use coaxle_saw::{GearInPos, Ratio, SawRefusal, SyncLimits, SyncMask};
use proptest::prelude::*;

use SyncPosition::{Ahead, At, InTurn};

fn turn(length: f64) -> Option<Modulo> {
    Modulo::new(length).ok()
}

/// A rotary knife with one revolution per product of 600 mm.
fn saw(ratio: f64, master: SyncPosition, slave: SyncPosition) -> GearInPos<SyncPosition> {
    let gear = GearInPos {
        ratio: Ratio::of(ratio),
        ..to_position((0.0, 0.0), SyncMask::empty())
    };
    gear.at(master, slave)
}

fn knife(ratio: f64, master: SyncPosition, slave: SyncPosition) -> Command {
    Command::GearInPos(saw(ratio, master, slave))
}

/// The knife, with power, homed at `slave`, with a master that passes `position` next.
fn knife_at(slave: f64, position: f64, velocity: f64) -> (AxisWithPlates, Master) {
    let mut axis = powered(&PARAMETERS);
    start(&mut axis, &Command::Home { position: slave });
    axis.set_modulo(turn(360.0), turn(600.0));
    let mut master = Master::at(position, velocity);
    master.lead(&mut axis, 1);
    (axis, master)
}

/// Synchronous positions of a command.
fn planned(axis: &AxisWithPlates, command: &Command) -> SyncPositions {
    let change = axis.plan(command);
    let change = change.unwrap_or_else(|refusal| panic!("{command:?}: {refusal}"));
    change.sync_positions().expect("a pair of positions")
}

#[test]
fn the_next_turn_is_taken_in_either_direction_after_thousands_of_turns() {
    for (turns, velocity) in [
        (0.0, 300.0),
        (5_000.0, 300.0),
        (5_000.0, -300.0),
        (-7_000.0, -300.0),
    ] {
        let (mut axis, mut master) = knife_at(turns * 360.0, turns * 600.0, velocity);
        let sign = f64::signum(velocity);
        let job = start(&mut axis, &knife(0.6, InTurn(300.0), InTurn(180.0)));
        let at = axis.sync_positions().expect("it is coupled");
        let expected = SyncPositions {
            master: turns * 600.0 + sign * 300.0,
            slave: turns * 360.0 + sign * 180.0,
        };
        assert_eq!(at, expected, "{turns} {velocity}");
        while axis.progress(job) != CommandState::InSync {
            assert_eq!(axis.progress(job), CommandState::Active);
            master.lead(&mut axis, 1);
        }
        master.lead(&mut axis, 3_000);
        let off = (axis.set().position - at.slave) - 0.6 * (master.0.position - at.master);
        assert!(off.abs() < 1e-6, "{off}");
        let shown = axis.axis_struct(1);
        let whole = f64::from(shown.modulo_set_turns) * 360.0 + shown.modulo_set_position;
        assert!((whole - shown.set_position).abs() < 1e-6);
        assert!((0.0..360.0).contains(&shown.modulo_set_position));
    }
}

#[test]
fn a_turn_that_is_too_near_is_left_to_the_next() {
    // 20 mm are too few from rest to 180 °/s; 620 are not.
    let (axis, master) = knife_at(0.0, 279.7, 300.0);
    assert_eq!(master.0.position, 280.0);
    let at = planned(&axis, &knife(0.6, InTurn(300.0), InTurn(180.0)));
    assert_eq!((at.master, at.slave), (900.0, 180.0));
    let near = axis.plan(&knife(0.6, At(300.0), At(180.0)));
    assert!(near.is_err());
    // At the position itself, the next one is a period ahead.
    let (axis, _) = knife_at(180.0, 299.7, 300.0);
    let at = planned(&axis, &knife(0.6, InTurn(300.0), InTurn(180.0)));
    assert_eq!((at.master, at.slave), (900.0, 540.0));
}

#[test]
fn of_the_slave_the_nearest_turn_ahead_that_passes_is_taken_and_one_behind_only_at_last() {
    let (axis, _) = knife_at(170.0, -0.3, 300.0);
    // 10° in 1000 mm: the knife would move back first.
    let mut forwards = saw(0.6, At(1_000.0), InTurn(180.0));
    let at = planned(&axis, &Command::GearInPos(forwards));
    assert_eq!(at.slave, 180.0);
    forwards.sync_mode.mask = SyncMask::UNDERSHOOT_VELO_ZERO;
    let at = planned(&axis, &Command::GearInPos(forwards));
    assert_eq!(at.slave, 540.0);
    // The slave's software limit leaves only the one behind it.
    let limited = SlaveParameters {
        max_position: Some(200.0),
        min_position: Some(-200.0),
        ..PARAMETERS
    };
    let mut axis = powered(&limited);
    start(&mut axis, &Command::Home { position: 190.0 });
    axis.set_modulo(turn(360.0), turn(600.0));
    Master::at(-0.3, 300.0).lead(&mut axis, 1);
    let mut early = saw(0.01, At(600.0), InTurn(180.0));
    early.strategy = Some(coaxle_saw::SyncStrategy::Slow);
    assert_eq!(planned(&axis, &Command::GearInPos(early)).slave, 180.0);
}

#[test]
fn if_none_of_the_turns_passes_the_refusal_is_that_of_the_first() {
    let (axis, _) = knife_at(0.0, -0.3, 300.0);
    let mut slow = saw(0.6, InTurn(300.0), InTurn(180.0));
    slow.limits = SyncLimits {
        acceleration: Some(1.0),
        deceleration: Some(1.0),
        ..slow.limits
    };
    slow.sync_mode.mask = SyncMask::MAX_ACC;
    let command = Command::GearInPos(slow);
    let refused = axis.plan(&command).unwrap_err();
    let first = Command::from(slow.at(300.0, 180.0));
    assert_eq!(refused, axis.plan(&first).unwrap_err());
    assert_eq!(axis.saw_command(&command), first.as_saw());
    assert!(matches!(
        refused,
        Refusal::Coupling(CouplingRefusal::Saw(SawRefusal::Violation(_)))
    ));
}

#[test]
fn ahead_counts_from_the_cycle_of_the_command() {
    let (axis, _) = knife_at(40.0, 999.7, 300.0);
    let at = planned(&axis, &knife(0.6, Ahead(500.0), Ahead(150.0)));
    assert_eq!((at.master, at.slave), (1_500.0, 190.0));
    let (axis, _) = knife_at(40.0, 1_000.3, -300.0);
    let at = planned(&axis, &knife(0.6, Ahead(500.0), Ahead(150.0)));
    assert_eq!((at.master, at.slave), (500.0, -110.0));
    // Against the master, the slave moves in the direction of its ratio.
    let at = planned(&axis, &knife(-0.6, Ahead(500.0), Ahead(150.0)));
    assert_eq!((at.master, at.slave), (500.0, 190.0));
}

#[test]
fn a_dry_run_names_the_same_positions() {
    let (mut axis, _) = knife_at(40.0, 999.7, 300.0);
    let command = knife(0.6, InTurn(100.0), InTurn(10.0));
    let tried = planned(&axis, &command);
    assert_eq!(axis.sync_positions(), None);
    start(&mut axis, &command);
    assert_eq!(axis.sync_positions(), Some(tried));
}

#[test]
fn what_does_not_turn_has_no_turns() {
    let (mut axis, _) = knife_at(0.0, 0.0, 300.0);
    axis.set_modulo(turn(360.0), None);
    let wrong = |axis: &AxisWithPlates, command: &Command| match axis.plan(command).unwrap_err() {
        Refusal::SyncPosition(wrong) => (wrong.field(), wrong),
        other => panic!("{other}"),
    };
    let (field, why) = wrong(&axis, &knife(0.6, InTurn(300.0), At(180.0)));
    assert_eq!(field, "master-sync-position");
    assert!(matches!(
        why,
        WrongSyncPosition::NoModulo {
            received: 300.0,
            ..
        }
    ));
    let (field, why) = wrong(&axis, &knife(0.6, At(300.0), InTurn(360.0)));
    assert_eq!(field, "slave-sync-position");
    assert!(matches!(
        why,
        WrongSyncPosition::NotInTurn { length: 360.0, .. }
    ));
    // Without a master no position is ahead of it.
    let mut alone = powered(&PARAMETERS);
    alone.update(None, CYCLE);
    let refused = alone.plan(&knife(0.6, Ahead(300.0), At(1.0))).unwrap_err();
    assert_eq!(refused, Refusal::NoMaster);
}

#[test]
fn a_flying_gear_waits_for_the_next_turn_and_releases_in_it() {
    let (mut axis, mut master) = knife_at(3_600.0, 6_100.0 - 0.3, 300.0);
    let gear = FlyingGearParameters {
        ratio: 0.6,
        master_sync_position: InTurn(300.0),
        slave_sync_position: InTurn(60.0),
        slave_desync_position: InTurn(270.0),
        slave_stop_position: InTurn(0.0),
        default_slave_negative: false,
    };
    // The gear begins 200 mm before: 300 within the period at 6000 is exactly that far.
    let at = planned(&axis, &Command::FlyingGear(gear));
    assert_eq!((at.master, at.slave), (6_300.0, 3_660.0));
    master.lead(&mut axis, 1);
    let at = planned(&axis, &Command::FlyingGear(gear));
    assert_eq!((at.master, at.slave), (6_900.0, 3_660.0));
    start(&mut axis, &Command::FlyingGear(gear));
    master.lead(&mut axis, 6_000);
    assert_eq!(axis.set().position, 3_960.0);
    // No part of it is ahead of a master that moves the other way.
    let wrong_way = FlyingGearParameters {
        slave_sync_position: At(0.0),
        ..gear
    };
    let refused = axis.plan(&Command::FlyingGear(wrong_way)).unwrap_err();
    assert!(matches!(
        refused,
        Refusal::Coupling(CouplingRefusal::FlyingGear(
            FlyingGearError::MasterPastStart { .. }
        ))
    ));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// An accepted position is ahead, within the tried periods, congruent, and the first that passes.
    #[test]
    fn the_first_turn_that_passes_is_taken(
        turns in -3_000..3_000i32,
        part in 0.0..600.0f64,
        within in 0.0..599.0f64,
        slave_within in 0.0..359.0f64,
        slave in -4_000.0..4_000.0f64,
        velocity in prop_oneof![-500.0..-50.0f64, 50.0..500.0f64],
        ratio in prop_oneof![-1.0..-0.2f64, 0.2..1.0f64],
    ) {
        let (axis, master) = knife_at(slave, f64::from(turns) * 600.0 + part, velocity);
        let mut asked = saw(ratio, InTurn(within), InTurn(slave_within));
        asked.sync_mode.mask = SyncMask::MAX_ACC | SyncMask::UNDERSHOOT_VELO_ZERO;
        let Ok(change) = axis.plan(&Command::GearInPos(asked)) else {
            return Ok(());
        };
        let at = change.sync_positions().expect("a pair of positions");
        let sign = velocity.signum();
        let ahead = (at.master - master.0.position) * sign;
        prop_assert!(ahead > 0.0 && ahead <= 8.0 * 600.0 + 1e-6, "{ahead}");
        for (resolved, within, length) in [(at.master, within, 600.0), (at.slave, slave_within, 360.0)] {
            let off = (resolved - within) / length;
            prop_assert!((off - libm::round(off)).abs() * length < 1e-6, "{off}");
        }
        let slave_ahead = (at.slave - axis.set().position) * sign * ratio.signum();
        prop_assert!(slave_ahead > 0.0 && slave_ahead <= 720.0 + 1e-6, "{slave_ahead}");
        let before = (ahead / 600.0) as i32;
        for k in 1..=before {
            let nearer = asked.at(at.master - sign * 600.0 * f64::from(k), at.slave);
            prop_assert!(axis.plan(&Command::from(nearer)).is_err(), "{k} turns nearer");
        }
    }
}
