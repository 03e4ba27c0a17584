//! Demands of a path on the slave: the greatest values along it.

use coaxle_curve::law::polynomial::Polynomial;
use coaxle_curve::law::roots::roots_between_extremes;
use coaxle_curve::law::{Extreme, Extremes, MinMax, Roots};

use super::path_piece::PathPiece;

impl PathPiece {
    /// Computes the demands on the slave while the master runs at `master_velocity`.
    pub(super) fn demands(&self, master_velocity: f64) -> SlaveDemands {
        let rate = master_velocity / self.length;
        // Closed forms first: the extremes of a quintic take up to four searches for roots.
        if self.is_line() {
            return self.demands_of_line(rate);
        }
        match self.rise_of_ramp() {
            Some(rise) => self.demands_of_ramp(rise, rate),
            None => self.demands_from_extremes(rate),
        }
    }

    /// Computes the demands of any course, by the extremes of its quantities.
    fn demands_from_extremes(&self, rate: f64) -> SlaveDemands {
        let velocity = self.displacement.derivative();
        let acceleration = velocity.derivative();
        let jerk = acceleration.derivative();

        // The turns of each quantity are the roots of the next one.
        let jerk_extremes = jerk.derivative().roots_in(0.0, 1.0);
        let acceleration_extremes = roots_between_extremes(&jerk, &jerk_extremes, 0.0, 1.0);
        let velocity_extremes =
            roots_between_extremes(&acceleration, &acceleration_extremes, 0.0, 1.0);
        // By the slope, not the velocity: a master at rest hides no reversal.
        let slope = self.range(&velocity, &velocity_extremes, 1.0);
        let reverses = slope.minimum.value < 0.0 && slope.maximum.value > 0.0;
        let position_extremes = if reverses {
            roots_between_extremes(&velocity, &velocity_extremes, 0.0, 1.0)
        } else {
            Roots::none()
        };

        let square = rate * rate;
        // Derivatives over x become those over time by powers of dx/dt.
        let mut effort = Effort::none(self.begin);
        effort.add(&position_extremes, &acceleration_extremes, |x| {
            DemandSample {
                master: self.master_at(x),
                velocity: velocity.derivatives(x)[0] * rate,
                acceleration: acceleration.derivatives(x)[0] * square,
            }
        });
        SlaveDemands {
            course: Extremes {
                position: mapped(
                    self.range(&self.displacement, &position_extremes, 1.0),
                    |displacement| self.position + displacement,
                ),
                velocity: mapped(slope, |slope| slope * rate),
                acceleration: self.range(&acceleration, &acceleration_extremes, square),
                jerk: self.range(&jerk, &jerk_extremes, square * rate),
            },
            speeding_up: effort.speeding_up,
            slowing_down: effort.slowing_down,
        }
    }

    /// Returns the growth of the slope from begin to end, per length, of a [ramp](Self::ramp) without a
    /// reversal; none for any other course.
    fn rise_of_ramp(&self) -> Option<f64> {
        let [_, from, bend, rise, fourth, fifth] = self.displacement.0;
        // Exact comparisons, since a ramp is built by these very operations.
        let is_ramp = bend == 0.0 && fourth == -rise / 2.0 && fifth == 0.0;
        (is_ramp && from * (from + rise) >= 0.0).then_some(rise)
    }

    /// Computes the demands of a ramp: velocity, position and jerk are extreme at its ends, the
    /// acceleration in the middle.
    fn demands_of_ramp(&self, rise: f64, rate: f64) -> SlaveDemands {
        let (from, square) = (self.displacement.0[1], rate * rate);
        let to = from + rise;
        let middle = DemandSample {
            master: self.master_at(0.5),
            velocity: (from + to) / 2.0 * rate,
            // The peak of 6x(1 − x), half way.
            acceleration: 1.5 * rise * square,
        };
        let mut effort = Effort::none(self.begin);
        effort.add_at(&middle, middle.velocity.signum());
        // The derivative of 6x(1 − x) runs from 6 to −6.
        let jerk = 6.0 * rise * square * rate;
        SlaveDemands {
            course: Extremes {
                position: self.at_ends(self.position, self.position + self.distance()),
                velocity: self.at_ends(from * rate, to * rate),
                acceleration: MinMax::at(self.begin, 0.0)
                    .joined(MinMax::at(middle.master, middle.acceleration)),
                jerk: self.at_ends(jerk, -jerk),
            },
            speeding_up: effort.speeding_up,
            slowing_down: effort.slowing_down,
        }
    }

    fn demands_of_line(&self, rate: f64) -> SlaveDemands {
        let still = MinMax::at(self.begin, 0.0);
        SlaveDemands {
            course: Extremes {
                position: self.at_ends(self.position, self.position + self.displacement.0[1]),
                velocity: MinMax::at(self.begin, self.displacement.0[1] * rate),
                acceleration: still,
                jerk: still,
            },
            speeding_up: still.maximum,
            slowing_down: still.maximum,
        }
    }

    /// Returns the range of a quantity that is extreme at the ends.
    fn at_ends(&self, from: f64, to: f64) -> MinMax {
        MinMax::at(self.begin, from).joined(MinMax::at(self.end(), to))
    }

    fn master_at(&self, x: f64) -> f64 {
        self.begin + x * self.length
    }

    /// Returns the range of a quantity from its extremes, scaled.
    pub(super) fn range<const N: usize>(
        &self,
        quantity: &Polynomial<N>,
        turns: &[f64],
        scale: f64,
    ) -> MinMax {
        let at = |x: f64| MinMax::at(self.master_at(x), quantity.derivatives(x)[0] * scale);
        turns
            .iter()
            .chain(core::iter::once(&1.0))
            .fold(at(0.0), |range, &x| range.joined(at(x)))
    }
}

/// Greatest values along a path, over the master's position and per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SlaveDemands {
    /// Extremes of position, velocity, acceleration and jerk.
    pub(super) course: Extremes,
    /// Greatest acceleration where the slave speeds up, as a magnitude.
    pub(super) speeding_up: Extreme,
    /// Greatest acceleration where it slows down, as a magnitude.
    pub(super) slowing_down: Extreme,
}

impl SlaveDemands {
    /// Returns the demands with other places: the master's positions where the path depends on time.
    pub(super) fn with_places(self, place: impl Fn(f64) -> f64) -> Self {
        let at = |extreme: Extreme| Extreme {
            master: place(extreme.master),
            ..extreme
        };
        let both = |range: MinMax| MinMax {
            minimum: at(range.minimum),
            maximum: at(range.maximum),
        };
        let course = self.course;
        Self {
            course: Extremes {
                position: both(course.position),
                velocity: both(course.velocity),
                acceleration: both(course.acceleration),
                jerk: both(course.jerk),
            },
            speeding_up: at(self.speeding_up),
            slowing_down: at(self.slowing_down),
        }
    }

    pub(super) fn joined(self, next: Self) -> Self {
        Self {
            course: self.course.joined(next.course),
            speeding_up: larger(self.speeding_up, next.speeding_up),
            slowing_down: larger(self.slowing_down, next.slowing_down),
        }
    }
}

/// Accelerations of the slave, separately for either side of standstill.
struct Effort {
    speeding_up: Extreme,
    slowing_down: Extreme,
}

/// State of the slave at one place of its path.
struct DemandSample {
    master: f64,
    velocity: f64,
    acceleration: f64,
}

impl Effort {
    fn none(master: f64) -> Self {
        let nothing = Extreme { master, value: 0.0 };
        Self {
            speeding_up: nothing,
            slowing_down: nothing,
        }
    }

    /// Adds a range. Between two standstills the velocity keeps its sign; there, the acceleration is
    /// extreme at its turns and at the two ends.
    fn add(&mut self, standstills: &[f64], turns: &[f64], at: impl Fn(f64) -> DemandSample) {
        let mut from = 0.0;
        for &to in standstills.iter().chain(core::iter::once(&1.0)) {
            // A path that begins or ends at a standstill has nothing before or behind it, and a velocity
            // of 0 has no sign.
            if to <= from {
                continue;
            }
            // In the middle, away from both standstills: there, rounding decides the sign.
            let direction = at(from + (to - from) / 2.0).velocity.signum();
            self.add_at(&at(from), direction);
            for &turn in turns.iter().filter(|&&turn| turn > from && turn < to) {
                self.add_at(&at(turn), direction);
            }
            self.add_at(&at(to), direction);
            from = to;
        }
    }

    fn add_at(&mut self, sample: &DemandSample, direction: f64) {
        let along = sample.acceleration * direction;
        // A magnitude: limits of acceleration and deceleration have no sign.
        let extreme = Extreme {
            master: sample.master,
            value: along.abs(),
        };
        if along > 0.0 {
            self.speeding_up = larger(self.speeding_up, extreme);
        } else {
            self.slowing_down = larger(self.slowing_down, extreme);
        }
    }
}

fn larger(first: Extreme, second: Extreme) -> Extreme {
    // The first place of equal values stays, as the characteristic values report it.
    if second.value > first.value {
        second
    } else {
        first
    }
}

/// Returns the range of a quantity that rises with this one.
fn mapped(range: MinMax, f: impl Fn(f64) -> f64) -> MinMax {
    let map = |extreme: Extreme| Extreme {
        value: f(extreme.value),
        ..extreme
    };
    MinMax {
        minimum: map(range.minimum),
        maximum: map(range.maximum),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Returns the values of both, and their places.
    fn values(demands: &SlaveDemands) -> [(f64, f64); 10] {
        let course = &demands.course;
        let extremes = [
            course.position.minimum,
            course.position.maximum,
            course.velocity.minimum,
            course.velocity.maximum,
            course.acceleration.minimum,
            course.acceleration.maximum,
            course.jerk.minimum,
            course.jerk.maximum,
            demands.speeding_up,
            demands.slowing_down,
        ];
        extremes.map(|extreme| (extreme.master, extreme.value))
    }

    /// A slave that starts at rest towards smaller positions was taken to slow down, by all of its acceleration.
    #[test]
    fn a_start_from_rest_slows_nothing_down_either_way() {
        for side in [1.0, -1.0] {
            let ramp = PathPiece::curved_ramp(0.0, 2.0, 0.0, (0.0, side * 3.0), side * 4.0);
            let demands = ramp.demands(1.0);
            assert!(demands.speeding_up.value >= 2.99, "{side}: {demands:?}");
            assert!(demands.slowing_down.value < 1e-9, "{side}: {demands:?}");
            let back = PathPiece::quintic(0.0, 2.0, (0.0, side * 2.0, 0.0), (side * 2.0, 0.0));
            assert!(back.demands(1.0).speeding_up.value < 1e-9, "{side}");
        }
    }

    proptest! {
        /// A ramp's demands in closed form are those found by its extremes.
        #[test]
        fn a_ramp_demands_what_its_turns_say(
            begin in -1e3..1e3,
            length in prop_oneof![-500.0..-0.1_f64, 0.1..500.0_f64],
            position in -1e3..1e3,
            (from, to) in (prop_oneof![Just(0.0), -3.0..3.0], prop_oneof![Just(0.0), -3.0..3.0]),
            speed in 0.0..2e3_f64,
        ) {
            let ramp = PathPiece::ramp(begin, length, position, from, to);
            let rate = speed.copysign(length) / length;
            let expected = values(&ramp.demands_from_extremes(rate));
            prop_assume!(!ramp.is_line());
            for (got, expected) in values(&ramp.demands(rate * length)).into_iter().zip(expected) {
                let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (1.0 + a.abs().max(b.abs()));
                prop_assert!(near(got.1, expected.1), "{got:?} for {expected:?}");
                prop_assert!(near(got.0, expected.0), "{got:?} for {expected:?}");
            }
        }
    }
}
