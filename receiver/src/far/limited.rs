//! The limits of a far axis that has some of its own.

use coaxle_axis::set_value_guard::{GuardState, SetValueGuard};
use coaxle_clock::{CycleTime, Seconds};
use coaxle_curve::profile::{Kinematics, Limits};

/// Keeps the limits by the differences of its positions, in any state of its node.
#[derive(Debug)]
pub(super) struct Limited {
    limits: Limits,
    cycle: Seconds,
    /// Guard; none before its first set values.
    guard: Option<SetValueGuard>,
    is_at_target: bool,
}

impl Limited {
    pub(super) fn new(limits: Limits, cycle: CycleTime) -> Self {
        Self {
            limits,
            cycle: Seconds(cycle.as_secs_f64()),
            guard: None,
            is_at_target: true,
        }
    }

    /// Limits set values, `elapsed` cycles after the last ones. Those of a mode that shows values as received step by up to `beat`, u.
    pub(super) fn keep(&mut self, set: &Kinematics, elapsed: u32, beat: f64) -> Kinematics {
        let Some(guard) = &mut self.guard else {
            // Software limits belong to the axis at its own node.
            let (min, max) = (f64::NEG_INFINITY, f64::INFINITY);
            let start = self.within(set);
            // The config has checked the limits. Should the guard refuse them all the same, a state within them is
            // shown.
            self.guard = SetValueGuard::new(&self.limits, min, max, self.cycle, &start).ok();
            return start;
        };
        let left = guard.update(set, elapsed);
        // Set values in beats are on either side of the motion that they are of, by up to a beat, and an axis that cannot step goes on
        // between them: swarm schedules 143 and 630 were never following, and 0.01 u beside set values that stepped by 0.03 u.
        self.is_at_target = left.state == GuardState::Tracking || left.distance.abs() <= beat;
        left.set
    }

    /// Initial state of an axis, within its limits: with an acceleration beyond them it would be
    /// led away until the jerk limit ends that, and at 3 900 mm/s³ from 4 900 mm/s² on those were
    /// two metres.
    fn within(&self, set: &Kinematics) -> Kinematics {
        let (velocity, push) = (
            self.limits.velocity(),
            // The lower of the two holds whichever way the axis goes.
            self.limits.acceleration().min(self.limits.deceleration()),
        );
        let is_within = set.velocity.abs() <= velocity && set.acceleration.abs() <= push;
        Kinematics {
            position: set.position,
            velocity: set.velocity.clamp(-velocity, velocity),
            // Not clamped: beside a clamped velocity an acceleration would be one of another motion.
            acceleration: if is_within { set.acceleration } else { 0.0 },
        }
    }

    /// True if the last set values were left unchanged, or but for their beats.
    pub(super) const fn is_at_target(&self) -> bool {
        self.is_at_target
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::Span;

    const T: f64 = 0.00025;

    /// Found in a random schedule: the axis was led 1.8 m away from a master that never left 150 mm.
    #[test]
    fn an_axis_that_begins_beyond_its_limits_is_not_led_away() {
        let limits = Limits::new(867.0, 213.0, 213.0, 3_857.0).unwrap();
        let cycle = CycleTime::new(Span::from_micros(250)).unwrap();
        let mut limited = Limited::new(limits, cycle);
        let master = |k: u32| {
            let w = 8.0;
            let t = f64::from(k) * T;
            Kinematics {
                position: -150.0 * f64::cos(w * t + 1.0),
                velocity: 150.0 * w * f64::sin(w * t + 1.0),
                acceleration: 150.0 * w * w * f64::cos(w * t + 1.0),
            }
        };
        let mut before = limited.keep(&master(0), 1, 0.0);
        let mut velocity = before.velocity;
        for k in 1..20_000 {
            let set = limited.keep(&master(k), 1, 0.0);
            let now = (set.position - before.position) / T;
            let pull = (now - velocity) / T;
            assert!(k < 3 || pull.abs() <= 213.0 * (1.0 + 1e-6), "{k}: {pull}");
            assert!((set.velocity - now).abs() < 0.1, "{k}: {set:?} {now}");
            (before, velocity) = (set, now);
        }
    }
}
