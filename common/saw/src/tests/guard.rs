//! An axis that never leaves its limits.

use super::super::{LimitGuard, SawForm, SyncMask};
use super::properties::{assert_kept, gear_in_pos, gear_in_velo, limits};
use super::*;
use proptest::prelude::*;

/// Returns the moment with an axis that keeps its limits in any case.
fn guarded(mut moment: CouplingMoment, own: &SyncLimits) -> CouplingMoment {
    let given = |limit: Option<f64>| limit.expect("all limits are given");
    moment.axis = SlaveLimits {
        dynamics: Limits::new(
            given(own.velocity),
            given(own.acceleration),
            given(own.deceleration),
            given(own.jerk),
        )
        .expect("above zero"),
        min_position: own.min_position,
        max_position: own.max_position,
        guard: Some(LimitGuard { reserve: 0.01 }),
    };
    moment
}

const KEPT: SyncMask = SyncMask::OPTIONAL_MIN_POS
    .union(SyncMask::OPTIONAL_MAX_POS)
    .union(SyncMask::MAX_VELO)
    .union(SyncMask::MAX_ACC)
    .union(SyncMask::MAX_DEC);

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn a_guarded_axis_keeps_its_limits_whatever_is_checked(
        (command, moment) in gear_in_pos(),
        (ramp, from) in any::<bool>().prop_flat_map(gear_in_velo),
        own in limits(),
    ) {
        if let Ok(plan) = command.plan(&guarded(moment, &own)) {
            assert_kept(&plan, KEPT, &own)?;
        }
        if let Ok(plan) = ramp.plan(&guarded(from, &own)) && plan.form() != SawForm::Synchronous {
            assert_kept(&plan, KEPT, &own)?;
        }
    }
}
