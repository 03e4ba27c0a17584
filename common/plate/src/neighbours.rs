//! Motion of the slave on the other sides of a segment's ends.

use super::compile::{next_of, segment};
use super::kind::Course;
use super::plate::Plate;
use super::point::{MotionPoint, PointType};
use super::source::PlateSource;
use coaxle_curve::law::Segment;

/// Slack for rounding, relative to the magnitudes involved.
pub(super) const ROUNDING: f64 = 1e-9;

/// Motion of the slave on the other sides of the points.
pub(super) struct Neighbours<'a> {
    points: &'a [MotionPoint],
    course: Course,
    /// Set if the plate is valid: then the pieces of splines are known, too.
    plate: Option<Plate>,
}

impl<'a> Neighbours<'a> {
    pub(super) fn of(source: &PlateSource, points: &'a [MotionPoint]) -> Self {
        Self {
            points,
            course: source.course,
            plate: source.plate().ok(),
        }
    }

    /// Returns the motion at the end of the segment that leads to a row, along the course. Before a linear
    /// plate the slave rests.
    pub(super) fn before(&self, row: usize) -> NeighbourMotion {
        let last = self.points.len() - 1;
        let here = match (row, self.course) {
            (0, Course::Linear) => return NeighbourMotion::Acceleration(0.0, 0.0),
            (0, Course::Cyclic) => last,
            (row, _) => row,
        };
        match self.row_before(here) {
            Some(from) if from == row => NeighbourMotion::Itself,
            Some(from) => self.motion_beyond(from, here, Segment::end),
            None => NeighbourMotion::Unknown,
        }
    }

    /// Returns the row from which the course leads to another one.
    fn row_before(&self, here: usize) -> Option<usize> {
        let mut row = 0;
        // Along the course and not backwards row by row: ignored and skipped rows may lead here, too.
        while row < here {
            match next_of(self.points, row) {
                Ok(next) if next == here => return Some(row),
                Ok(next) => row = next,
                // Where an invalid point breaks the course off, it continues with the next row in use.
                Err(_) => row = self.row_in_use_after(row)?,
            }
        }
        None
    }

    fn row_in_use_after(&self, row: usize) -> Option<usize> {
        let is_used = |row: &usize| self.points[*row].point_type != PointType::Ignore;
        (row + 1..self.points.len()).find(is_used)
    }

    /// Returns the motion at the start of the segment that begins at the row `next`. After a linear plate
    /// the slave rests.
    pub(super) fn after(&self, row: usize, next: usize) -> NeighbourMotion {
        let last = self.points.len() - 1;
        let here = match (next == last, self.course) {
            (true, Course::Linear) => return NeighbourMotion::Acceleration(0.0, 0.0),
            (true, Course::Cyclic) => 0,
            (false, _) => next,
        };
        match next_of(self.points, here) {
            Ok(_) if here == row => NeighbourMotion::Itself,
            Ok(to) => self.motion_beyond(here, to, Segment::start),
            Err(_) => NeighbourMotion::Unknown,
        }
    }

    fn motion_beyond(&self, from: usize, to: usize, side: fn(&Segment) -> f64) -> NeighbourMotion {
        let (from, to) = (&self.points[from], &self.points[to]);
        let compiled = self.plate.as_ref().and_then(|plate| {
            let segments = plate.curve().segments();
            let piece = |segment: &&Segment| segment.start() >= from.master;
            // The first piece of a spline begins here, the last one ends there.
            let first = segments.iter().find(piece)?;
            let last = segments
                .iter()
                .rev()
                .find(|segment| segment.end() <= to.master)?;
            // A start belongs to the first piece of a spline, an end to the last one.
            Some(if side(first) == first.start() {
                *first
            } else {
                *last
            })
        });
        // The plate need not be valid: then the neighbour's own law is compiled alone, if its points allow it.
        match compiled.or_else(|| segment(from, to).ok()) {
            None => NeighbourMotion::Unknown,
            Some(piece) => {
                let acceleration = piece.at(side(&piece)).acceleration;
                NeighbourMotion::Acceleration(
                    acceleration,
                    piece.extremes().acceleration.magnitude(),
                )
            }
        }
    }
}

/// Motion of the slave on the other side of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NeighbourMotion {
    /// Acceleration there, and the greatest of that segment, u/x².
    Acceleration(f64, f64),
    /// The examined segment, which follows itself: the only one of a cyclic plate.
    Itself,
    /// A segment that is not valid.
    Unknown,
}

impl NeighbourMotion {
    /// Returns the size of the step from here, or to here; 0 within rounding, of the magnitudes on both
    /// sides.
    pub(super) fn step(self, here: f64, other_end: f64, size: f64) -> f64 {
        let (there, its_size) = match self {
            Self::Acceleration(there, size) => (there, size),
            // At its seam a cyclic plate of one segment goes from this law's end to its own start.
            Self::Itself => (other_end, size),
            // No step is held against a law for a neighbour that is itself invalid.
            Self::Unknown => (here, size),
        };
        over_rounding((here - there).abs(), size.max(its_size))
    }
}

/// Returns a step if it exceeds the rounding of numbers of that size, else 0.
pub(super) fn over_rounding(step: f64, size: f64) -> f64 {
    if step <= ROUNDING * size { 0.0 } else { step }
}
