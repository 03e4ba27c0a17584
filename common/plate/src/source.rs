//! Source data of a plate, before it is calculated.

use alloc::vec::Vec;

use super::error::{CamError, PlateLocation};
use super::function::MotionFunction;
use super::kind::{Course, TableType};
use super::plate::Plate;
use super::point::MotionPoint;
use super::table::{Interpolation, PositionTable};

/// Input of `MC_CamTableSelect`, TF5050 chapters 4.1 and 8.2: the data of a plate and its course.
///
/// Unlike a [`Plate`] it can be shared between threads, and compared.
#[doc(alias = "MC_CAM_REF")]
#[derive(Clone, Debug, PartialEq)]
pub struct PlateSource {
    /// Course: passed once or repeated.
    pub course: Course,
    /// The data.
    pub rows: SourceRows,
}

/// The rows of a plate.
#[derive(Clone, Debug, PartialEq)]
pub enum SourceRows {
    /// Points of a motion function.
    Points(Vec<MotionPoint>),
    /// Rows of a position table.
    Positions {
        /// Master, x, and slave, u.
        rows: Vec<(f64, f64)>,
        /// Interpolation between the rows.
        interpolation: Interpolation,
        /// True if the steps of the master are declared equal.
        equidistant: bool,
    },
}

impl PlateSource {
    /// Greatest number accepted in a point or a row from outside, as a magnitude, x, u and their
    /// quotients.
    // Neighbouring doubles are 0.125 apart from there on. Products of five such numbers are still finite.
    pub const LARGEST: f64 = 1e15;

    /// Checks that no number is larger than any axis. Numbers that are not finite are refused by
    /// [`Self::plate`].
    ///
    /// # Errors
    /// 0x4A1C with the first one that is too large.
    pub fn check_size(&self) -> Result<(), CamError> {
        let check = |place: PlateLocation, field: &'static str, received: f64| {
            // Left to the plate itself, numbers that are not finite are refused with their own text.
            if received.is_finite() && received.abs() > Self::LARGEST {
                return Err(CamError::TooLarge {
                    place,
                    field,
                    received,
                });
            }
            Ok(())
        };
        match &self.rows {
            SourceRows::Points(points) => points.iter().enumerate().try_for_each(|(row, point)| {
                // By the row, since the point's own index is not checked yet and may be anything.
                let place = PlateLocation::Point(row as u32 + 1);
                check(place, "master", point.master)?;
                check(place, "slave", point.slave)?;
                check(place, "velocity", point.velocity)?;
                check(place, "acceleration", point.acceleration)?;
                check(place, "jerk", point.jerk)
            }),
            SourceRows::Positions { rows, .. } => {
                rows.iter().enumerate().try_for_each(|(row, position)| {
                    check(PlateLocation::Row(row), "master", position.0)?;
                    check(PlateLocation::Row(row), "slave", position.1)
                })
            }
        }
    }

    /// Calculates the plate.
    ///
    /// # Errors
    /// As [`MotionFunction::new`], [`PositionTable::new`] and [`PositionTable::equidistant`].
    pub fn plate(&self) -> Result<Plate, CamError> {
        match &self.rows {
            SourceRows::Points(points) => Ok(Plate::from_function(
                MotionFunction::new(points.clone())?,
                self.course,
            )),
            SourceRows::Positions {
                rows,
                interpolation,
                equidistant,
            } => {
                let make = if *equidistant {
                    PositionTable::equidistant
                } else {
                    PositionTable::new
                };
                Ok(Plate::from_table(make(rows, *interpolation, self.course)?))
            }
        }
    }

    /// Returns the plate with these points in place of those with the same index. Points without such an
    /// index are ignored, and a position table stays unchanged.
    #[must_use]
    pub fn with_points(&self, changed: &[MotionPoint]) -> Self {
        let mut source = self.clone();
        if let SourceRows::Points(points) = &mut source.rows {
            for point in changed {
                // Index 0 wraps to the largest row, which no list has.
                let row = (point.index as usize).wrapping_sub(1);
                if let Some(place) = points.get_mut(row) {
                    *place = *point;
                }
            }
        }
        source
    }

    /// Returns the number of its points or rows.
    #[must_use]
    pub const fn len(&self) -> usize {
        match &self.rows {
            SourceRows::Points(points) => points.len(),
            SourceRows::Positions { rows, .. } => rows.len(),
        }
    }

    /// True if it has none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Plate {
    /// Returns the source of the plate in force.
    #[must_use]
    pub fn source(&self) -> PlateSource {
        let rows = match (self.function(), self.table()) {
            (Some(function), _) => SourceRows::Points(function.points().to_vec()),
            (None, Some(table)) => SourceRows::Positions {
                rows: table.rows().to_vec(),
                interpolation: table.interpolation(),
                equidistant: table.table_type() == TableType::Equidistant,
            },
            // A plate always has one of both, so no course is lost here.
            (None, None) => SourceRows::Points(Vec::new()),
        };
        PlateSource {
            course: self.course(),
            rows,
        }
    }
}
