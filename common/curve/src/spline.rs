//! Cubic splines: the slopes at the knots that make the second derivative continuous.
//!
//! The equations for the slopes have three unknowns each and a dominant diagonal, so elimination without
//! pivoting is stable (Carl de Boor, A Practical Guide to Splines, chapter IV). A periodic spline joins
//! the last knot to the first; its two corner entries are separated as a rank-one change (Sherman and
//! Morrison).

use alloc::vec::Vec;

use crate::curve::Curve;
use crate::law::{Motion, Segment};

/// Error of knots between which a slope is not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the spline has a slope that is not finite, expected knots farther apart")]
pub struct NoFiniteSlopes;

/// A place that the spline passes through.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SplineKnot {
    /// Position of the master.
    pub master: f64,
    /// Position of the slave there.
    pub slave: f64,
}

/// Condition at an end of an open spline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SplineEnd {
    /// No curvature.
    Natural,
    /// A given slope.
    Slope(f64),
    /// The slope of the straight line across the end segment.
    Secant,
}

/// Conditions at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SplineEnds {
    /// An open spline: conditions at its start and at its end.
    Open(SplineEnd, SplineEnd),
    /// Slope and curvature at the end are those of the start.
    Periodic,
}

/// Memory of the solver; it allocates no more once it has solved the longest spline.
#[derive(Clone, Debug, Default)]
pub struct SplineSolver {
    knots: Vec<SplineKnot>,
    rows: Vec<SplineRow>,
    slopes: Vec<f64>,
}

/// Equation: `below`·previous slope + `diagonal`·slope + `above`·next slope = `right`. `border` is a
/// second right-hand side, used by periodic splines only.
#[derive(Clone, Copy, Debug, Default)]
struct SplineRow {
    below: f64,
    diagonal: f64,
    above: f64,
    right: f64,
    border: f64,
}

impl SplineSolver {
    /// Makes a solver with capacity for this number of knots.
    #[must_use]
    pub fn with_capacity(knots: usize) -> Self {
        Self {
            knots: Vec::with_capacity(knots),
            rows: Vec::with_capacity(knots),
            slopes: Vec::with_capacity(knots),
        }
    }

    /// Removes the knots of the last spline.
    pub fn clear(&mut self) {
        self.knots.clear();
    }

    /// Appends a knot, with a master above the one before.
    pub fn push(&mut self, knot: SplineKnot) {
        self.knots.push(knot);
    }

    /// Returns the knots so far.
    #[must_use]
    pub fn knots(&self) -> &[SplineKnot] {
        &self.knots
    }

    /// Finds the slopes at the knots, of which there are at least two, or three for a periodic spline.
    fn solve(&mut self, ends: SplineEnds) {
        self.rows.clear();
        self.slopes.clear();
        match ends {
            SplineEnds::Open(start, end) => self.solve_open(start, end),
            SplineEnds::Periodic => self.solve_periodic(),
        }
    }

    fn solve_open(&mut self, start: SplineEnd, end: SplineEnd) {
        let last = self.knots.len() - 1;
        let (first, second) = (secant(&self.knots[..2]), secant(&self.knots[last - 1..]));
        self.rows.push(start_row(start, first));
        for i in 1..last {
            let (before, after) = (secant(&self.knots[i - 1..]), secant(&self.knots[i..]));
            self.rows.push(inner_row(before, after));
        }
        // Seen from the end the spline runs backwards: slopes
        // keep their equations, with the neighbour before.
        let mirrored = start_row(end, second);
        self.rows.push(SplineRow {
            below: mirrored.above,
            above: 0.0,
            ..mirrored
        });
        eliminate(&mut self.rows);
        self.slopes.extend(self.rows.iter().map(|row| row.right));
    }

    fn solve_periodic(&mut self) {
        let last = self.knots.len() - 1;
        // The last knot equals the first one, so its slope is not an unknown of its own.
        let mut before = secant(&self.knots[last - 1..]);
        for i in 0..last {
            let after = secant(&self.knots[i..]);
            self.rows.push(inner_row(before, after));
            before = after;
        }
        solve_bordered(&mut self.rows);
        self.slopes.extend(self.rows.iter().map(|row| row.right));
        // The last knot is the first one again, so its slope is
        // copied instead of solved: bits agree at the joint.
        self.slopes.push(self.rows[0].right);
    }
}

/// The straight line between two neighbours.
#[derive(Clone, Copy)]
struct Secant {
    width: f64,
    slope: f64,
}

fn secant(knots: &[SplineKnot]) -> Secant {
    let width = knots[1].master - knots[0].master;
    Secant {
        width,
        slope: (knots[1].slave - knots[0].slave) / width,
    }
}

/// Makes the equation of a second derivative that is equal on both sides of a knot. Widths are relative
/// to each other, so that no product of two can overflow.
fn inner_row(before: Secant, after: Secant) -> SplineRow {
    let both = before.width + after.width;
    // Divided by both widths, the off-diagonal entries add
    // up to 1, half of the diagonal: no pivoting is needed.
    let (below, above) = (after.width / both, before.width / both);
    SplineRow {
        below,
        diagonal: 2.0,
        above,
        right: 3.0 * (below * before.slope + above * after.slope),
        border: 0.0,
    }
}

fn start_row(end: SplineEnd, secant: Secant) -> SplineRow {
    let (diagonal, above, right) = match end {
        // From s'' = 0 at the start of a cubic: 2·m₀ + m₁ = 3·secant.
        SplineEnd::Natural => (2.0, 1.0, 3.0 * secant.slope),
        SplineEnd::Slope(slope) => (1.0, 0.0, slope),
        SplineEnd::Secant => (1.0, 0.0, secant.slope),
    };
    SplineRow {
        diagonal,
        above,
        right,
        ..SplineRow::default()
    }
}

/// Leaves the solutions of the three-diagonal system in `right` and `border`.
fn eliminate(rows: &mut [SplineRow]) {
    let mut previous = SplineRow::default();
    for row in rows.iter_mut() {
        // At least 1 by the dominant diagonal, so the division is safe.
        let pivot = row.diagonal - row.below * previous.above;
        row.right = (row.right - row.below * previous.right) / pivot;
        row.border = (row.border - row.below * previous.border) / pivot;
        row.above /= pivot;
        previous = *row;
    }
    let mut next = SplineRow::default();
    for row in rows.iter_mut().rev() {
        row.right -= row.above * next.right;
        row.border -= row.above * next.border;
        next = *row;
    }
}

/// Solves the system whose first row also has the last unknown by its `below`, and whose last row has the
/// first unknown by its `above`. The corners are w·vᵀ with w = (γ, 0…, above), v = (1, 0…, below/γ).
fn solve_bordered(rows: &mut [SplineRow]) {
    let last = rows.len() - 1;
    // The usual choice: it doubles the first diagonal entry instead of cancelling it.
    let gamma = -rows[0].diagonal;
    let corner = rows[0].below / gamma;
    let above = rows[last].above;
    rows[0].below = 0.0;
    rows[0].diagonal -= gamma;
    rows[0].border = gamma;
    rows[last].above = 0.0;
    rows[last].diagonal -= above * corner;
    rows[last].border = above;
    eliminate(rows);
    // Sherman and Morrison: x = y − z·(v·y)/(1 + v·z), with y by `right` and z by `border`.
    let share = (rows[0].right + corner * rows[last].right)
        / (1.0 + rows[0].border + corner * rows[last].border);
    for row in rows {
        row.right -= share * row.border;
    }
}

/// Solves for the knots the solver holds and appends the cubics between them to a curve.
///
/// # Errors
/// [`NoFiniteSlopes`]; the curve may have some of the segments then.
pub fn push_spline(
    splines: &mut SplineSolver,
    ends: SplineEnds,
    curve: &mut Curve,
) -> Result<(), NoFiniteSlopes> {
    splines.solve(ends);
    let slopes = splines.slopes.iter().copied();
    push_hermite(splines.knots.iter().copied().zip(slopes), curve)
}

/// Appends the cubics that have the given slopes at the given knots to a curve.
///
/// # Errors
/// [`NoFiniteSlopes`].
pub fn push_hermite(
    mut knots_and_slopes: impl Iterator<Item = (SplineKnot, f64)>,
    curve: &mut Curve,
) -> Result<(), NoFiniteSlopes> {
    let Some((mut from, mut leaving)) = knots_and_slopes.next() else {
        return Ok(());
    };
    for (to, arriving) in knots_and_slopes {
        push_cubic(from, to, cubic(from, to, leaving, arriving), curve)?;
        (from, leaving) = (to, arriving);
    }
    Ok(())
}

/// Appends the straight lines between the given knots to a curve.
///
/// # Errors
/// [`NoFiniteSlopes`].
pub fn push_lines(
    mut knots: impl Iterator<Item = SplineKnot>,
    curve: &mut Curve,
) -> Result<(), NoFiniteSlopes> {
    let Some(mut from) = knots.next() else {
        return Ok(());
    };
    for to in knots {
        let slope = secant(&[from, to]).slope;
        push_cubic(from, to, [from.slave, slope, 0.0, 0.0], curve)?;
        from = to;
    }
    Ok(())
}

fn push_cubic(
    from: SplineKnot,
    to: SplineKnot,
    coefficients: [f64; 4],
    curve: &mut Curve,
) -> Result<(), NoFiniteSlopes> {
    let segment = Segment::cubic(from.master, to.master, coefficients);
    // A number that is not finite at the end was not at the start, or has overflowed on the way.
    let Motion {
        position,
        velocity,
        acceleration,
        jerk,
    } = segment.at(to.master);
    if ![position, velocity, acceleration, jerk]
        .iter()
        .all(|value| value.is_finite())
    {
        return Err(NoFiniteSlopes);
    }
    curve.push(segment);
    Ok(())
}

/// Returns the cubic between two knots with its slopes on leaving and arriving: coefficients in powers of
/// the distance from the first.
fn cubic(from: SplineKnot, to: SplineKnot, leaving: f64, arriving: f64) -> [f64; 4] {
    let Secant { width, slope } = secant(&[from, to]);
    [
        from.slave,
        leaving,
        (3.0 * slope - 2.0 * leaving - arriving) / width,
        // Divided twice: the square of a small width could underflow to 0.
        (leaving + arriving - 2.0 * slope) / width / width,
    ]
}
