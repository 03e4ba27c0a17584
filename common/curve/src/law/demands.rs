//! Demands of a law beyond its extremes: on a drive, and as a mean.

use super::motion::{MinMax, Motion};
use super::polynomial::Polynomial;
use super::segment::{LawShape, Segment};
use crate::quadrature::{integral, integral_of_polynomial};

impl Segment {
    /// Returns the extremes of velocity times acceleration, at a master velocity of 1.
    #[must_use]
    pub fn momentum(&self) -> MinMax {
        match self.shape() {
            // Degrees of v·a: 4 + 3 and 6 + 5, with one coefficient more.
            LawShape::Quintic(polynomial) => self.momentum_at_extremes::<6, 8>(polynomial),
            LawShape::Septic(polynomial) => self.momentum_at_extremes::<8, 12>(polynomial),
            _ => self.momentum_by_sections(),
        }
    }

    /// Returns the slave's whole path length, forwards and backwards: the integral of |velocity|.
    #[must_use]
    pub fn path_length(&self) -> f64 {
        match self.shape() {
            LawShape::Quintic(polynomial) => path_length(polynomial),
            LawShape::Septic(polynomial) => path_length(polynomial),
            _ => self.length() * integral(0.0, 1.0, |share| self.at_share(share).velocity.abs()),
        }
    }

    /// Returns the integral of the acceleration's square.
    #[must_use]
    pub fn squared_acceleration(&self) -> f64 {
        let square = |share: f64| {
            let acceleration = self.at_share(share).acceleration;
            acceleration * acceleration
        };
        let over_share = match self.shape() {
            // The square has degree 10 at most, within the 19 of the rule.
            LawShape::Quintic(_) | LawShape::Septic(_) => integral_of_polynomial(0.0, 1.0, square),
            _ => integral(0.0, 1.0, square),
        };
        self.length() * over_share
    }

    fn length(&self) -> f64 {
        self.end() - self.start()
    }

    fn momentum_at(&self, share: f64) -> MinMax {
        let motion = self.at_share(share);
        MinMax::at(self.master_at(share), motion.velocity * motion.acceleration)
    }

    /// Returns the momentum range of a polynomial: at the ends, and where the slope of the product of its
    /// derivatives is zero. `M` coefficients hold the product.
    fn momentum_at_extremes<const N: usize, const M: usize>(&self, law: &Polynomial<N>) -> MinMax {
        let velocity = law.derivative();
        let product = velocity.product::<N, M>(&velocity.derivative());
        let extremes = product.derivative().roots_in(0.0, 1.0);
        let ends = self.momentum_at(0.0).joined(self.momentum_at(1.0));
        extremes
            .iter()
            .fold(ends, |range, &share| range.joined(self.momentum_at(share)))
    }

    /// Returns the momentum range of any law. Each extreme is found by a change of sign of the slope a² +
    /// v·j, and narrowed down to the last bit.
    fn momentum_by_sections(&self) -> MinMax {
        let share_of = |i: u32| f64::from(i) / f64::from(SECTIONS);
        let rises_at = |share: f64| {
            let Motion {
                velocity,
                acceleration,
                jerk,
                ..
            } = self.at_share(share);
            acceleration * acceleration + velocity * jerk > 0.0
        };
        let mut range = self.momentum_at(0.0).joined(self.momentum_at(1.0));
        for i in 0..SECTIONS {
            let (mut low, mut high) = (share_of(i), share_of(i + 1));
            let rises = rises_at(low);
            // By sign, not by value: a jump of the jerk changes it without a zero.
            if rises_at(high) != rises {
                loop {
                    let middle = low + (high - low) / 2.0;
                    // No number lies between: `low` and `high` are the last bits on either side.
                    if middle <= low || middle >= high {
                        break;
                    }
                    if rises_at(middle) == rises {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
            }
            range = range
                .joined(self.momentum_at(low))
                .joined(self.momentum_at(high));
        }
        range
    }
}

/// Number of intervals in which the extremes of v·a are searched for. All laws together have fewer than a
/// tenth as many.
const SECTIONS: u32 = 64;

/// Returns the path length: between two extremes a curve is monotone, so its length is the difference of
/// its values.
fn path_length<const N: usize>(law: &Polynomial<N>) -> f64 {
    // Far from zero positions are rounded, and so are their differences.
    let mut from_start = *law;
    from_start.0[0] = 0.0;
    let extremes = law.derivative().roots_in(0.0, 1.0);
    let (mut length, mut before) = (0.0, 0.0);
    for &place in extremes.iter().chain(core::iter::once(&1.0)) {
        let here = from_start.value(place);
        length += (here - before).abs();
        before = here;
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Knot, MotionLaw};
    use proptest::prelude::*;
    use std::vec::Vec;

    fn knot() -> impl Strategy<Value = Motion> {
        let of_any_size =
            || (-1.0..1.0, -3..4).prop_map(|(m, e)| m * libm::pow(10.0, f64::from(e)));
        let derivatives = prop_oneof![
            1 => Just([0.0; 3]),
            2 => [-5.0..5.0, -1.0..1.0, -0.1..0.1],
            1 => [of_any_size(), of_any_size(), of_any_size()],
        ];
        (-100.0..100.0, derivatives).prop_map(|(position, [velocity, acceleration, jerk])| Motion {
            position,
            velocity,
            acceleration,
            jerk,
        })
    }

    fn polynomials() -> impl Strategy<Value = Segment> {
        let law = prop::sample::select(
            &[
                MotionLaw::Polynom1,
                MotionLaw::Polynom3Vv,
                MotionLaw::Polynom5Mm,
                MotionLaw::Polynom7Mm,
            ][..],
        );
        (law, -1e3..1e3, 0.01..50.0, [knot(), knot()]).prop_map(|(law, start, length, motions)| {
            let [start, end] = [(start, 0), (start + length, 1)].map(|(master, side)| Knot {
                master,
                motion: motions[side],
            });
            Segment::new(law, &start, &end).expect("these laws lead from any motion to any other")
        })
    }

    /// Returns the path length by quadrature between the extremes, each of which bends |v|: a bend near
    /// an end could lie between the nodes of an integral.
    fn path_length_by_numbers(segment: &Segment) -> f64 {
        let extremes = match segment.shape() {
            LawShape::Quintic(law) => law.derivative().roots_in(0.0, 1.0),
            LawShape::Septic(law) => law.derivative().roots_in(0.0, 1.0),
            shape => panic!("{shape:?}"),
        };
        let speed = |share: f64| segment.at_share(share).velocity.abs();
        let places: Vec<_> = [&[0.0], &extremes[..], &[1.0]].concat();
        let pieces = places.windows(2);
        segment.length()
            * pieces
                .map(|ends| integral_of_polynomial(ends[0], ends[1], speed))
                .sum::<f64>()
    }

    fn close(received: f64, expected: f64, size: f64) -> Result<(), TestCaseError> {
        prop_assert!(
            (received - expected).abs() <= 1e-12 * size,
            "received {received}, expected {expected}"
        );
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]

        #[test]
        fn polynomials_demand_what_any_law_would_by_numbers(segment in polynomials()) {
            let (exact, searched) = (segment.momentum(), segment.momentum_by_sections());
            let size = searched.magnitude();
            close(exact.minimum.value, searched.minimum.value, size)?;
            close(exact.maximum.value, searched.maximum.value, size)?;
            let path_length = path_length_by_numbers(&segment);
            close(segment.path_length(), path_length, path_length)?;
            let square = segment.length()
                * integral(0.0, 1.0, |z| {
                    let acceleration = segment.at_share(z).acceleration;
                    acceleration * acceleration
                });
            close(segment.squared_acceleration(), square, square)?;
        }

        #[test]
        fn no_sample_is_beyond_the_momentum(segment in polynomials()) {
            let range = segment.momentum();
            let slack = 1e-12 * range.magnitude();
            for i in 0..=1_000 {
                let motion = segment.at_share(f64::from(i) / 1e3);
                let momentum = motion.velocity * motion.acceleration;
                prop_assert!(range.minimum.value - slack <= momentum);
                prop_assert!(momentum <= range.maximum.value + slack);
            }
        }
    }

    #[test]
    fn a_line_has_a_way_and_no_momentum() {
        let at = |master, position| Knot {
            master,
            motion: Motion {
                position,
                ..Motion::default()
            },
        };
        let line = Segment::new(MotionLaw::Polynom1, &at(2.0, 1e9 + 3.0), &at(6.0, 1e9)).unwrap();
        assert_eq!(line.path_length(), 3.0);
        assert_eq!(line.squared_acceleration(), 0.0);
        assert_eq!(line.momentum().magnitude(), 0.0);
    }
}
