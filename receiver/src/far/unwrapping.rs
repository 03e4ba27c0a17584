//! Positions within a modulo period, made continuous, and unexpected wraps.

use coaxle_axis::Modulo;
use coaxle_curve::profile::Kinematics;

/// Makes positions within a modulo period continuous: selects the period nearest to the position
/// that the velocity predicts. The result is right while that error is below half a period, so
/// whole silences are bridged at a steady velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unwrapping {
    length: f64,
    newest: Option<Kinematics>,
}

impl Unwrapping {
    pub(super) const fn new(modulo: Modulo) -> Self {
        Self {
            length: modulo.length(),
            newest: None,
        }
    }

    /// Makes set values continuous; `passed` are the seconds since the previous ones.
    pub(super) fn unwrapped(&mut self, set: &Kinematics, passed: f64) -> Kinematics {
        let position = match &self.newest {
            None => set.position,
            Some(last) => {
                // The mean of both velocities is exact while the acceleration is constant, so that a ramp during a
                // silence is bridged as well.
                let expected = last.position + mean_velocity(last, set) * passed;
                let turns = libm::round((expected - set.position) / self.length);
                set.position + turns * self.length
            }
        };
        let set = Kinematics { position, ..*set };
        self.newest = Some(set);
        set
    }

    /// Makes set values continuous that are `passed` seconds after the newest ones; before them if negative.
    pub(super) fn beside(&self, set: &Kinematics, passed: f64) -> Kinematics {
        let Some(newest) = &self.newest else {
            return *set;
        };
        let expected = newest.position + mean_velocity(newest, set) * passed;
        let turns = libm::round((expected - set.position) / self.length);
        Kinematics {
            position: set.position + turns * self.length,
            ..*set
        }
    }

    /// Begins another run, or another node: the axis is in the period nearest to its previous position.
    pub(super) fn begin_run(&mut self) {
        if let Some(newest) = &mut self.newest {
            // The old velocity says nothing about the new run. Without one the prediction is the last position.
            *newest = Kinematics::at_rest(newest.position);
        }
    }
}

/// Wraps of positions that are taken for continuous ones.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wraps {
    pub(super) count: u32,
    /// Size of the newest jump of the position, u.
    pub(super) length: Option<f64>,
}

/// A wrap is a jump of at least this number of ways of a cycle, …
const FAR: f64 = 8.0;
/// … against the velocity, from one end of a period to the other: one end is 0, or the two are each
/// other's opposite, to within this number of ways.
const NEAR: f64 = 2.0;

impl Wraps {
    /// Takes set values, a few cycles and `passed` seconds after the previous ones.
    pub(super) fn take(&mut self, last: &Kinematics, set: &Kinematics, passed: f64) {
        let way = mean_velocity(last, set) * passed;
        let jump = set.position - last.position - way;
        // A preset position jumps either way. Only a wrap always jumps against the motion.
        let is_far = jump.abs() > FAR * way.abs() && jump * way < 0.0;
        let near = NEAR * way.abs();
        let is_at_an_end = last.position.abs() <= near || set.position.abs() <= near;
        let is_symmetric = (last.position + set.position).abs() <= near;
        if is_far && (is_at_an_end || is_symmetric) {
            // Months of turning would otherwise wrap the count itself, and the first wrap be reported again.
            self.count = self.count.saturating_add(1);
            self.length = Some(jump.abs());
        }
    }
}

fn mean_velocity(last: &Kinematics, set: &Kinematics) -> f64 {
    0.5 * (last.velocity + set.velocity)
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: f64 = 2e-3;

    fn at(position: f64, velocity: f64) -> Kinematics {
        Kinematics {
            position,
            velocity,
            acceleration: 0.0,
        }
    }

    /// Set values of an axis at a steady velocity, in frames a cycle apart.
    fn turning(velocity: f64, from: f64, begin: f64) -> impl Iterator<Item = (f64, Kinematics)> {
        (0..3_000).map(move |k| {
            let position = from + velocity * T * f64::from(k);
            let within = (position - begin).rem_euclid(360.0) + begin;
            (position, at(within, velocity))
        })
    }

    #[test]
    fn positions_within_the_turn_become_continuous_either_way_and_over_a_silence() {
        for velocity in [360.0, -360.0, 60_000.0] {
            for begin in [0.0, -180.0] {
                let mut turns = Unwrapping::new(Modulo::new(360.0).unwrap());
                let mut passed = 0.0;
                for (k, (position, set)) in turning(velocity, 90.0, begin).enumerate() {
                    passed += T;
                    // Half a second of silence.
                    if (1_000..1_250).contains(&k) {
                        continue;
                    }
                    let unwrapped = turns.unwrapped(&set, passed).position;
                    assert!(
                        (unwrapped - position).abs() < 1e-6,
                        "{velocity} {k}: {unwrapped}"
                    );
                    passed = 0.0;
                }
            }
        }
    }

    #[test]
    fn another_run_goes_on_in_the_nearest_turn() {
        let mut turns = Unwrapping::new(Modulo::new(360.0).unwrap());
        for (_, set) in turning(360.0, 0.0, 0.0) {
            let _ = turns.unwrapped(&set, T);
        }
        turns.begin_run();
        let unwrapped = turns.unwrapped(&at(10.0, 360.0), 5.0).position;
        assert!((unwrapped - 2_170.0).abs() <= 1_800.0 && (unwrapped - 10.0) % 360.0 == 0.0);
    }

    #[test]
    fn a_wrap_is_found_and_nothing_else_is() {
        for (velocity, begin) in [(360.0, 0.0), (-360.0, 0.0), (360.0, -180.0)] {
            let sets: Vec<_> = turning(velocity, 90.0, begin).map(|(_, set)| set).collect();
            let mut wraps = Wraps::default();
            sets.windows(2).for_each(|w| wraps.take(&w[0], &w[1], T));
            assert!(
                (5..=6).contains(&wraps.count),
                "{velocity} {begin}: {wraps:?}"
            );
            assert!((wraps.length.unwrap() - 360.0).abs() < 1e-6);
        }
        let mut wraps = Wraps::default();
        // A preset position, a rest, a reversal.
        wraps.take(&at(500.0, 100.0), &at(80.0, 100.0), T);
        wraps.take(&at(80.0, 0.0), &at(80.0, 0.0), T);
        wraps.take(&at(0.0, 1.0), &at(-0.002, -1.0), T);
        assert_eq!(wraps.count, 0);
    }
}
