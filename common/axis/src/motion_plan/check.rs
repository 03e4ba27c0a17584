//! Checks of a plan, piece by piece.

use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::{Kinematics, Limits};

use super::fault::{InvalidPlan, PlanFault};
use super::{MOST_PIECES, MotionPiece};

/// Largest plausible value of a position, a velocity, an acceleration or a jerk, as in a frame.
const LARGEST: f64 = 1e15;
/// Rounding of a state at the end of a piece, relative to the values that it is calculated from. A double has 1e-16; a
/// planner finds the end of a move by bisection, to the last bits of its duration.
const ROUNDING: f64 = 1e-9;
/// Share by which a peak may exceed its limit: planners keep limits to their rounding.
const OVER_LIMIT: f64 = 1e-6;
/// Pieces begin at whole nanoseconds, and phases of a motion in between: the jerk of a piece lasts by up to this time too
/// long or too short, at either end.
const GRID: f64 = 2e-9;

/// Checks the pieces of a plan, and its promise.
pub(super) fn plan(
    pieces: &[MotionPiece],
    promised_until: Span,
    limits: &Limits,
) -> Result<(), InvalidPlan> {
    let [first, last] = match pieces {
        [] => return Err(count(PlanFault::NoPieces, pieces)),
        [only] => [only, only],
        [first, .., last] if pieces.len() <= MOST_PIECES => [first, last],
        _ => return Err(count(PlanFault::TooManyPieces, pieces)),
    };
    let mut before: Option<&MotionPiece> = None;
    for (n, piece) in (1..).zip(pieces) {
        let fault = |(fault, received, expected)| InvalidPlan {
            fault,
            piece: Some(n),
            received,
            expected,
        };
        values(piece).map_err(fault)?;
        within(piece, limits).map_err(fault)?;
        if let Some(before) = before.replace(piece) {
            joint(before, piece, limits).map_err(fault)?;
        }
    }
    if (first.start..=last.end()).contains(&promised_until) {
        return Ok(());
    }
    let [received, expected] = [promised_until, last.end()].map(Span::as_secs_f64);
    Err(InvalidPlan::of_plan(
        PlanFault::PromiseBeyondPieces,
        received,
        expected,
    ))
}

fn count(fault: PlanFault, pieces: &[MotionPiece]) -> InvalidPlan {
    InvalidPlan::of_plan(fault, pieces.len() as f64, MOST_PIECES as f64)
}

/// A fault, with the value received and the one expected.
type PieceFault = (PlanFault, f64, Option<f64>);

/// Checks the numbers of a piece by themselves.
fn values(piece: &MotionPiece) -> Result<(), PieceFault> {
    let Kinematics {
        position,
        velocity,
        acceleration,
    } = piece.from;
    let values = [position, velocity, acceleration, piece.jerk];
    let wrong = |value: &&f64| value.is_nan() || value.abs() > LARGEST;
    if let Some(value) = values.iter().find(wrong) {
        return Err((PlanFault::OutOfRange, *value, None));
    }
    // The sum of both must not saturate.
    let end = piece
        .start
        .as_nanos()
        .checked_add(piece.duration.as_nanos());
    if piece.duration <= Span::ZERO || end.is_none() {
        let duration = piece.duration.as_secs_f64();
        return Err((PlanFault::NoDuration, duration, Some(0.0)));
    }
    Ok(())
}

/// Checks that a piece keeps the limits of its axis.
fn within(piece: &MotionPiece, limits: &Limits) -> Result<(), PieceFault> {
    let (velocity, acceleration) = piece.peaks();
    let steepest = limits.acceleration().max(limits.deceleration());
    // A piece that ends on the grid is as much longer.
    let of_grid = [steepest * GRID, limits.jerk() * GRID, 0.0];
    let peaks = [
        (PlanFault::VelocityLimit, velocity, limits.velocity()),
        (PlanFault::AccelerationLimit, acceleration, steepest),
        (PlanFault::JerkLimit, piece.jerk.abs(), limits.jerk()),
    ];
    for ((fault, peak, limit), of_grid) in peaks.into_iter().zip(of_grid) {
        if peak.is_nan() || peak > limit * (1.0 + OVER_LIMIT) + of_grid {
            return Err((fault, peak, Some(limit)));
        }
    }
    Ok(())
}

/// Checks that a piece continues the one before it.
fn joint(before: &MotionPiece, piece: &MotionPiece, limits: &Limits) -> Result<(), PieceFault> {
    let due = before.end();
    if piece.start != due {
        let fault = match piece.start < due {
            true => PlanFault::OutOfOrder,
            false => PlanFault::Gap,
        };
        let [received, expected] = [piece.start, due].map(Span::as_secs_f64);
        return Err((fault, received, Some(expected)));
    }
    let end = before.at(due, Seconds::ZERO);
    let t = before.duration.as_secs_f64();
    let (velocity, acceleration) = before.peaks();
    let steepest = limits.acceleration().max(limits.deceleration());
    let joints = [
        (
            PlanFault::PositionJump,
            [piece.from.position, end.position],
            // Of the terms that the end is a sum of.
            ROUNDING * (before.from.position.abs() + velocity * t) + limits.velocity() * GRID,
        ),
        (
            PlanFault::VelocityJump,
            [piece.from.velocity, end.velocity],
            ROUNDING * (velocity + acceleration * t) + steepest * GRID,
        ),
        (
            PlanFault::AccelerationJump,
            [piece.from.acceleration, end.acceleration],
            ROUNDING * (acceleration + before.jerk.abs() * t) + limits.jerk() * GRID,
        ),
    ];
    for (fault, [received, expected], rounding) in joints {
        if (received - expected).abs() > rounding {
            return Err((fault, received, Some(expected)));
        }
    }
    Ok(())
}
