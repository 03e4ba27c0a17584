//! Conditions of a law at its points.

use super::error::{LawError, Quantity, Side};
use super::motion::{Knot, Motion};
use super::motion_law::MotionLaw;

/// Condition of a law at one end.
#[derive(Clone, Copy, PartialEq, Eq)]
enum EndCondition {
    /// Value of the point, or of the law.
    Free,
    /// No acceleration.
    Steady,
    /// No velocity.
    Still,
    /// Neither velocity nor acceleration.
    Rest,
}

/// Refuses points that contradict the law's conditions.
pub(super) fn check(law: MotionLaw, start: &Knot, end: &Knot) -> Result<(), LawError> {
    finite(Side::Start, start)?;
    finite(Side::End, end)?;
    let length = end.master - start.master;
    // Derivatives are scaled by the reciprocal.
    if !(length > 0.0 && length.is_finite() && (1.0 / length).is_finite()) {
        return Err(LawError::NoLength {
            start: start.master,
            end: end.master,
        });
    }
    let size = start.motion.position.abs().max(end.motion.position.abs());
    let stroke = (end.motion.position - start.motion.position).abs();
    // Smaller values count as zero, beside the stroke and the rounding of the positions.
    let slack = 1e-9 * stroke + 1e-12 * size;
    let [at_start, at_end] = conditions(law);
    for (side, condition, knot) in [(Side::Start, at_start, start), (Side::End, at_end, end)] {
        let Motion {
            velocity,
            acceleration,
            ..
        } = knot.motion;
        // Over the length of the segment, a derivative is comparable with the stroke, whatever the units.
        let zero = |quantity, received: f64, over_the_length: f64| {
            if over_the_length.abs() <= slack {
                return Ok(());
            }
            Err(LawError::Boundary {
                law,
                side,
                quantity,
                received,
                expected: 0.0,
            })
        };
        if matches!(condition, EndCondition::Still | EndCondition::Rest) {
            zero(Quantity::Velocity, velocity, velocity * length)?;
        }
        if matches!(condition, EndCondition::Steady | EndCondition::Rest) {
            let over_the_length = acceleration * length * length;
            zero(Quantity::Acceleration, acceleration, over_the_length)?;
        }
    }
    Ok(())
}

fn finite(side: Side, knot: &Knot) -> Result<(), LawError> {
    let motion = &knot.motion;
    let numbers = [
        (Quantity::Master, knot.master),
        (Quantity::Position, motion.position),
        (Quantity::Velocity, motion.velocity),
        (Quantity::Acceleration, motion.acceleration),
        (Quantity::Jerk, motion.jerk),
    ];
    numbers
        .into_iter()
        .find(|(_, number)| !number.is_finite())
        .map_or(Ok(()), |(quantity, received)| {
            Err(LawError::NotFinite {
                side,
                quantity,
                received,
            })
        })
}

fn conditions(law: MotionLaw) -> [EndCondition; 2] {
    match law {
        MotionLaw::Polynom3 | MotionLaw::Sinuslinie => [EndCondition::Still, EndCondition::Still],
        MotionLaw::Polynom5
        | MotionLaw::Polynom7
        | MotionLaw::Polynom8
        | MotionLaw::Polynom9
        | MotionLaw::Polynom11
        | MotionLaw::Peisekah11
        | MotionLaw::Modsinuslinie
        | MotionLaw::Bestehorn
        | MotionLaw::Beschltrapez => [EndCondition::Rest, EndCondition::Rest],
        MotionLaw::HarmonicKombiRt | MotionLaw::BeschltrapezRt => {
            [EndCondition::Rest, EndCondition::Still]
        }
        MotionLaw::HarmonicKombiTr | MotionLaw::BeschltrapezTr => {
            [EndCondition::Still, EndCondition::Rest]
        }
        MotionLaw::HarmonicKombiVt => [EndCondition::Steady, EndCondition::Still],
        MotionLaw::HarmonicKombiTv => [EndCondition::Still, EndCondition::Steady],
        MotionLaw::ModsinuslinieVv => [EndCondition::Steady, EndCondition::Steady],
        MotionLaw::BeschltrapezRv => [EndCondition::Rest, EndCondition::Steady],
        MotionLaw::BeschltrapezVr => [EndCondition::Steady, EndCondition::Rest],
        MotionLaw::Polynom1
        | MotionLaw::Polynom3Vv
        | MotionLaw::Polynom5Mm
        | MotionLaw::Polynom7Mm
        | MotionLaw::Spline
        | MotionLaw::SplineNatural
        | MotionLaw::SplineTangential
        | MotionLaw::SplinePeriodic
        | MotionLaw::SplineLinear => [EndCondition::Free, EndCondition::Free],
    }
}
