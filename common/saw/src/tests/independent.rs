//! Profiles over time, beside those of an independent generator.

use super::super::SyncMask;
use super::properties::{SLACK, decades, signed};
use super::*;
use proptest::prelude::*;
use rsruckig::prelude::{
    ControlInterface, InputParameter, Ruckig, ThrowErrorHandler, Trajectory, daov_stack,
};

/// Returns the duration and path of the change of velocity by an independent generator. Some of the very
/// hard ones it gives up.
fn independent(
    start: &Kinematics,
    target: f64,
    acceleration: f64,
    jerk: f64,
) -> Option<(f64, f64)> {
    let mut input = InputParameter::<1>::new(None);
    input.control_interface = ControlInterface::Velocity;
    input.current_velocity[0] = start.velocity;
    input.current_acceleration[0] = start.acceleration;
    input.target_velocity[0] = target;
    input.max_acceleration[0] = acceleration;
    input.max_jerk[0] = jerk;
    let mut ruckig = Ruckig::<1, ThrowErrorHandler>::new(None, 1e-3);
    let mut trajectory = Trajectory::<1>::new(None);
    ruckig.calculate(&input, &mut trajectory).ok()?;
    let duration = trajectory.get_duration();
    let mut position = daov_stack![0.0];
    let at_end = &mut Some(&mut position);
    trajectory.at_time(duration, at_end, &mut None, &mut None, &mut None, &mut None);
    Some((duration, position[0]))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn a_profile_over_time_agrees_with_an_independent_generator(
        (v0, v1) in (signed(decades(0, 3)), signed(decades(0, 3))),
        (a, j) in (decades(1, 5), decades(2, 8)),
        share in -1.0..1.0_f64,
    ) {
        let mut start = moment((0.0, v1), (0.0, v0));
        start.slave.acceleration = share * a;
        let command = to_velocity(1.0, SyncMode::time_based(SyncMask::empty()), dynamics(a, j));
        let plan = command.plan(&start).expect("within the limits");
        let expected = independent(&start.slave, v1, a, j);
        // Only commands that both solve can be compared.
        prop_assume!(expected.is_some());
        let (duration, distance) = expected.unwrap_or_default();
        let found = plan.duration().0;
        prop_assert!((found - duration).abs() <= SLACK * duration, "{found} {duration}");
        // The longest possible distance: rounding of durations counts relative to it.
        let size = duration * v0.abs().max(v1.abs()).max(plan.characteristics(1).extremes.velocity.magnitude());
        let found = plan.line().slave;
        prop_assert!((found - distance).abs() <= SLACK * size, "{found} {distance}");
    }
}
