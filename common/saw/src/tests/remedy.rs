//! Remedies are accepted, and not much more would be.

use super::super::{SawCommand, SawCoupling, SawRefusal, SawTolerances, SyncMask, SyncStrategy};
use super::properties::{gear_in_pos, gear_in_velo};
use super::*;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_remedy_is_accepted_and_tight((command, moment) in gear_in_pos()) {
        if let Err(SawRefusal::Violation(_)) = command.plan(&moment) {
            let remedy = command.remedy(&moment);
            if let Some(distance) = remedy.master_distance {
                let given = (command.master_sync_position - moment.master.position).abs();
                let verdict = |distance: f64| {
                    let master = distance.copysign(moment.master.velocity);
                    let master_sync_position = moment.master.position + master;
                    GearInPos { master_sync_position, ..command }.plan(&moment)
                };
                prop_assert!(verdict(distance).is_ok());
                // A thousandth towards the given distance is refused again: the remedy is the nearest one.
                let towards = if distance > given { 0.999 } else { 1.001 };
                let beyond = (distance / given).max(given / distance) < 1.001;
                prop_assert!(beyond || verdict(distance * towards).is_err());
            }
            for flag in remedy.flags.iter() {
                let mut flagged = command;
                prop_assert!(!flagged.sync_mode.mask.contains(flag));
                flagged.sync_mode.mask |= flag;
                prop_assert!(flagged.plan(&moment).is_ok(), "{flag:?}");
            }
            if let Some(strategy) = remedy.strategy {
                let other = GearInPos { strategy: Some(strategy), ..command };
                let other = SawCommand::GearInPos(other);
                let started = SawCoupling::start(other, &moment, SawTolerances::default());
                prop_assert!(started.is_ok(), "{strategy:?}");
            }
            if let Some(speed) = remedy.master_speed {
                let verdict = |speed: f64| {
                    let mut moment = moment;
                    moment.master.velocity = speed.copysign(moment.master.velocity);
                    command.plan(&moment)
                };
                prop_assert!(verdict(speed).is_ok());
                let beyond = moment.master.velocity.abs() / speed < 1.001;
                prop_assert!(beyond || verdict(speed * 1.001).is_err());
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_remedy_of_a_ramp_is_accepted_and_tight(
        (command, moment) in any::<bool>().prop_flat_map(gear_in_velo),
    ) {
        if command.plan(&moment).is_err()
            && let Some(speed) = command.remedy(&moment).master_speed
        {
            let passes = |speed: f64| {
                let mut moment = moment;
                moment.master.velocity = speed.copysign(moment.master.velocity);
                command.plan(&moment).is_ok()
            };
            prop_assert!(passes(speed));
            let beyond = moment.master.velocity.abs() / speed < 1.001;
            prop_assert!(beyond || !passes(speed * 1.001));
        }
    }
}

/// A good part of refused random commands passes with another flag, and the refusal names it.
#[test]
fn flags_and_strategies_that_help_are_named() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;

    let mut runner = TestRunner::deterministic();
    let (mut refused, mut by_flag, mut by_strategy) = (0, 0, 0);
    while refused < 300 {
        let (mut command, mut moment) = gear_in_pos()
            .new_tree(&mut runner)
            .expect("a command")
            .current();
        command.sync_mode.mask = SyncMask::MAX_ACC | SyncMask::MAX_DEC | SyncMask::MAX_JERK;
        (moment.master.acceleration, moment.slave.acceleration) = (0.0, 0.0);
        let Err(SawRefusal::Violation(_)) = command.plan(&moment) else {
            continue;
        };
        refused += 1;
        let remedy = command.remedy(&moment);
        by_flag += u32::from(!remedy.flags.is_empty());
        by_strategy += u32::from(remedy.strategy.is_some());
        let mut preferred = command;
        preferred.sync_mode.mask |= SyncMask::PREFER_CONST_VELO;
        let helps = preferred.plan(&moment).is_ok();
        assert_eq!(remedy.flags.contains(SyncMask::PREFER_CONST_VELO), helps);
    }
    assert!(
        // Seeded draws: a bound for "a good part" that does not depend on their exact number.
        by_flag >= 10 && by_strategy > by_flag,
        "{by_flag} {by_strategy}"
    );
}

#[test]
fn a_strategy_is_a_remedy_of_another_one() {
    let command = GearInPos {
        strategy: Some(SyncStrategy::Slow),
        ..to_position(
            1.0,
            (100.0, 50.0),
            SyncMode::default(),
            dynamics(2_000.0, 20_000.0),
        )
    };
    let start = moment((0.0, 500.0), (0.0, 0.0));
    let remedy = command.remedy(&start);
    assert_eq!(remedy.strategy, Some(SyncStrategy::Early));
    assert_eq!(remedy.flags, SyncMask::empty());
    let farther = remedy.master_distance.expect("farther away there is time");
    assert!(farther > 100.0 && remedy.master_speed.is_some());
}
