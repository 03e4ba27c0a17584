//! Errors of a plate, a change to it or a query about it.

use core::fmt;

use super::kind::TableType;
use super::point::PointType;
use coaxle_curve::law::{LawError, MotionLaw, Quantity, Side};
use coaxle_curve::spline::NoFiniteSlopes;

/// A plate that cannot be made, or a query that it refuses. [`CamError::code`] is the NC's number, the
/// text names the place, the received and the expected value.
#[doc(alias = "MC_TableErrorCodes")]
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CamError {
    /// 0x4A23: a motion function needs at least two points.
    #[error("{:#06x}: received {received} points, expected at least 2", self.code())]
    TooFewPoints {
        /// Number of points.
        received: usize,
    },
    /// 0x4A1F: the numbers of the points leave a gap, repeat or do not begin at 1.
    #[error("{:#06x}: row {row}: received point index {received}, expected {expected}", self.code())]
    PointIndex {
        /// Row, from 0.
        row: usize,
        /// The number of the point.
        received: u32,
        /// The number expected.
        expected: u32,
    },
    /// 0x4B33: there is no point of that number.
    #[doc(alias = "MC_ERROR_POINTID_INVALID")]
    #[error("{:#06x}: received point index {received}, expected 1 to {last}", self.code())]
    UnknownPoint {
        /// The number received.
        received: u32,
        /// The number of the last point.
        last: u32,
    },
    /// 0x4B34: a change without points.
    #[doc(alias = "MC_ERROR_NUMPOINTS_INVALID")]
    #[error("{:#06x}: received no points to change, expected at least 1", self.code())]
    NoPoints,
    /// 0x4A1C: a number that is not finite.
    #[error("{:#06x}: {place}, {field}: received {received}, expected a finite number", self.code())]
    NotFinite {
        /// Place in the plate.
        place: PlateLocation,
        /// Field or column.
        field: &'static str,
        /// Value received.
        received: f64,
    },
    /// 0x4A1C: a number that is larger than any axis.
    #[error("{:#06x}: {place}, {field}: received {received:e}, expected a number from -1e15 to 1e15", self.code())]
    TooLarge {
        /// Place in the plate.
        place: PlateLocation,
        /// Field or column.
        field: &'static str,
        /// Value received.
        received: f64,
    },
    /// 0x4A06: the master does not ascend strictly.
    #[error("{:#06x}: {place}, master: received {received}, expected above {above}", self.code())]
    NotAscending {
        /// Place in the plate.
        place: PlateLocation,
        /// The master position there.
        received: f64,
        /// The master position it must be above.
        above: f64,
    },
    /// 0x42DB: the first or the last point is to be ignored.
    #[error("{:#06x}: point {point}: received point type ignore, expected the first and the last point in use", self.code())]
    EndIgnored {
        /// Number of the point.
        point: u32,
    },
    /// 0x42DB: a point leads backwards, nowhere or beyond the last one.
    #[error("{:#06x}: point {point}, relative next: received {relative_next}, expected 1 to {most}", self.code())]
    NextPoint {
        /// Number of the point.
        point: u32,
        /// Step to the next point received.
        relative_next: i32,
        /// Step to the last point.
        most: u32,
    },
    /// 0x42DB: the next point of a point is an ignored one.
    #[error("{:#06x}: point {point}, relative next: leads to point {next}, which is ignored, expected a point in use", self.code())]
    NextPointIgnored {
        /// Number of the point.
        point: u32,
        /// The point it leads to.
        next: u32,
    },
    /// 0x42DA: a point's value contradicts its kind.
    #[error("{:#06x}: point {point}, {field}: received {received}, expected 0 at a point of type {:?}", self.code(), .point_type.file_name())]
    PointContradicts {
        /// Number of the point.
        point: u32,
        /// Type of the point.
        point_type: PointType,
        /// Name of the value.
        field: &'static str,
        /// The value, for which the type requires 0.
        received: f64,
    },
    /// 0x4A12: points that add segments have no defined course.
    #[error("{:#06x}: point {point}: received point type add, which has no defined course, expected another one", self.code())]
    AddNotAvailable {
        /// Number of the point.
        point: u32,
    },
    /// The code of the law's own error: the law cannot lead from this point to the next one.
    #[error("{:#06x}: {}", self.code(), LawBetween { point: *point, next: *next, law: *law, error })]
    Law {
        /// The point the segment starts at.
        point: u32,
        /// The point it leads to.
        next: u32,
        /// The law between them.
        law: MotionLaw,
        /// Reason of the law.
        error: LawError,
    },
    /// 0x42DA: an inner spline point where no spline has begun.
    #[error("{:#06x}: point {point}: received an inner spline point, expected it after the first point of a spline", self.code())]
    SplineNotBegun {
        /// Number of the point.
        point: u32,
    },
    /// 0x42DA: a spline that is periodic at one end only.
    #[error("{:#06x}: spline from point {start} to point {end}: periodic at one end, expected at both or none", self.code())]
    SplineHalfPeriodic {
        /// The point it starts at.
        start: u32,
        /// The point it ends at.
        end: u32,
    },
    /// 0x4A21: a spline has too few points.
    #[error("{:#06x}: spline from point {start}: received {received} points, expected at least {least}", self.code())]
    TooFewSplinePoints {
        /// The point it starts at.
        start: u32,
        /// Number of its points.
        received: usize,
        /// Number of points it needs.
        least: usize,
    },
    /// 0x4A20: the slopes of a spline or a table are not finite: positions or distances are too
    /// extreme.
    #[error("{:#06x}: from {start}: received slopes that are not finite, expected less extreme positions", self.code())]
    NoFiniteSlopes {
        /// Start of the spline or the table.
        start: PlateLocation,
    },
    /// 0x4B36: a position table has no rows. 0x4A02: it has too few.
    #[doc(alias = "MC_ERROR_NUMROWS_INVALID")]
    #[error("{:#06x}: received {received} rows, expected at least {least}", self.code())]
    TooFewRows {
        /// Number of rows.
        received: usize,
        /// Number of rows that its interpolation needs.
        least: usize,
    },
    /// 0x4A04: a table declared equidistant is not.
    #[error("{:#06x}: row {row}, master: received {received}, expected {expected} at equal steps", self.code())]
    StepSize {
        /// Row, from 0.
        row: usize,
        /// The master position there.
        received: f64,
        /// The master position at equal steps.
        expected: f64,
    },
    /// 0x4A08: four-point interpolation is no longer supported.
    #[error("{:#06x}: four-point interpolation is no longer supported, expected linear, spline or sliding spline", self.code())]
    FourPoint,
    /// 0x4262: the plate is a position table where a motion function is needed.
    #[error("{:#06x}: received a table of type {received:?}, expected a motion function", self.code())]
    NotAMotionFunction {
        /// Type of the plate.
        received: TableType,
    },
    /// 0x4B38: an increment that never reaches the end.
    #[doc(alias = "MC_ERROR_INCREMENT_INVALID")]
    #[error("{:#06x}: increment: received {received}, expected a number other than 0 towards a distance of {distance}", self.code())]
    Increment {
        /// The increment.
        received: f64,
        /// The distance it should cover.
        distance: f64,
    },
    /// 0x4B36: a reading of values has too many rows.
    #[doc(alias = "MC_ERROR_NUMROWS_INVALID")]
    #[error("{:#06x}: received {received} rows of values, expected at most {most}: read the rest by another order", self.code())]
    TooManyValues {
        /// Number of rows.
        received: usize,
        /// Greatest number of rows.
        most: usize,
    },
    /// 0x4B37: a selection of values with unknown bits, or empty.
    #[doc(alias = "MC_ERROR_NUMCOLUMNS_INVALID")]
    #[error("{:#06x}: value selection: received {received:#06x}, expected a sum of some of 1, 2, 4 and 8", self.code())]
    NoColumns {
        /// The bits received.
        received: u16,
    },
    /// 0x4A1C: a parameter of a reading is not permitted.
    #[error("{:#06x}: {name}: received {received}, expected {expected}", self.code())]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Value received.
        received: f64,
        /// Permitted values.
        expected: &'static str,
    },
}

/// Place in a plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlateLocation {
    /// The point with that index, in a motion function.
    Point(u32),
    /// The row, from 0, in a position table.
    Row(usize),
}

impl PlateLocation {
    /// Returns the row, from 0.
    const fn row(self) -> usize {
        match self {
            Self::Point(point) => (point as usize).saturating_sub(1),
            Self::Row(row) => row,
        }
    }
}

impl CamError {
    /// Makes the error of a spline, with the start of the spline or the table.
    pub(super) const fn from_spline(error: NoFiniteSlopes, start: PlateLocation) -> Self {
        let NoFiniteSlopes = error;
        Self::NoFiniteSlopes { start }
    }

    /// Returns the point or the row of the error, or the start of the piece; from 0.
    #[must_use]
    pub const fn row(&self) -> Option<usize> {
        match *self {
            Self::PointIndex { row, .. } | Self::StepSize { row, .. } => Some(row),
            Self::NotFinite { place, .. }
            | Self::TooLarge { place, .. }
            | Self::NotAscending { place, .. }
            | Self::NoFiniteSlopes { start: place } => Some(place.row()),
            Self::Law {
                next: point,
                // A value at the end of a law is the next point's: there it has to be corrected.
                error:
                    LawError::Boundary {
                        side: Side::End, ..
                    },
                ..
            }
            | Self::Law { point, .. }
            | Self::EndIgnored { point }
            | Self::NextPoint { point, .. }
            | Self::NextPointIgnored { point, .. }
            | Self::PointContradicts { point, .. }
            | Self::AddNotAvailable { point }
            | Self::SplineNotBegun { point }
            | Self::SplineHalfPeriodic { start: point, .. }
            | Self::TooFewSplinePoints { start: point, .. } => {
                Some(PlateLocation::Point(point).row())
            }
            Self::TooFewPoints { .. }
            | Self::UnknownPoint { .. }
            | Self::NoPoints
            | Self::TooFewRows { .. }
            | Self::FourPoint
            | Self::NotAMotionFunction { .. }
            | Self::Increment { .. }
            | Self::TooManyValues { .. }
            | Self::NoColumns { .. }
            | Self::Parameter { .. } => None,
        }
    }

    /// Returns the NC error code.
    #[must_use]
    pub fn code(&self) -> u32 {
        match self {
            Self::NotAMotionFunction { .. } => 0x4262,
            Self::PointContradicts { .. }
            | Self::SplineNotBegun { .. }
            | Self::SplineHalfPeriodic { .. } => 0x42DA,
            Self::EndIgnored { .. } | Self::NextPoint { .. } | Self::NextPointIgnored { .. } => {
                0x42DB
            }
            Self::Law { error, .. } => error.code(),
            // `MC_ERROR_NUMROWS_INVALID` of TF5050 8.12.
            Self::TooFewRows { received: 0, .. } | Self::TooManyValues { .. } => 0x4B36,
            Self::TooFewRows { .. } => 0x4A02,
            Self::StepSize { .. } => 0x4A04,
            Self::NotAscending { .. } => 0x4A06,
            Self::FourPoint => 0x4A08,
            Self::AddNotAvailable { .. } => 0x4A12,
            Self::NotFinite { .. } | Self::TooLarge { .. } | Self::Parameter { .. } => 0x4A1C,
            Self::PointIndex { .. } => 0x4A1F,
            Self::NoFiniteSlopes { .. } => 0x4A20,
            Self::TooFewSplinePoints { .. } => 0x4A21,
            Self::TooFewPoints { .. } => 0x4A23,
            Self::UnknownPoint { .. } => 0x4B33,
            Self::NoPoints => 0x4B34,
            Self::NoColumns { .. } => 0x4B37,
            Self::Increment { .. } => 0x4B38,
        }
    }
}

impl fmt::Display for PlateLocation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Point(index) => write!(f, "point {index}"),
            Self::Row(row) => write!(f, "row {row}"),
        }
    }
}

/// Error between two points, in the words of a cam file.
struct LawBetween<'a> {
    point: u32,
    next: u32,
    law: MotionLaw,
    error: &'a LawError,
}

impl fmt::Display for LawBetween<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            point,
            next,
            law,
            error,
        } = self;
        // The name in a cam file and not the type's, since the text is shown beside the file.
        let law = law.file_name();
        match error {
            LawError::Boundary {
                side,
                quantity,
                received,
                expected,
                ..
            } => {
                let at = match side {
                    Side::Start => point,
                    Side::End => next,
                };
                let field = field_of(*quantity);
                write!(
                    f,
                    "point {at}, {field}: received {received}, expected {expected} at the {side} of law {law:?}, which \
                     leads from point {point} to point {next}"
                )
            }
            error => write!(f, "law {law:?} from point {point} to point {next}: {error}"),
        }
    }
}

/// Returns the name of the quantity in a cam file.
const fn field_of(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Master => "master",
        Quantity::Position => "slave",
        Quantity::Velocity => "velocity",
        Quantity::Acceleration => "acceleration",
        Quantity::Jerk => "jerk",
    }
}
