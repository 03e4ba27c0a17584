//! A motion law compiled between two points.

use super::arc::Chain;
use super::blend::BlendedLaw;
use super::boundary;
use super::error::{LawError, Quantity, Side};
use super::harmonic::{self, Combination, Turn};
use super::high_degree::{self, HighDegree, RestToRest};
use super::motion::{Extremes, Knot, MinMax, Motion};
use super::motion_law::MotionLaw;
use super::polynom;
use super::polynomial::Polynomial;
use super::roots::{LessTarget, Roots, roots_between_extremes};
use super::{sine, trapezoid};

/// A piece of a cam between two points: a motion law in closed form. Plain data of a fixed size.
///
/// Its formula continues beyond its ends; the caller keeps within them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Master position at the share z = 0 of the segment: the start, or the end of a law that is the
    /// mirror image of another.
    from: f64,
    /// Master position where z = 1.
    to: f64,
    /// 1/(`to` − `from`).
    rate: f64,
    shape: LawShape,
}

/// A law over the share z = 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LawShape {
    Quintic(Polynomial<6>),
    Septic(Polynomial<8>),
    HighDegree(RestToRest),
    Blend(BlendedLaw),
    Combination(Combination),
}

impl Segment {
    /// Compiles a law from one point to the next; a harmonic combination with its default turning point.
    ///
    /// # Errors
    /// See [`Segment::with_turn`].
    pub fn new(law: MotionLaw, start: &Knot, end: &Knot) -> Result<Self, LawError> {
        Self::with_turn(law, start, end, Turn::Default)
    }

    /// Compiles a law from one point to the next, with the turning point of a harmonic combination.
    ///
    /// # Errors
    /// [`LawError`] if a number is not finite, the segment has no length or too little of it, a point contradicts the law's
    /// condition there (to 1e-9 of the stroke), no such turning point exists, or the law is a spline.
    pub fn with_turn(
        law: MotionLaw,
        start: &Knot,
        end: &Knot,
        turn: Turn,
    ) -> Result<Self, LawError> {
        // First, so that the length below is finite and above 0.
        boundary::check(law, start, end)?;
        // Without a stroke no turning point gives an acceleration,
        // so a harmonic combination would be refused.
        let law = if dwells(law, start, end) {
            MotionLaw::Polynom1
        } else {
            law
        };
        let (from, to) = if is_mirrored(law) {
            (end, start)
        } else {
            (start, end)
        };
        let length = to.master - from.master;
        let points = [from.motion, to.motion].map(|motion| scaled(&motion, length));
        representable(&points).map_err(|(is_to, quantity)| {
            // Points of a mirrored law are swapped, but the message names the user's side.
            let (side, knot) = if is_to == is_mirrored(law) {
                (Side::Start, start)
            } else {
                (Side::End, end)
            };
            LawError::NotFinite {
                side,
                quantity,
                received: component(&knot.motion, quantity),
            }
        })?;
        let segment = Self {
            from: from.master,
            to: to.master,
            // Kept, so that a cycle multiplies instead of dividing.
            rate: 1.0 / length,
            shape: shape(law, &points, turn, length)?,
        };
        // Below some 1e-103 the cube of the rate overflows: 0 at an end of a law times it is no number, and anything
        // else inside is infinite.
        if [0.0, 0.25, 0.5, 1.0]
            .iter()
            .any(|z| !is_finite(&segment.at_z(*z)))
        {
            return Err(LawError::TooShort {
                received: length.abs(),
            });
        }
        Ok(segment)
    }

    /// Makes a cubic, by its `coefficients` of the powers 0 to 3 of (master − `start_master`): a piece
    /// of a spline.
    #[must_use]
    pub fn cubic(start_master: f64, end_master: f64, coefficients: [f64; 4]) -> Self {
        let length = end_master - start_master;
        // A spline has thousands of cubics: the quintic carries
        // two zeros more, but needs no case of its own.
        let [c0, c1, c2, c3] = coefficients;
        let scaled = [
            c0,
            c1 * length,
            c2 * length * length,
            c3 * length * length * length,
            0.0,
            0.0,
        ];
        Self {
            from: start_master,
            to: end_master,
            rate: 1.0 / length,
            shape: LawShape::Quintic(Polynomial(scaled)),
        }
    }

    /// Returns the master position of the start.
    #[inline]
    #[must_use]
    pub const fn start(&self) -> f64 {
        if self.rate < 0.0 { self.to } else { self.from }
    }

    /// Returns the master position of the end.
    #[inline]
    #[must_use]
    pub const fn end(&self) -> f64 {
        if self.rate < 0.0 { self.from } else { self.to }
    }

    /// Returns the slave at a master position.
    #[inline]
    #[must_use]
    pub fn at(&self, master: f64) -> Motion {
        self.at_z((master - self.from) * self.rate)
    }

    /// Returns the slave at a share of the segment, 0 at its start and 1 at its end. Computations over
    /// many places of one segment use shares: far from zero masters are rounded, and their differences
    /// are noise.
    #[must_use]
    pub fn at_share(&self, share: f64) -> Motion {
        self.at_z(self.z_of(share))
    }

    /// Returns the master position of a share, 0 at the start and 1 at the end.
    #[must_use]
    pub fn master_at(&self, share: f64) -> f64 {
        self.master(self.z_of(share))
    }

    /// Returns the formula. For polynomials the share is that of the segment.
    pub(super) const fn shape(&self) -> &LawShape {
        &self.shape
    }

    fn z_of(&self, share: f64) -> f64 {
        if self.rate < 0.0 { 1.0 - share } else { share }
    }

    #[inline]
    fn at_z(&self, z: f64) -> Motion {
        // A `match`, not a trait object: segments stay plain
        // data of one size, copied without an allocation.
        let over_z = match &self.shape {
            LawShape::Quintic(polynomial) => motion(polynomial.derivatives(z)),
            LawShape::Septic(polynomial) => motion(polynomial.derivatives(z)),
            LawShape::HighDegree(law) => law.at(z),
            LawShape::Blend(law) => law.at(z),
            LawShape::Combination(law) => law.at(z),
        };
        scaled(&over_z, self.rate)
    }

    /// Returns the extremes of position and derivatives from start to end, exactly: from the roots of
    /// derivatives.
    #[must_use]
    pub fn extremes(&self) -> Extremes {
        let ranges = match &self.shape {
            LawShape::Quintic(polynomial) => polynomial.ranges_in(0.0, 1.0),
            LawShape::Septic(polynomial) => polynomial.ranges_in(0.0, 1.0),
            LawShape::HighDegree(law) => law.ranges(),
            LawShape::Blend(law) => law.ranges(),
            LawShape::Combination(law) => law.ranges(),
        };
        let rate = self.rate;
        let over_master = |range: MinMax, factor| range.map(factor, |z| self.master(z));
        Extremes {
            position: over_master(ranges[0], 1.0),
            velocity: over_master(ranges[1], rate),
            acceleration: over_master(ranges[2], rate * rate),
            jerk: over_master(ranges[3], rate * rate * rate),
        }
    }

    /// Returns the master positions from start to end at which the slave reaches `position`, ascending.
    /// Of a range along which it rests there, only the begin is returned.
    #[must_use]
    pub fn masters_at(&self, position: f64) -> Roots {
        let shares = match &self.shape {
            LawShape::Quintic(polynomial) => shares_at(polynomial, position),
            LawShape::Septic(polynomial) => shares_at(polynomial, position),
            LawShape::HighDegree(law) => law.shares_at(position),
            LawShape::Blend(law) => law.shares_at(position),
            LawShape::Combination(law) => law.shares_at(position),
        };
        let masters = shares.map(|z| self.master(z));
        if self.rate < 0.0 {
            // Shares of a mirrored law run from the end to the start.
            masters.reversed()
        } else {
            masters
        }
    }

    /// Returns the master position of a share, from the nearer end: exact at both.
    fn master(&self, z: f64) -> f64 {
        let length = self.to - self.from;
        if z <= 0.5 {
            self.from + z * length
        } else {
            self.to - (1.0 - z) * length
        }
    }
}

/// True if a law, mirrored or not, keeps the slave at rest.
fn dwells(law: MotionLaw, start: &Knot, end: &Knot) -> bool {
    let (start, end) = (&start.motion, &end.motion);
    // With an acceleration at a point the slave leaves its position and comes back.
    let may_leave = matches!(law, MotionLaw::Polynom5Mm | MotionLaw::Polynom7Mm) || law.is_spline();
    start.position == end.position && start.velocity == 0.0 && end.velocity == 0.0 && !may_leave
}

/// True for laws that are another one reversed, from the end.
const fn is_mirrored(law: MotionLaw) -> bool {
    matches!(
        law,
        MotionLaw::HarmonicKombiTr
            | MotionLaw::HarmonicKombiTv
            | MotionLaw::BeschltrapezTr
            | MotionLaw::BeschltrapezVr
    )
}

fn shape(
    law: MotionLaw,
    [from, to]: &[Motion; 2],
    turn: Turn,
    length: f64,
) -> Result<LawShape, LawError> {
    let (start, end) = (from.position, to.position);
    let stroke = end - start;
    let rest = |motion: &Motion| Motion {
        position: motion.position,
        ..Motion::default()
    };
    let high_degree =
        |law: &'static HighDegree| LawShape::HighDegree(RestToRest { start, end, law });
    let single = |arcs| LawShape::Blend(BlendedLaw::single(start, stroke, arcs));
    Ok(match law {
        MotionLaw::Polynom1 => LawShape::Quintic(polynom::line(start, end)),
        MotionLaw::Polynom3 => LawShape::Quintic(polynom::cubic(&rest(from), &rest(to))),
        MotionLaw::Polynom3Vv => LawShape::Quintic(polynom::cubic(from, to)),
        MotionLaw::Polynom5 => LawShape::Quintic(polynom::quintic(&rest(from), &rest(to))),
        MotionLaw::Polynom5Mm => LawShape::Quintic(polynom::quintic(from, to)),
        MotionLaw::Polynom7 => LawShape::Septic(polynom::septic(&rest(from), &rest(to))),
        MotionLaw::Polynom7Mm => LawShape::Septic(polynom::septic(from, to)),
        MotionLaw::Polynom8 => high_degree(&high_degree::POLYNOM8),
        MotionLaw::Polynom9 => high_degree(&high_degree::POLYNOM9),
        MotionLaw::Polynom11 => high_degree(&high_degree::POLYNOM11),
        MotionLaw::Peisekah11 => high_degree(&high_degree::PEISEKAH11),
        MotionLaw::Sinuslinie => single(&sine::SINUSLINIE),
        MotionLaw::Bestehorn => single(&sine::BESTEHORN),
        MotionLaw::Modsinuslinie => single(&sine::MODSINUSLINIE),
        MotionLaw::ModsinuslinieVv => LawShape::Blend(sine::between_velocities(
            start,
            stroke,
            from.velocity,
            to.velocity,
        )),
        MotionLaw::Beschltrapez => single(&trapezoid::BESCHLTRAPEZ),
        MotionLaw::BeschltrapezRt | MotionLaw::BeschltrapezTr => {
            single(&trapezoid::BESCHLTRAPEZ_RT)
        }
        MotionLaw::BeschltrapezRv | MotionLaw::BeschltrapezVr => {
            LawShape::Blend(trapezoid::to_velocity(start, stroke, to.velocity))
        }
        MotionLaw::HarmonicKombiRt | MotionLaw::HarmonicKombiTr => {
            combination(&rest(from), stroke, turn, length)?
        }
        MotionLaw::HarmonicKombiVt | MotionLaw::HarmonicKombiTv => {
            combination(from, stroke, turn, length)?
        }
        MotionLaw::Spline
        | MotionLaw::SplineNatural
        | MotionLaw::SplineTangential
        | MotionLaw::SplinePeriodic
        | MotionLaw::SplineLinear => return Err(LawError::Spline { law }),
    })
}

fn combination(start: &Motion, stroke: f64, turn: Turn, length: f64) -> Result<LawShape, LawError> {
    let velocity = start.velocity;
    let half_sine = match turn {
        Turn::Default => {
            harmonic::share_with_continuous_jerk(velocity, stroke).ok_or(LawError::TurnVelocity {
                received: velocity / length,
                mean: stroke / length,
            })
        }
        Turn::At(share) if 0.0 < share && share < 1.0 => Ok(share),
        Turn::At(received) => Err(LawError::TurnShare { received }),
        Turn::Acceleration(received) => {
            // Per squared master unit, as received, becomes per squared share.
            let at_turn = received * length * length;
            harmonic::share_with_acceleration(velocity, stroke, at_turn)
                .ok_or(LawError::TurnAcceleration { received })
        }
    }?;
    Ok(LawShape::Combination(Combination::new(
        start, stroke, half_sine,
    )))
}

fn shares_at<const N: usize>(polynomial: &Polynomial<N>, position: f64) -> Roots {
    // Turns of the polynomial itself do not depend on the target, unlike its constant term.
    let turns = polynomial.derivative().roots_in(0.0, 1.0);
    let less_target = LessTarget {
        curve: *polynomial,
        target: position,
    };
    roots_between_extremes(&less_target, &turns, 0.0, 1.0)
}

fn is_finite(motion: &Motion) -> bool {
    let Motion {
        position,
        velocity,
        acceleration,
        jerk,
    } = *motion;
    [position, velocity, acceleration, jerk]
        .iter()
        .all(|value| value.is_finite())
}

const fn motion([position, velocity, acceleration, jerk]: [f64; 4]) -> Motion {
    Motion {
        position,
        velocity,
        acceleration,
        jerk,
    }
}

/// Returns the motion over a variable that is 1/`factor` of the old one.
#[inline]
fn scaled(motion: &Motion, factor: f64) -> Motion {
    let squared = factor * factor;
    Motion {
        position: motion.position,
        velocity: motion.velocity * factor,
        acceleration: motion.acceleration * squared,
        jerk: motion.jerk * (squared * factor),
    }
}

/// Checks that all numbers are finite; otherwise names the quantity, and `true` for the second point.
fn representable(points: &[Motion; 2]) -> Result<(), (bool, Quantity)> {
    // Two finite positions of opposite sign may have an infinite distance.
    if !(points[1].position - points[0].position).is_finite() {
        return Err((true, Quantity::Position));
    }
    for (is_second, point) in [(false, &points[0]), (true, &points[1])] {
        for quantity in [Quantity::Velocity, Quantity::Acceleration, Quantity::Jerk] {
            if !component(point, quantity).is_finite() {
                return Err((is_second, quantity));
            }
        }
    }
    Ok(())
}

const fn component(motion: &Motion, quantity: Quantity) -> f64 {
    match quantity {
        Quantity::Master | Quantity::Position => motion.position,
        Quantity::Velocity => motion.velocity,
        Quantity::Acceleration => motion.acceleration,
        Quantity::Jerk => motion.jerk,
    }
}
