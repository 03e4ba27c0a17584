//! What would have passed does, and hardly more does.

use super::super::SawRefusal;
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
                let towards = if distance > given { 0.999 } else { 1.001 };
                let beyond = (distance / given).max(given / distance) < 1.001;
                prop_assert!(beyond || verdict(distance * towards).is_err());
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
