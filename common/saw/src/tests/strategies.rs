//! Late, slow and early, beside an independent generator and against themselves.

use super::super::{
    Check, LimitGuard, SawCommand, SawCoupling, SawForm, SawPlan, SawRefusal, SawTolerances,
    SyncMask, SyncStrategy,
};
use super::properties::{SLACK, assert_ends, assert_kept, gear_in_pos};
use super::*;
use proptest::prelude::*;
use rsruckig::prelude::{InputParameter, Ruckig, ThrowErrorHandler, Trajectory, daov_stack};

/// Random command with a strategy, with equal limits in all directions.
fn by(strategy: SyncStrategy) -> impl Strategy<Value = (GearInPos, CouplingMoment)> {
    gear_in_pos().prop_map(move |(mut command, mut moment)| {
        command.strategy = Some(strategy);
        command.sync_mode.mask = SyncMask::DETAILED_ERROR_CODES;
        command.limits.deceleration = command.limits.acceleration;
        // Planning does not follow the acceleration of the master.
        moment.master.acceleration = 0.0;
        (command, moment)
    })
}

/// Returns the duration of the path onto the line of the gear, relative to the line: by another
/// generator, with a share of acceleration and jerk. Some of the very hard ones it gives up, for a few
/// its result is longer than necessary.
fn independent(command: &GearInPos, moment: &CouplingMoment, share: f64) -> Option<f64> {
    let ratio = command.ratio.numerator / f64::from(command.ratio.denominator);
    let line = command.slave_sync_position
        + ratio * (moment.master.position - command.master_sync_position);
    let sync = ratio * moment.master.velocity;
    let given = |limit: Option<f64>| limit.expect("all limits are given");
    let (highest, acceleration) = (
        given(command.limits.velocity).max(sync.abs()),
        given(command.limits.acceleration) * share,
    );
    let mut input = InputParameter::<1>::new(None);
    input.current_position[0] = moment.slave.position - line;
    input.current_velocity[0] = moment.slave.velocity - sync;
    input.current_acceleration[0] = moment.slave.acceleration;
    input.max_velocity[0] = highest - sync;
    input.min_velocity = Some(daov_stack![-highest - sync]);
    input.max_acceleration[0] = acceleration;
    input.min_acceleration = Some(daov_stack![-acceleration]);
    input.max_jerk[0] = given(command.limits.jerk) * share;
    let mut ruckig = Ruckig::<1, ThrowErrorHandler>::new(None, 1e-3);
    let mut trajectory = Trajectory::<1>::new(None);
    ruckig.calculate(&input, &mut trajectory).ok()?;
    Some(trajectory.get_duration())
}

/// Returns the greatest part of acceleration, deceleration and jerk that a plan takes.
fn share_of(plan: &SawPlan, limits: &SyncLimits) -> f64 {
    let extremes = plan.characteristics(1).extremes;
    let acceleration = extremes.acceleration.magnitude() / limits.acceleration.expect("given");
    acceleration.max(extremes.jerk.magnitude() / limits.jerk.expect("given"))
}

/// True if the slave starts below its limits.
fn starts_gently(command: &GearInPos, moment: &CouplingMoment) -> bool {
    let limits = &command.limits;
    let (v, a) = (moment.slave.velocity.abs(), moment.slave.acceleration.abs());
    let jerk = limits.jerk.expect("given");
    // Leading the acceleration to zero adds a²/2j; twice that is on the safe side.
    v + a * a / jerk < limits.velocity.expect("given") && a < limits.acceleration.expect("given")
}

const KEPT: SyncMask = SyncMask::MAX_DYNAMICS;
/// The tolerance for rounding of a limit has a great effect where the line is nearly as fast.
const LATER: f64 = 1e-4;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn nothing_is_earlier_than_early((command, moment) in by(SyncStrategy::Early)) {
        if let Ok(plan) = command.plan(&moment) && starts_gently(&command, &moment) {
            if plan.form() == SawForm::Synchronous {
                return Ok(());
            }
            assert_kept(&plan, KEPT, &command.limits)?;
            assert_ends(&plan, &moment)?;
            let found = plan.duration().0;
            if let Some(expected) = independent(&command, &moment, 1.0) {
                prop_assert!(found <= expected * (1.0 + LATER), "{found} {expected}");
            }
            // It ends on the line of the gear.
            let ratio = plan.line().ratio;
            let expected = command.slave_sync_position
                + ratio * (plan.line().master - command.master_sync_position);
            let size = plan.characteristics(1).extremes.position.magnitude() + expected.abs();
            prop_assert!((plan.line().slave - expected).abs() <= SLACK * size);
        }
    }

    #[test]
    fn nothing_is_gentler_than_slow((command, moment) in by(SyncStrategy::Slow)) {
        if let Ok(plan) = command.plan(&moment) && starts_gently(&command, &moment) {
            prop_assert_eq!(plan.form(), SawForm::JerkPhases);
            assert_kept(&plan, KEPT, &command.limits)?;
            assert_ends(&plan, &moment)?;
            let available = plan.duration().0;
            let share = share_of(&plan, &command.limits);
            prop_assert!(share <= 1.0 + SLACK);
            // With any less of the limits, the slave is late.
            // The acceleration at the start is there in any plan, and so is its effect on the velocity.
            let mut gentler = command;
            gentler.limits.acceleration = command.limits.acceleration.map(|a| a * share * 0.999);
            gentler.limits.jerk = command.limits.jerk.map(|j| j * share * 0.999);
            if share > 1e-8 && starts_gently(&gentler, &moment) && let Some(takes) = independent(&command, &moment, share * 0.999) {
                prop_assert!(takes >= available * (1.0 - 1e-6), "{share} {takes} {available}");
            }
            // Nor does the plan without a strategy take less.
            let other = GearInPos { strategy: None, ..command };
            if let Ok(quintic) = other.plan(&moment) {
                let fast = quintic.characteristics(1).extremes.velocity.magnitude();
                // The least share is a billionth.
                if share > 1e-8 && fast <= command.limits.velocity.expect("given") {
                    let other = share_of(&quintic, &command.limits);
                    prop_assert!(other >= share * (1.0 - 1e-6), "{other} {share}");
                }
            }
        }
    }

    #[test]
    fn nothing_begins_later_than_late((command, moment) in by(SyncStrategy::Late)) {
        let available = (command.master_sync_position - moment.master.position)
            / moment.master.velocity;
        match SawCoupling::start(SawCommand::GearInPos(command), &moment, SawTolerances::default()) {
            Ok(saw) => {
                let plan = saw.plan();
                if starts_gently(&command, &moment) {
                    assert_kept(plan, KEPT, &command.limits)?;
                }
                let wait = (plan.master_start() - moment.master.position) / moment.master.velocity;
                let mut begin = moment;
                begin.master.position = plan.master_start();
                begin.slave = *plan.slave_start();
                if wait > 0.0
                    && starts_gently(&command, &begin)
                    && let Some(takes) = independent(&command, &begin, 0.99)
                {
                    // On the line it is at its position, or before.
                    let ends = wait + takes * (1.0 + LATER);
                    prop_assert!(ends >= available * (1.0 - 1e-6), "{wait} {takes} {available}");
                    prop_assert!(share_of(plan, &command.limits) <= 0.99 + 1e-6);
                }
            }
            Err(SawRefusal::TooShort { needed, available: given }) => {
                prop_assert!(needed > given);
                prop_assert!((given - available).abs() <= SLACK * available);
                if starts_gently(&command, &moment)
                    && let Some(takes) = independent(&command, &moment, 1.0)
                {
                    prop_assert!(needed <= takes * (1.0 + LATER));
                }
            }
            Err(_) => {}
        }
    }

    #[test]
    fn limits_and_checks_are_kept_by_every_strategy(
        (command, moment) in gear_in_pos(),
        strategy in prop::sample::select(SyncStrategy::ALL.as_slice()),
    ) {
        let command = GearInPos { strategy: Some(strategy), ..command };
        if let Ok(plan) = command.plan(&moment)
            && plan.form() != SawForm::Synchronous
            && starts_gently(&command, &moment)
        {
            assert_kept(&plan, command.sync_mode.mask, &command.limits)?;
            if strategy != SyncStrategy::Early {
                prop_assert_eq!(plan.master_end(), command.master_sync_position);
                prop_assert_eq!(plan.line().slave, command.slave_sync_position);
            }
        }
    }

    #[test]
    fn a_motion_function_of_slow_runs_the_same_way((command, moment) in by(SyncStrategy::Slow)) {
        if let Ok(plan) = command.plan(&moment) {
            let function = plan.motion_function();
            prop_assert!(function.is_ok(), "{function:?}");
        }
    }
}

fn example(strategy: SyncStrategy) -> GearInPos {
    GearInPos {
        strategy: Some(strategy),
        ..to_position(
            1.0,
            (1_000.0, 300.0),
            SyncMode::default(),
            SyncLimits {
                velocity: Some(1_000.0),
                ..dynamics(2_000.0, 20_000.0)
            },
        )
    }
}

#[test]
fn the_three_differ_as_they_should() {
    // A master at 500 mm/s, 2 s before its position; the slave at rest, at its own home.
    let start = moment((0.0, 500.0), (0.0, 0.0));
    let begun = |strategy| {
        let command = SawCommand::GearInPos(example(strategy));
        *SawCoupling::start(command, &start, SawTolerances::default())
            .expect("within the limits")
            .plan()
    };
    let [late, slow, early] = SyncStrategy::ALL.map(begun);
    assert_eq!((slow.master_start(), slow.master_end()), (0.0, 1_000.0));
    assert!(late.master_start() > 500.0 && late.master_end() == 1_000.0);
    // The slave waits where it is, 700 ahead of the line, and is on it before its position.
    assert!(early.master_end() < 1_000.0 && early.master_start() == 0.0);
    let limits = example(SyncStrategy::Slow).limits;
    assert!((share_of(&late, &limits) - 0.99).abs() < 1e-6);
    assert!(share_of(&slow, &limits) < 0.6);
    assert!((share_of(&early, &limits) - 1.0).abs() < 1e-6);
}

#[test]
fn what_cannot_be_done_is_refused_with_figures() {
    let start = moment((0.0, 500.0), (0.0, 0.0));
    let near = GearInPos {
        master_sync_position: 100.0,
        slave_sync_position: 50.0,
        ..example(SyncStrategy::Slow)
    };
    let refusal = near.plan(&start).unwrap_err();
    let SawRefusal::TooShort { needed, available } = refusal else {
        panic!("{refusal}");
    };
    // 100 u at 500 u/s.
    assert_eq!((available, refusal.code()), (0.2, 0x42df));
    // Reaching 500 u/s alone takes 500/2000 + 2000/20000 = 0.35 s.
    assert!(needed > 0.3, "{needed}");
    let early = GearInPos {
        strategy: Some(SyncStrategy::Early),
        ..near
    };
    assert!(early.plan(&start).unwrap().master_end() > 100.0);

    let standing = moment((0.0, 0.0), (0.0, 0.0));
    for strategy in [SyncStrategy::Late, SyncStrategy::Slow] {
        let refusal = example(strategy).plan(&standing).unwrap_err();
        assert_eq!(
            (refusal, refusal.code()),
            (SawRefusal::MasterStands, 0x426e)
        );
    }
    let plan = example(SyncStrategy::Early).plan(&standing).unwrap();
    // The line through (1000, 300) with slope 1.
    assert_eq!((plan.line().slave, plan.line().master), (-700.0, 0.0));

    let mut as_fast = example(SyncStrategy::Early);
    as_fast.limits.velocity = Some(500.0);
    as_fast.slave_sync_position = 1_200.0;
    let refusal = as_fast.plan(&start).unwrap_err();
    assert_eq!(refusal.code(), 0x42dd, "{refusal}");

    let mut fenced = start;
    fenced.axis.min_position = Some(-1.0);
    let mode = SyncMode::position_based(SyncMask::MIN_POS | SyncMask::DETAILED_ERROR_CODES);
    let refused = GearInPos {
        sync_mode: mode,
        slave_sync_position: -500.0,
        ..example(SyncStrategy::Slow)
    };
    let violation = *refused.plan(&fenced).unwrap_err().violation().unwrap();
    assert_eq!(violation.check, Check::MinPos);
}

#[test]
fn where_turning_round_breaks_a_check_the_slave_waits() {
    // The line approaches from behind: the fastest path moves towards it.
    let start = moment((0.0, 100.0), (0.0, 50.0));
    let meets = GearInPos {
        slave_sync_position: 600.0,
        ..example(SyncStrategy::Early)
    };
    let lowest = |plan: &SawPlan| plan.characteristics(1).extremes.velocity.minimum.value;
    let free = meets.plan(&start).unwrap();
    assert!(lowest(&free) < -100.0);
    let mode = SyncMode::position_based(SyncMask::UNDERSHOOT_VELO_ZERO);
    let onwards = GearInPos {
        sync_mode: mode,
        ..meets
    };
    let waits = onwards.plan(&start).unwrap();
    assert!(lowest(&waits) > -1e-9 && waits.duration() > free.duration());
    // So does a software limit, without a requested velocity.
    let mut fenced = start;
    fenced.axis.min_position = Some(0.0);
    let mode = SyncMode::position_based(SyncMask::MIN_POS);
    let fenced_in = GearInPos {
        sync_mode: mode,
        ..meets
    };
    assert!(lowest(&fenced_in.plan(&fenced).unwrap()) > -1e-9);
}

/// At one share, the slave is just at its velocity limit for no time at all.
#[test]
fn slow_finds_a_way_for_a_slave_in_sync_elsewhere() {
    let mut start = moment(
        (800.399_999_999_971_7, 400.0),
        (250.399_999_999_971_67, 400.0),
    );
    start.axis.dynamics = Limits::new(1_000.0, 5_000.0, 4_000.0, 1e5).unwrap();
    start.axis.guard = Some(LimitGuard { reserve: 0.01 });
    let command = GearInPos {
        strategy: Some(SyncStrategy::Slow),
        ..to_position(
            1.0,
            (1_400.399_999_999_971_7, 550.399_999_999_971_7),
            SyncMode::default(),
            SyncLimits::default(),
        )
    };
    let plan = command.plan(&start).unwrap();
    assert_ends(&plan, &start).unwrap();
}
