//! Time until the axis is back, compared with an independent time-optimal generator.

use std::vec::Vec;

use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;
use rsruckig::prelude::{InputParameter, Ruckig, ThrowErrorHandler, Trajectory, daov_stack};

use super::super::{GuardState, SetValueGuard};
use super::motion::{Axis, scaled};
use super::random::Random;

/// A motion to a target of constant velocity.
struct Way {
    axis: Axis,
    from: Kinematics,
    /// Position of the target at the start.
    target: Kinematics,
}

/// Result of a motion, in cycles.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    bound: f64,
    cycles: f64,
    /// Number of sign changes of the jerk.
    reversals: u32,
}

impl Way {
    fn by_chance(random: &mut Random) -> Self {
        let mut axis = Axis::usual(random);
        // Farther out, rounding reverses the jerk repeatedly.
        axis.origin = axis.origin.min(1e4);
        let planned = scaled(&axis.limits, 1.0 / 1.2);
        let speed = planned.velocity();
        let size = 0.5 * speed * axis.ramp() * random.decades(1e-4, 5.0);
        let side = if random.percent(50) { 1.0 } else { -1.0 };
        let going = |position: f64, velocity: f64| Kinematics {
            position,
            velocity,
            acceleration: 0.0,
        };
        Self {
            from: going(axis.origin, random.between(-0.8, 0.8) * speed),
            target: going(axis.origin + side * size, random.between(-1.0, 1.0) * speed),
            axis,
        }
    }

    /// Duration of the fastest jerk-limited motion in cycles, in the frame of the target.
    fn bound(&self) -> Option<f64> {
        let limits = &self.axis.limits;
        let (from, to) = (&self.from, &self.target);
        let mut input = InputParameter::<1>::new(None);
        input.current_position[0] = from.position - to.position;
        input.current_velocity[0] = from.velocity - to.velocity;
        // In the frame of the target the limits of the velocity shift by its own.
        input.max_velocity[0] = limits.velocity() - to.velocity;
        input.min_velocity = Some(daov_stack![-limits.velocity() - to.velocity; 1]);
        input.max_acceleration[0] = limits.acceleration();
        input.max_jerk[0] = limits.jerk();
        let mut ruckig = Ruckig::<1, ThrowErrorHandler>::new(None, self.axis.cycle_time);
        let mut trajectory = Trajectory::<1>::new(None);
        ruckig.calculate(&input, &mut trajectory).ok()?;
        Some(trajectory.get_duration() / self.axis.cycle_time)
    }

    fn target_after(&self, cycles: u32) -> Kinematics {
        let way = self.target.velocity * self.axis.cycle_time * f64::from(cycles);
        Kinematics {
            position: self.target.position + way,
            ..self.target
        }
    }

    fn arrival(&self, bound: f64) -> Arrival {
        let limits = &self.axis.limits;
        let t = self.axis.cycle_time;
        let none = (f64::NEG_INFINITY, f64::INFINITY);
        let mut guard = SetValueGuard::new(limits, none.0, none.1, Seconds(t), &self.from).unwrap();
        let (mut acceleration, mut sign, mut reversals) = (0.0, 0.0, 0);
        for cycle in 1.. {
            let guarded = guard.update(&self.target_after(cycle), 1);
            let jerk = (guarded.set.acceleration - acceleration) / (t * limits.jerk());
            acceleration = guarded.set.acceleration;
            // Smaller ones do not count: whole cycles leave such remainders.
            if jerk.abs() > 0.05 {
                reversals += u32::from(jerk * sign < 0.0);
                sign = jerk;
            }
            if guarded.state == GuardState::Tracking && self.stays(guard, cycle) {
                let cycles = f64::from(cycle);
                return Arrival {
                    bound,
                    cycles,
                    reversals,
                };
            }
            assert!(f64::from(cycle) < 2.0 * bound + 1_000.0, "{:?}", self.axis);
        }
        unreachable!("the loop has no end")
    }

    fn stays(&self, mut guard: SetValueGuard, cycle: u32) -> bool {
        (1..100).all(|more| {
            let target = self.target_after(cycle + more);
            let guarded = guard.update(&target, 1);
            guarded.state == GuardState::Tracking && guarded.set == target
        })
    }
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

fn axes_are_back_in_time(ways: u64) {
    let arrivals: Vec<Arrival> = (0..ways)
        .map(|seed| Way::by_chance(&mut Random::seeded(seed)))
        // The generator does not solve every case.
        .filter_map(|way| Some((way.bound()?, way)))
        .filter(|(bound, _)| *bound < 20_000.0)
        .map(|(bound, way)| way.arrival(bound))
        .collect();
    assert!(arrivals.len() as u64 > ways / 2);

    let (short, long): (Vec<Arrival>, Vec<Arrival>) =
        arrivals.iter().partition(|way| way.bound < 100.0);
    let short = sorted(short.iter().map(|way| way.cycles - way.bound).collect());
    let long = sorted(long.iter().map(|way| way.cycles / way.bound).collect());
    for share in [0.5, 0.9, 0.99, 1.0] {
        std::println!(
            "{share}: {:.2} cycles more, {:.4} times the bound",
            quantile(&short, share),
            quantile(&long, share)
        );
    }
    // A short way is a few whole cycles, so its excess counts in cycles, that of a long one as a share.
    assert!(quantile(&short, 0.99) <= 3.0);
    assert!(quantile(&long, 0.99) <= 1.02);
    // Up, down and up again is sufficient; no chatter on the way.
    let reversals = sorted(
        arrivals
            .iter()
            .map(|way| f64::from(way.reversals))
            .collect(),
    );
    assert!(quantile(&reversals, 0.99) <= 3.0 && quantile(&reversals, 1.0) <= 6.0);
}

#[test]
fn an_axis_is_back_about_as_soon_as_it_can() {
    axes_are_back_in_time(1_000);
}

#[test]
#[ignore = "many seconds"]
fn ten_thousand_axes_are_back_about_as_soon_as_they_can() {
    axes_are_back_in_time(10_000);
}
