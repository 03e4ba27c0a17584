//! Points as written in files and orders.

use alloc::vec::Vec;

use super::point::{MotionPoint, PointType};
use coaxle_curve::law::MotionLaw;

/// A point of a motion function. Omitted values are 0; the type of the point follows from its values.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", schemars(rename = "CamPoint"))]
pub struct WrittenPoint {
    /// Number of the point; its place in the list by default, from 1.
    pub index: Option<u32>,
    /// The motion law from here to the next point. The last point needs none.
    pub law: Option<MotionLaw>,
    /// Type of the point; by default that of its velocity and acceleration.
    #[serde(rename = "type")]
    pub point_type: Option<PointType>,
    /// Number of rows to the next point; 1 by default.
    #[serde(default = "next_row")]
    pub relative_next: i32,
    /// Position of the master, x.
    pub master: f64,
    /// Position of the slave, u.
    pub slave: f64,
    /// Velocity of the slave, u/x.
    #[serde(default)]
    pub velocity: f64,
    /// Acceleration of the slave, u/x².
    #[serde(default)]
    pub acceleration: f64,
    /// Jerk of the slave, u/x³.
    #[serde(default)]
    pub jerk: f64,
}

const fn next_row() -> i32 {
    1
}

impl WrittenPoint {
    /// Returns the points with omitted values filled in.
    ///
    /// # Errors
    /// The row, from 0, of the first point without a law: only the last point and ignored ones need none.
    pub fn to_points(written: &[Self]) -> Result<Vec<MotionPoint>, usize> {
        // An empty list has no last row and must not underflow: the plate refuses it with its own text.
        let last = written.len().saturating_sub(1);
        let rows = written.iter().enumerate();
        rows.map(|(row, point)| point.filled_in(row, row == last).ok_or(row))
            .collect()
    }

    /// Fills in omitted values; none if its law is missing.
    fn filled_in(&self, row: usize, is_last: bool) -> Option<MotionPoint> {
        let point_type = self.point_type.unwrap_or_else(|| self.implied_type());
        let unused = is_last || point_type == PointType::Ignore;
        Some(MotionPoint {
            index: self.index.unwrap_or(row as u32 + 1),
            // A stated law is kept even at the last point, where that of a spline is its end condition.
            function: self.law.or(unused.then_some(MotionLaw::Polynom1))?,
            point_type,
            relative_next: self.relative_next,
            master: self.master,
            slave: self.slave,
            velocity: self.velocity,
            acceleration: self.acceleration,
            jerk: self.jerk,
        })
    }

    /// Returns the type of point that has its values.
    #[must_use]
    pub fn implied_type(&self) -> PointType {
        match (self.velocity != 0.0, self.acceleration != 0.0) {
            (false, false) => PointType::Rest,
            (true, false) => PointType::Velocity,
            (false, true) => PointType::Turn,
            (true, true) => PointType::Motion,
        }
    }
}

/// Writes all values explicitly.
impl From<&MotionPoint> for WrittenPoint {
    fn from(point: &MotionPoint) -> Self {
        Self {
            index: Some(point.index),
            // Explicit even at the last point: a spline's end condition there would otherwise be lost on
            // reading back.
            law: Some(point.function),
            point_type: Some(point.point_type),
            relative_next: point.relative_next,
            master: point.master,
            slave: point.slave,
            velocity: point.velocity,
            acceleration: point.acceleration,
            jerk: point.jerk,
        }
    }
}
