//! What a plate is made of: plain data, before it is calculated.

use alloc::vec::Vec;

use super::error::{CamError, Place};
use super::function::MotionFunction;
use super::kind::{Course, TableType};
use super::plate::Plate;
use super::point::MotionPoint;
use super::table::{Interpolation, PositionTable};

/// What `MC_CamTableSelect` is given, TF5050 chapters 4.1 and 8.2: the data of a plate and whether it is repeated.
///
/// Unlike a [`Plate`] it can be shared between threads, and compared.
#[doc(alias = "MC_CAM_REF")]
#[derive(Clone, Debug, PartialEq)]
pub struct PlateSource {
    /// Whether it is passed once or repeated.
    pub course: Course,
    /// The data.
    pub rows: SourceRows,
}

/// The rows of a plate.
#[derive(Clone, Debug, PartialEq)]
pub enum SourceRows {
    /// Of a motion function.
    Points(Vec<MotionPoint>),
    /// Of a position table.
    Positions {
        /// Master, x, and slave, u.
        rows: Vec<(f64, f64)>,
        /// How to find the positions between the rows.
        interpolation: Interpolation,
        /// Whether the steps of the master are said to be equal.
        equidistant: bool,
    },
}

impl PlateSource {
    /// The largest number of a point or a row that is taken from outside, as a magnitude, x, u and their quotients.
    pub const LARGEST: f64 = 1e15;

    /// That no number is larger than any axis. What is no number at all [`Self::plate`] refuses itself.
    ///
    /// # Errors
    /// 0x4A1C with the first one that is.
    pub fn check_size(&self) -> Result<(), CamError> {
        let check = |place: Place, field: &'static str, received: f64| {
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
                let place = Place::Point(row as u32 + 1);
                check(place, "master", point.master)?;
                check(place, "slave", point.slave)?;
                check(place, "velocity", point.velocity)?;
                check(place, "acceleration", point.acceleration)?;
                check(place, "jerk", point.jerk)
            }),
            SourceRows::Positions { rows, .. } => {
                rows.iter().enumerate().try_for_each(|(row, position)| {
                    check(Place::Row(row), "master", position.0)?;
                    check(Place::Row(row), "slave", position.1)
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

    /// The same plate with these points in the place of those with the same index; a position table, and what has no
    /// such index, stays.
    #[must_use]
    pub fn with_points(&self, changed: &[MotionPoint]) -> Self {
        let mut source = self.clone();
        if let SourceRows::Points(points) = &mut source.rows {
            for point in changed {
                let row = (point.index as usize).wrapping_sub(1);
                if let Some(place) = points.get_mut(row) {
                    *place = *point;
                }
            }
        }
        source
    }

    /// How many points or rows it has.
    #[must_use]
    pub const fn len(&self) -> usize {
        match &self.rows {
            SourceRows::Points(points) => points.len(),
            SourceRows::Positions { rows, .. } => rows.len(),
        }
    }

    /// Whether it has none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Plate {
    /// What it is made of, as it is in force.
    #[must_use]
    pub fn source(&self) -> PlateSource {
        let rows = match (self.function(), self.table()) {
            (Some(function), _) => SourceRows::Points(function.points().to_vec()),
            (None, Some(table)) => SourceRows::Positions {
                rows: table.rows().to_vec(),
                interpolation: table.interpolation(),
                equidistant: table.table_type() == TableType::Equidistant,
            },
            (None, None) => SourceRows::Points(Vec::new()),
        };
        PlateSource {
            course: self.course(),
            rows,
        }
    }
}
