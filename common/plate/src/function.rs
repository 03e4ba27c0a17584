//! Motion functions: a cam of few points with a law from each to the next.

use alloc::vec::Vec;
use core::cell::RefCell;
use core::fmt;
use core::mem;
use core::ops::Range;

use super::compile::compile;
use super::curve_peaks::CurvePeaks;
use super::error::CamError;
use super::point::MotionPoint;
use coaxle_curve::curve::Curve;
use coaxle_curve::spline::SplineSolver;

/// A motion function: points, checked and compiled to segments. TF5050 chapters 2 and 6.
///
/// The number of rows is fixed. Points for later use are kept as
/// [`PointType::Ignore`](super::PointType::Ignore).
#[doc(alias = "MC_TABLETYPE_MOTIONFUNCTION")]
#[doc(alias = "MC_WriteMotionFunction")]
#[doc(alias = "MC_WriteMotionFunctionPoint")]
#[doc(alias = "MC_ReadMotionFunction")]
#[doc(alias = "MC_ReadMotionFunctionPoint")]
pub struct MotionFunction {
    points: Vec<MotionPoint>,
    curve: Curve,
    peaks: CurvePeaks,
    /// A change is built here in full before it replaces the function in force. Its remains are not part
    /// of the function.
    stage: RefCell<StagedPoints>,
}

struct StagedPoints {
    points: Vec<MotionPoint>,
    curve: Curve,
    peaks: CurvePeaks,
    splines: SplineSolver,
}

impl MotionFunction {
    /// Makes a motion function of at least two points, in the order of their indices.
    ///
    /// # Errors
    /// [`CamError`] names the first invalid point, and the expected value.
    pub fn new(points: Vec<MotionPoint>) -> Result<Self, CamError> {
        // All memory that a later change needs is reserved here, where allocating is allowed.
        let mut function = Self::with_room_for(points);
        compile(
            &function.points,
            &mut function.stage.get_mut().splines,
            &mut function.curve,
        )?;
        function.peaks.search(&function.curve);
        Ok(function)
    }

    /// Returns the rows, ignored points included.
    #[must_use]
    pub fn points(&self) -> &[MotionPoint] {
        &self.points
    }

    /// `MC_ReadMotionFunctionPoint`: the point with an index.
    ///
    /// # Errors
    /// 0x4B33 if there is none.
    pub fn point(&self, index: u32) -> Result<&MotionPoint, CamError> {
        Ok(&self.points[self.row(index)?])
    }

    /// `MC_ReadMotionFunction`: up to `count` points from an index on, all following ones for 0.
    ///
    /// # Errors
    /// 0x4B33 if the first one does not exist.
    pub fn read(&self, first: u32, count: usize) -> Result<&[MotionPoint], CamError> {
        let from_first = &self.points[self.row(first)?..];
        // 0 means all following points in the block's input, and a greater number than there are is no error.
        let count = if count == 0 { usize::MAX } else { count };
        Ok(&from_first[..count.min(from_first.len())])
    }

    /// `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint`: replaces the points with the same
    /// indices, all at once. Of two with one index the later one counts.
    ///
    /// Nothing is allocated; it may run in the cycle.
    ///
    /// # Errors
    /// As [`Self::new`], 0x4B33 for an index beyond the rows, 0x4B34 without points. Then everything is
    /// unchanged.
    pub fn change(&mut self, points: &[MotionPoint]) -> Result<(), CamError> {
        self.check_change(points)?;
        let stage = self.stage.get_mut();
        // Only of segments that differ: a point has two, and a write to a plate of thousands stays quick.
        stage
            .peaks
            .search_changed(&stage.curve, &self.curve, &self.peaks);
        // Swapped, not moved: nothing is freed in the cycle, and the old buffers are the next stage.
        mem::swap(&mut self.points, &mut stage.points);
        mem::swap(&mut self.curve, &mut stage.curve);
        mem::swap(&mut self.peaks, &mut stage.peaks);
        Ok(())
    }

    /// Checks whether [`Self::change`] would accept these points; nothing in force changes.
    ///
    /// # Errors
    /// As [`Self::change`].
    pub fn check_change(&self, points: &[MotionPoint]) -> Result<(), CamError> {
        if points.is_empty() {
            return Err(CamError::NoPoints);
        }
        // Shared reference, since a dry run plans without changing anything in force.
        // No borrow outlives this function, so borrowing cannot fail.
        let mut stage = self.stage.borrow_mut();
        stage.points.clear();
        stage.points.extend_from_slice(&self.points);
        for point in points {
            // A later point with the same index overwrites the earlier one, as consecutive writes of the PLC would.
            let row = self.row(point.index)?;
            stage.points[row] = *point;
        }
        let StagedPoints {
            points,
            curve,
            splines,
            ..
        } = &mut *stage;
        compile(points, splines, curve)
    }

    /// Returns the range of the master, in x, in which [`Self::change`] would alter the course: from the
    /// first segment that differs to the last, of the old and the new ones. Empty if the course stays.
    ///
    /// # Errors
    /// As [`Self::change`].
    pub fn segments_changed(&mut self, points: &[MotionPoint]) -> Result<Range<f64>, CamError> {
        self.check_change(points)?;
        Ok(difference(&self.curve, &self.stage.get_mut().curve))
    }

    /// Copies another motion function with an equal number of points: then nothing is allocated.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.points.clear();
        self.points.extend_from_slice(&other.points);
        self.curve.copy_from(&other.curve);
        self.peaks.copy_from(&other.peaks);
    }

    pub(super) fn curve(&self) -> &Curve {
        &self.curve
    }

    pub(super) const fn peaks(&self) -> &CurvePeaks {
        &self.peaks
    }

    /// Returns the points last checked by [`Self::check_change`].
    pub(super) fn staged_points(&mut self) -> &[MotionPoint] {
        &self.stage.get_mut().points
    }

    /// Returns the curve built from them.
    pub(super) fn staged_curve(&mut self) -> &Curve {
        &self.stage.get_mut().curve
    }

    fn row(&self, index: u32) -> Result<usize, CamError> {
        let row = (index as usize).wrapping_sub(1);
        if row < self.points.len() {
            Ok(row)
        } else {
            Err(CamError::UnknownPoint {
                received: index,
                last: self.points.len() as u32,
            })
        }
    }

    /// Takes the points, not compiled yet, and allocates the memory that any change to them can need.
    fn with_room_for(points: Vec<MotionPoint>) -> Self {
        let rows = points.len();
        Self {
            points,
            // No more segments than rows, even after a change that brings all reserved points into use.
            curve: Curve::with_capacity(rows),
            peaks: CurvePeaks::with_capacity(rows),
            stage: RefCell::new(StagedPoints {
                points: Vec::with_capacity(rows),
                curve: Curve::with_capacity(rows),
                peaks: CurvePeaks::with_capacity(rows),
                // In the worst case one spline runs through all points.
                splines: SplineSolver::with_capacity(rows),
            }),
        }
    }
}

impl fmt::Debug for MotionFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MotionFunction")
            .field("points", &self.points)
            .field("curve", &self.curve)
            .finish_non_exhaustive()
    }
}

/// Implemented by hand, since a cloned vector keeps no spare capacity.
impl Clone for MotionFunction {
    fn clone(&self) -> Self {
        let mut copy = Self::with_room_for(self.points.clone());
        copy.curve.copy_from(&self.curve);
        copy.peaks.copy_from(&self.peaks);
        copy
    }
}

/// Returns the range from the start of the first segment that is not in both to the end of the last.
fn difference(old: &Curve, new: &Curve) -> Range<f64> {
    // Compared as compiled: a point edited inside a spline changes all of its pieces, far beyond its neighbours.
    let same = |(a, b): &(_, _)| a == b;
    let (before, after) = (old.segments(), new.segments());
    let head = before.iter().zip(after).take_while(same).count();
    // Empty range at the start: without it the fold below would return infinities.
    if head == before.len() && head == after.len() {
        return old.start()..old.start();
    }
    let (before, after) = (&before[head..], &after[head..]);
    let tail = before
        .iter()
        .rev()
        .zip(after.iter().rev())
        .take_while(same)
        .count();
    let (before, after) = (&before[..before.len() - tail], &after[..after.len() - tail]);
    // Old and new segments may end at different masters, and a slave may be within either.
    let both = || before.iter().chain(after);
    let start = both().fold(f64::INFINITY, |least, s| least.min(s.start()));
    let end = both().fold(f64::NEG_INFINITY, |most, s| most.max(s.end()));
    start..end
}
