//! From points to segments.

use super::error::{CamError, PlateLocation};
use super::point::{MotionPoint, PointType};
use coaxle_curve::curve::Curve;
use coaxle_curve::law::{Knot, LawError, Motion, MotionLaw, Segment, Turn};
use coaxle_curve::spline::{SplineEnd, SplineEnds, SplineKnot, SplineSolver, push_spline};

/// Checks all points and leaves the segments between those in use in `curve`. Allocates only if its
/// capacity is less than the number of rows.
pub(super) fn compile(
    points: &[MotionPoint],
    splines: &mut SplineSolver,
    curve: &mut Curve,
) -> Result<(), CamError> {
    // All values are finite after the check, so later comparisons need not consider NaN.
    check(points)?;
    curve.clear();
    let mut row = 0;
    while row + 1 < points.len() {
        // A spline spans several rows and is solved as a whole, all other laws lead to the next point only.
        row = if points[row].function.is_spline() {
            push_spline_from(points, row, splines, curve)?
        } else {
            push_segment(points, row, curve)?
        };
    }
    Ok(())
}

/// Checks that concern each point on its own.
fn check(points: &[MotionPoint]) -> Result<(), CamError> {
    let [first, .., last] = points else {
        return Err(CamError::TooFewPoints {
            received: points.len(),
        });
    };
    for (row, point) in points.iter().enumerate() {
        check_index(row, point)?;
    }
    for end in [first, last] {
        if end.point_type == PointType::Ignore {
            return Err(CamError::EndIgnored { point: end.index });
        }
    }
    points
        .iter()
        // Reserved rows may hold anything, even NaN, until a change brings them into use.
        .filter(|point| point.point_type != PointType::Ignore)
        .try_for_each(check_values)
}

fn check_index(row: usize, point: &MotionPoint) -> Result<(), CamError> {
    // Beyond u32 no index can match, so such a plate is refused at this row.
    let expected = u32::try_from(row + 1).unwrap_or(u32::MAX);
    if point.index == expected {
        return Ok(());
    }
    Err(CamError::PointIndex {
        row,
        received: point.index,
        expected,
    })
}

fn check_values(point: &MotionPoint) -> Result<(), CamError> {
    let fields = [
        ("master", point.master),
        ("slave", point.slave),
        ("velocity", point.velocity),
        ("acceleration", point.acceleration),
        ("jerk", point.jerk),
    ];
    // Before the type is compared: NaN differs from 0, and would be reported as a contradiction.
    if let Some((field, received)) = fields.into_iter().find(|(_, value)| !value.is_finite()) {
        return Err(CamError::NotFinite {
            place: PlateLocation::Point(point.index),
            field,
            received,
        });
    }
    if point.point_type == PointType::Add {
        return Err(CamError::AddNotAvailable { point: point.index });
    }
    let contradiction = |field, received| CamError::PointContradicts {
        point: point.index,
        point_type: point.point_type,
        field,
        received,
    };
    if point.point_type.stands_still() && point.velocity != 0.0 {
        return Err(contradiction("velocity", point.velocity));
    }
    if point.point_type.keeps_its_velocity() && point.acceleration != 0.0 {
        return Err(contradiction("acceleration", point.acceleration));
    }
    Ok(())
}

/// Returns the next row on the course.
pub(super) fn next_of(points: &[MotionPoint], row: usize) -> Result<usize, CamError> {
    let point = &points[row];
    // Negative steps become 0, which the range below refuses: a course that leads back would never end.
    let most = points.len() - 1 - row;
    let step = usize::try_from(point.relative_next).unwrap_or(0);
    if !(1..=most).contains(&step) {
        return Err(CamError::NextPoint {
            point: point.index,
            relative_next: point.relative_next,
            most: most as u32,
        });
    }
    let next = &points[row + step];
    if next.point_type == PointType::Ignore {
        return Err(CamError::NextPointIgnored {
            point: point.index,
            next: next.index,
        });
    }
    // Compared along the course and not row by row, since skipped rows need not ascend.
    if next.master <= point.master {
        return Err(CamError::NotAscending {
            place: PlateLocation::Point(next.index),
            received: next.master,
            above: point.master,
        });
    }
    Ok(row + step)
}

fn push_segment(points: &[MotionPoint], row: usize, curve: &mut Curve) -> Result<usize, CamError> {
    let next_row = next_of(points, row)?;
    let (point, next) = (&points[row], &points[next_row]);
    curve.push(segment(point, next).map_err(|error| CamError::Law {
        point: point.index,
        next: next.index,
        law: point.function,
        error,
    })?);
    Ok(next_row)
}

/// Returns the law of a point that leads to the next one, unless it is that of a spline.
pub(super) fn segment(point: &MotionPoint, next: &MotionPoint) -> Result<Segment, LawError> {
    Segment::with_turn(point.function, &knot(point), &knot(next), turn(point, next))
}

/// Returns the place of the inner turning point of a harmonic combination, from the acceleration at its
/// turning end.
fn turn(point: &MotionPoint, next: &MotionPoint) -> Turn {
    let turning = match point.function {
        // RT and VT turn at their end, TR and TV at their start. The acceleration of the other end is not theirs.
        MotionLaw::HarmonicKombiRt | MotionLaw::HarmonicKombiVt => next,
        MotionLaw::HarmonicKombiTr | MotionLaw::HarmonicKombiTv => point,
        _ => return Turn::Default,
    };
    // A turn has B = π²/(μ(πλ + 4μ)) > 0 in magnitude, so 0 cannot be meant and stands for the default λ.
    if turning.acceleration == 0.0 {
        Turn::Default
    } else {
        Turn::Acceleration(turning.acceleration)
    }
}

fn knot(point: &MotionPoint) -> Knot {
    Knot {
        master: point.master,
        motion: Motion {
            position: point.slave,
            velocity: point.velocity,
            acceleration: point.acceleration,
            jerk: point.jerk,
        },
    }
}

/// Adds one spline from `row` over all inner spline points to the point after them.
fn push_spline_from(
    points: &[MotionPoint],
    row: usize,
    splines: &mut SplineSolver,
    curve: &mut Curve,
) -> Result<usize, CamError> {
    let start = &points[row];
    // An inner point names no end condition, so the spline would have two unknowns too many.
    if start.function == MotionLaw::Spline {
        return Err(CamError::SplineNotBegun { point: start.index });
    }
    let end_row = collect_knots(points, row, splines)?;
    let ends = ends_of(start, &points[end_row])?;
    let (received, least) = (splines.knots().len(), least_points(ends));
    if received < least {
        return Err(CamError::TooFewSplinePoints {
            start: start.index,
            received,
            least,
        });
    }
    push_spline(splines, ends, curve)
        .map_err(|error| CamError::from_spline(error, PlateLocation::Point(start.index)))?;
    Ok(end_row)
}

/// Passes the points of the spline to the solver; returns the row it ends at.
fn collect_knots(
    points: &[MotionPoint],
    start: usize,
    splines: &mut SplineSolver,
) -> Result<usize, CamError> {
    let spline_knot = |row: usize| SplineKnot {
        master: points[row].master,
        slave: points[row].slave,
    };
    // A solver with room for all rows is reused for each spline: changes in the cycle do not allocate.
    splines.clear();
    splines.push(spline_knot(start));
    let mut row = start;
    loop {
        // Strictly further each time, so the loop ends at the last row at the latest.
        row = next_of(points, row)?;
        splines.push(spline_knot(row));
        if row + 1 == points.len() || points[row].function != MotionLaw::Spline {
            return Ok(row);
        }
    }
}

/// Returns the end conditions. The last point of a spline may name its own; if another law continues from
/// there, or it names none, both ends are equal.
fn ends_of(start: &MotionPoint, end: &MotionPoint) -> Result<SplineEnds, CamError> {
    let start_law = start.function;
    let end_law = match end.function {
        // Only the last row can be an inner point here: the points end before the spline does.
        MotionLaw::Spline => start_law,
        law if law.is_spline() => law,
        _ => start_law,
    };
    match (
        start_law == MotionLaw::SplinePeriodic,
        end_law == MotionLaw::SplinePeriodic,
    ) {
        // A periodic condition ties slope and curvature of both ends together, so it cannot hold at one end.
        (true, true) => Ok(SplineEnds::Periodic),
        (false, false) => Ok(SplineEnds::Open(
            end_condition(start_law, start.velocity),
            end_condition(end_law, end.velocity),
        )),
        _ => Err(CamError::SplineHalfPeriodic {
            start: start.index,
            end: end.index,
        }),
    }
}

fn end_condition(law: MotionLaw, velocity: f64) -> SplineEnd {
    match law {
        MotionLaw::SplineTangential => SplineEnd::Slope(velocity),
        MotionLaw::SplineLinear => SplineEnd::Secant,
        _ => SplineEnd::Natural,
    }
}

/// Returns the least number of points: a spline through two points is one cubic, but one period needs a
/// point inside.
fn least_points(ends: SplineEnds) -> usize {
    match ends {
        SplineEnds::Open(..) => 2,
        // Between two points with equal slopes and curvatures at both ends only a straight line is left.
        SplineEnds::Periodic => 3,
    }
}
