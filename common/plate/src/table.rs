//! Position tables: a cam of many rows of master and slave positions.

use alloc::vec::Vec;

use super::curve_peaks::CurvePeaks;
use super::error::{CamError, PlateLocation};
use super::kind::{Course, TableType};
use coaxle_curve::curve::Curve;
use coaxle_curve::spline::{
    NoFiniteSlopes, SplineEnd, SplineEnds, SplineKnot, SplineSolver, push_hermite, push_lines,
    push_spline,
};

/// `MC_InterpolationType`, TF5050 chapter 8.6: the course from one row of a position table to the next.
#[doc(alias = "MC_InterpolationType")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u8)]
pub enum Interpolation {
    /// Straight lines: the velocity steps at each row.
    #[doc(alias = "MC_INTERPOLATIONTYPE_LINEAR")]
    #[default]
    Linear = 0,
    /// No longer supported, and refused.
    #[doc(alias = "MC_INTERPOLATIONTYPE_4POINT")]
    FourPoint = 1,
    /// A single cubic spline through all rows: position, velocity and acceleration are continuous. In a
    /// linear cam its end slopes are those of the parabola through the three rows at that end; in a
    /// cyclic one it is periodic.
    #[doc(alias = "MC_INTERPOLATIONTYPE_SPLINE")]
    Spline = 2,
    /// Local cubics: position and velocity are continuous, and a row has no effect beyond its
    /// second neighbours. The slope at a row is that of the parabola through it and its neighbours;
    /// each cubic so depends on four rows.
    #[doc(alias = "MC_INTERPOLATIONTYPE_SLIDINGSPLINE")]
    SlidingSpline = 3,
}

impl Interpolation {
    /// Types by their codes.
    pub const ALL: [Self; 4] = [
        Self::Linear,
        Self::FourPoint,
        Self::Spline,
        Self::SlidingSpline,
    ];

    /// Returns the PLC's number of the type.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// Returns the type with that number, if there is one.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.code() == code)
    }

    /// Returns the number of rows that it needs.
    fn least_rows(self) -> Result<usize, CamError> {
        match self {
            Self::Linear => Ok(2),
            Self::FourPoint => Err(CamError::FourPoint),
            // TF5050's least number, too. Each sliding cubic depends on four rows, and two end parabolas on
            // three each.
            Self::Spline | Self::SlidingSpline => Ok(4),
        }
    }
}

/// A position table: rows of (master, slave) in x and u, the masters strictly ascending.
#[doc(alias = "MC_TABLETYPE_NONEQUIDISTANT")]
#[doc(alias = "MC_TABLETYPE_EQUIDISTANT")]
#[derive(Clone, Debug)]
pub struct PositionTable {
    rows: Vec<(f64, f64)>,
    interpolation: Interpolation,
    course: Course,
    equidistant: bool,
    curve: Curve,
    peaks: CurvePeaks,
}

/// Greatest deviation of a row of an equidistant table from its place, in steps: a file with a few
/// decimal places is still equidistant.
// Rows rounded to d decimal places stray by up to 10^-d, half of it by the rounded ends.
// Three places so suffice for steps from 1.
// Evaluation does not depend on it: the curve checks the computed segment and its neighbours, then searches.
const STEP_TOLERANCE: f64 = 1e-3;

impl PositionTable {
    /// Makes a table whose masters may be at any distance: at least two rows for linear interpolation,
    /// four for splines.
    ///
    /// # Errors
    /// 0x4B36 without rows, 0x4A02 for too few, 0x4A06 if the master does not ascend, 0x4A08 for four-point
    /// interpolation, 0x4A1C for a number that is not finite, 0x4A20 for a spline without a
    /// solution.
    pub fn new(
        rows: &[(f64, f64)],
        interpolation: Interpolation,
        course: Course,
    ) -> Result<Self, CamError> {
        check(rows, interpolation)?;
        let mut curve = Curve::with_capacity(rows.len() - 1);
        match interpolation {
            Interpolation::Spline => push_global_spline(rows, course, &mut curve),
            Interpolation::SlidingSpline => push_sliding_spline(rows, course, &mut curve),
            // Four-point interpolation never arrives here: the check has refused it.
            Interpolation::Linear | Interpolation::FourPoint => {
                push_lines(rows.iter().copied().map(knot), &mut curve)
            }
        }
        .map_err(|error| CamError::from_spline(error, PlateLocation::Row(0)))?;
        Ok(Self {
            rows: rows.to_vec(),
            interpolation,
            course,
            equidistant: false,
            peaks: CurvePeaks::of(&curve),
            curve,
        })
    }

    /// Makes a table whose masters are at equal distances, to a thousandth of a step. The segment of a
    /// master is then computed, not searched.
    ///
    /// # Errors
    /// As [`Self::new`], and 0x4A04 naming the first row that is not in its place.
    pub fn equidistant(
        rows: &[(f64, f64)],
        interpolation: Interpolation,
        course: Course,
    ) -> Result<Self, CamError> {
        // Masters that do not ascend are refused first, else they would be reported as a wrong step.
        let mut table = Self::new(rows, interpolation, course)?;
        let (first, last) = (table.curve.start(), table.curve.end());
        let step = (last - first) / (rows.len() - 1) as f64;
        for (row, &(received, _)) in rows.iter().enumerate() {
            // Against the first row and not the previous one: small deviations must not add up to a whole step.
            let expected = first + row as f64 * step;
            let strays = (received - expected).abs() > STEP_TOLERANCE * step;
            if strays {
                return Err(CamError::StepSize {
                    row,
                    received,
                    expected,
                });
            }
        }
        table.equidistant = true;
        table.curve.settle_equidistant();
        Ok(table)
    }

    /// Makes a table of these rows with another interpolation. Allocates.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn interpolated(&self, interpolation: Interpolation) -> Result<Self, CamError> {
        let construct = if self.equidistant {
            Self::equidistant
        } else {
            Self::new
        };
        construct(&self.rows, interpolation, self.course)
    }

    /// Returns the rows: master and slave positions.
    #[must_use]
    pub fn rows(&self) -> &[(f64, f64)] {
        &self.rows
    }

    /// Returns the interpolation between rows.
    #[must_use]
    pub const fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// Returns the course: passed once or repeated.
    #[must_use]
    pub const fn course(&self) -> Course {
        self.course
    }

    /// Returns the type of the table: equidistant or not.
    #[must_use]
    pub const fn table_type(&self) -> TableType {
        if self.equidistant {
            TableType::Equidistant
        } else {
            TableType::NonEquidistant
        }
    }

    pub(super) fn curve(&self) -> &Curve {
        &self.curve
    }

    pub(super) const fn peaks(&self) -> &CurvePeaks {
        &self.peaks
    }
}

fn check(rows: &[(f64, f64)], interpolation: Interpolation) -> Result<(), CamError> {
    let least = interpolation.least_rows()?;
    if rows.len() < least {
        return Err(CamError::TooFewRows {
            received: rows.len(),
            least,
        });
    }
    // Before the order of the masters, since NaN compares as neither below nor above.
    for (row, &(master, slave)) in rows.iter().enumerate() {
        for (field, received) in [("master", master), ("slave", slave)] {
            if !received.is_finite() {
                return Err(CamError::NotFinite {
                    place: PlateLocation::Row(row),
                    field,
                    received,
                });
            }
        }
    }
    for (row, pair) in rows.windows(2).enumerate() {
        if pair[1].0 <= pair[0].0 {
            return Err(CamError::NotAscending {
                place: PlateLocation::Row(row + 1),
                received: pair[1].0,
                above: pair[0].0,
            });
        }
    }
    Ok(())
}

fn push_global_spline(
    rows: &[(f64, f64)],
    course: Course,
    curve: &mut Curve,
) -> Result<(), NoFiniteSlopes> {
    let mut splines = SplineSolver::with_capacity(rows.len());
    for &row in rows {
        splines.push(knot(row));
    }
    let last = rows.len() - 1;
    let ends = match course {
        // Given slopes would leave the curvatures of both sides of the seam free to differ.
        Course::Cyclic => SplineEnds::Periodic,
        Course::Linear => SplineEnds::Open(
            // Natural ends would force a curvature of 0: a table of a parabola would no longer be one
            // (`splines_follow_a_parabola`).
            SplineEnd::Slope(parabola_slope(rows[0], rows[1], rows[2])),
            SplineEnd::Slope(parabola_slope(rows[last], rows[last - 1], rows[last - 2])),
        ),
    };
    push_spline(&mut splines, ends, curve)
}

fn push_sliding_spline(
    rows: &[(f64, f64)],
    course: Course,
    curve: &mut Curve,
) -> Result<(), NoFiniteSlopes> {
    let slopes = (0..rows.len()).map(|row| sliding_slope(rows, course, row));
    push_hermite(rows.iter().copied().map(knot).zip(slopes), curve)
}

/// Returns the slope at a row of the parabola through it and its neighbours. Beyond the end of a cyclic
/// table its first rows follow, one lift further.
fn sliding_slope(rows: &[(f64, f64)], course: Course, row: usize) -> f64 {
    let last = rows.len() - 1;
    match course {
        Course::Linear if row == 0 => parabola_slope(rows[0], rows[1], rows[2]),
        Course::Linear if row == last => parabola_slope(rows[last], rows[last - 1], rows[last - 2]),
        // Both ends by one expression, so that the slopes at the seam are equal to the last bit.
        Course::Cyclic if row == 0 || row == last => {
            let (period, lift) = (rows[last].0 - rows[0].0, rows[last].1 - rows[0].1);
            let before = (rows[last - 1].0 - period, rows[last - 1].1 - lift);
            parabola_slope(rows[0], rows[1], before)
        }
        _ => parabola_slope(rows[row], rows[row + 1], rows[row - 1]),
    }
}

/// Returns the slope at `here` of the parabola through three places (Newton's divided differences).
fn parabola_slope(here: (f64, f64), second: (f64, f64), third: (f64, f64)) -> f64 {
    let to_second = secant(here, second);
    // p'(h) = f[h,s] + f[h,s,t]·(h - s), in any order of the three: ends and inner rows share it.
    let curvature = (secant(second, third) - to_second) / (third.0 - here.0);
    to_second - curvature * (second.0 - here.0)
}

fn secant(from: (f64, f64), to: (f64, f64)) -> f64 {
    (to.1 - from.1) / (to.0 - from.0)
}

const fn knot((master, slave): (f64, f64)) -> SplineKnot {
    SplineKnot { master, slave }
}
