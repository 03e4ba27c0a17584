//! Limits of what a drive is given later than it was calculated.

use coaxle_curve::profile::Limits;
use coaxle_receiver::signals::SlaveSignals;
use coaxle_sim::SetValueCheck;

use super::found::{Found, WatchedCycle};

/// Greatest share of the time by which a lag, and the hold-back that it leaves, are slewed: 0.94 ‰.
pub(super) const LARGEST_SLEW: f64 = 1e-3;
/// Greatest factor by which a motion is shown faster than it was calculated, while the hold-back falls.
pub(super) const SHOWN_FASTER: f64 = 1.0 + LARGEST_SLEW;

/// Greatest change of that rate, 1/s: the quintic over a change by one cycle of 0.1 ms, which takes 0.2 s, has 5.8 · 1 ‰ / 1.9 / 0.2 s.
const RATE_CHANGE: f64 = 0.015;

/// Greatest acceleration between two cycles, as a part of the limit. With velocities that are off by half a cycle of the jerk, an axis that is
/// accelerated at its limit goes in waves of as much as its jerk adds in a cycle.
const BETWEEN: f64 = 1.5;

/// Watches the set values that a drive is given.
#[derive(Debug)]
pub(super) struct ShownWatch {
    check: SetValueCheck,
    cycle_time: f64,
    /// Time for which what is shown lies in skipped cycles, or may, s.
    unknown_for: f64,
}

impl ShownWatch {
    /// `limits` are those of the axis, in a node of this cycle time, s, whose drive has a dead time of `ahead` s.
    pub(super) fn new(limits: &Limits, cycle_time: f64, ahead: f64) -> Self {
        // Predicted by velocity and acceleration, which are those of half a cycle and of a cycle before: where the jerk turns, the velocity steps by
        // its share of the square.
        let ahead = if ahead > 0.0 { ahead + cycle_time } else { 0.0 };
        let step = limits.jerk() * ahead * ahead;
        let velocity = limits.velocity() * SHOWN_FASTER + step;
        let predicted = limits.jerk() * ahead + step / cycle_time;
        let [acceleration, deceleration] = [limits.acceleration(), limits.deceleration()]
            .map(|most| (most + predicted) * BETWEEN + velocity * RATE_CHANGE);
        let limits = Limits::new(velocity, acceleration, deceleration, limits.jerk());
        Self {
            check: SetValueCheck::new(
                &limits.expect("a little more than limits"),
                [f64::NEG_INFINITY, f64::INFINITY],
                cycle_time,
            ),
            cycle_time,
            unknown_for: 0.0,
        }
    }

    pub(super) fn push(
        &mut self,
        cycle: &WatchedCycle,
        slave: &SlaveSignals,
        begins_anew: bool,
        found: &mut Found,
    ) {
        let cycles = cycle.since.unwrap_or(1);
        self.unknown_for -= f64::from(cycles) * self.cycle_time;
        if cycles > 1 {
            // Between the set values around skipped cycles lies a curve that knows no limits, and it is shown a hold-back later.
            self.unknown_for = slave.held_back_us * 1e-6 + 4.0 * self.cycle_time;
        }
        if begins_anew || self.unknown_for > 0.0 {
            self.check.restart();
        }
        // A hold-back that is slewed shows places between two cycles, from velocities beside the positions by up to half a cycle of the jerk.
        self.check.free_jerk();
        let Some(position) = slave.shown_position else {
            return;
        };
        self.check.push(position, cycles, |excess| {
            found.add(cycle, excess.bound.into(), excess.value, excess.limit);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::invariants::WatchedPart;

    const T: f64 = 1e-3;

    /// Cycles in which a bound is exceeded, of an axis at its velocity limit that is shown at this pace.
    fn found(pace: f64, step: f64) -> usize {
        let limits = Limits::new(300.0, 5_000.0, 5_000.0, 100_000.0).expect("limits");
        let mut watch = ShownWatch::new(&limits, T, 0.0);
        let mut found = Found::default();
        for number in 0..1_000_u32 {
            let jumped = if number >= 500 { step } else { 0.0 };
            let slave = SlaveSignals {
                shown_position: Some(300.0 * pace * T * f64::from(number) + jumped),
                ..SlaveSignals::default()
            };
            let cycle = WatchedCycle {
                number: number.into(),
                t_s: T * f64::from(number),
                since: Some(1),
            };
            watch.push(&cycle, &slave, number == 0, &mut found);
        }
        let of = WatchedPart {
            receiver: "saw".to_owned(),
            part: None,
        };
        found.violations(of).count()
    }

    #[test]
    fn a_slew_of_the_hold_back_passes_and_a_step_of_the_drive_is_found() {
        assert_eq!(found(1.0, 0.0), 0);
        assert_eq!(found(1.000_94, 0.0), 0);
        assert_ne!(found(1.002, 0.0), 0);
        assert_ne!(found(1.0, 1e-3), 0);
    }
}
