//! Points of a plate in a command.

use core::ops::Deref;

use coaxle_curve::law::MotionLaw;
use coaxle_plate::{MotionPoint, PointType};

/// Points of a motion function, one to four, stored in place: a command allocates no memory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(extend("minItems" = 1, "maxItems" = CamPoints::MOST))
)]
#[cfg_attr(
    feature = "serde",
    serde(
        try_from = "alloc::vec::Vec<MotionPoint>",
        into = "alloc::vec::Vec<MotionPoint>"
    )
)]
pub struct CamPoints {
    points: [MotionPoint; CamPoints::MOST],
    count: usize,
}

impl CamPoints {
    /// Greatest number of points in a command.
    pub const MOST: usize = 4;

    /// Takes the points.
    ///
    /// # Errors
    /// [`WrongNumberOfPoints`] if there are none, or more than four.
    pub fn new(points: &[MotionPoint]) -> Result<Self, WrongNumberOfPoints> {
        let count = points.len();
        if !(1..=Self::MOST).contains(&count) {
            return Err(WrongNumberOfPoints { received: count });
        }
        // An array and no list: commands are copied on the cycle path, where nothing may allocate.
        let mut taken = [UNUSED; Self::MOST];
        taken[..count].copy_from_slice(points);
        Ok(Self {
            points: taken,
            count,
        })
    }
}

// Never read: a slice ends at the count.
const UNUSED: MotionPoint = MotionPoint {
    index: 0,
    function: MotionLaw::Polynom1,
    point_type: PointType::Ignore,
    relative_next: 1,
    master: 0.0,
    slave: 0.0,
    velocity: 0.0,
    acceleration: 0.0,
    jerk: 0.0,
};

impl Deref for CamPoints {
    type Target = [MotionPoint];

    fn deref(&self) -> &[MotionPoint] {
        &self.points[..self.count]
    }
}

#[cfg(feature = "serde")]
impl TryFrom<alloc::vec::Vec<MotionPoint>> for CamPoints {
    type Error = WrongNumberOfPoints;

    fn try_from(points: alloc::vec::Vec<MotionPoint>) -> Result<Self, WrongNumberOfPoints> {
        Self::new(&points)
    }
}

#[cfg(feature = "serde")]
impl From<CamPoints> for alloc::vec::Vec<MotionPoint> {
    fn from(points: CamPoints) -> Self {
        points.to_vec()
    }
}

/// More points than a command can carry, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "0x4b34: received {received} points, expected 1 to {}",
    CamPoints::MOST
)]
pub struct WrongNumberOfPoints {
    /// Number of points received.
    pub received: usize,
}
