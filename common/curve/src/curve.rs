//! Consecutive segments with a fast search.

use alloc::vec::Vec;

use crate::law::{Motion, Segment};

/// A course over the master, such as a plate's over one cycle: at least one segment, each of which begins
/// at the end of the previous one.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Begin of each segment, and end of the last one: kept apart from the segments, so that a search
    /// stays within few cache lines.
    masters: Vec<f64>,
    segments: Vec<Segment>,
    /// Segments per master unit if they all have the same length, else 0.
    density: f64,
}

impl Curve {
    /// Makes a curve with capacity for this number of segments.
    #[must_use]
    pub fn with_capacity(segments: usize) -> Self {
        Self {
            // A bound more than segments: the end of the last one.
            masters: Vec::with_capacity(segments + 1),
            segments: Vec::with_capacity(segments),
            density: 0.0,
        }
    }

    /// Removes all segments; the capacity stays.
    pub fn clear(&mut self) {
        self.masters.clear();
        self.segments.clear();
        self.density = 0.0;
    }

    /// Appends a segment, which begins at the end of the previous one.
    pub fn push(&mut self, segment: Segment) {
        if self.segments.is_empty() {
            self.masters.push(segment.start());
        }
        self.masters.push(segment.end());
        self.segments.push(segment);
    }

    /// Declares that all segments are about of the same length.
    pub fn settle_equidistant(&mut self) {
        // A guess by division takes constant time, a search among n points log₂ n steps.
        self.density = self.segments.len() as f64 / (self.end() - self.start());
    }

    /// Copies the segments of another curve into the present capacity.
    pub fn copy_from(&mut self, other: &Self) {
        self.clear();
        self.masters.extend_from_slice(&other.masters);
        self.segments.extend_from_slice(&other.segments);
        self.density = other.density;
    }

    /// Returns the begin of the first segment.
    #[must_use]
    #[inline]
    pub fn start(&self) -> f64 {
        self.masters[0]
    }

    /// Returns the end of the last segment.
    #[must_use]
    #[inline]
    pub fn end(&self) -> f64 {
        self.masters[self.segments.len()]
    }

    /// Returns the segments in their order.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Returns the motion at a master position from start to end.
    #[must_use]
    #[inline]
    pub fn at(&self, master: f64) -> Motion {
        self.segments[self.find(master)].at(master)
    }

    /// Returns the motion at a master position, searching from the last segment found.
    #[inline]
    pub fn along(&self, segment: &mut usize, master: f64) -> Motion {
        *segment = self
            .near(*segment, master)
            .unwrap_or_else(|| self.find(master));
        self.segments[*segment].at(master)
    }

    /// Returns the index of the segment of a master position: the one that begins there, or before.
    #[inline]
    fn find(&self, master: f64) -> usize {
        if self.density > 0.0 {
            // The lengths of the segments are only about equal, so it may be the next one.
            // A master before the start gives a negative number, which the conversion makes 0.
            let guess = ((master - self.start()) * self.density) as usize;
            if let Some(segment) = self.near(guess, master) {
                return segment;
            }
        }
        let inner_bounds = &self.masters[1..self.segments.len()];
        // Inner bounds only, so that places outside belong to the first and the last segment.
        inner_bounds.partition_point(|&bound| bound <= master)
    }

    /// Returns the index of the segment if it is this one or one beside it.
    #[inline]
    fn near(&self, hint: usize, master: f64) -> Option<usize> {
        let last = self.segments.len() - 1;
        let hint = hint.min(last);
        // The present segment first, then the next one: a
        // master usually runs forwards, from one to the other.
        [hint, (hint + 1).min(last), hint.saturating_sub(1)]
            .into_iter()
            .find(|&segment| self.belongs_to(segment, master))
    }

    #[inline]
    fn belongs_to(&self, segment: usize, master: f64) -> bool {
        let last = self.segments.len() - 1;
        // Open at both ends: rounding may put a wrapped master just outside.
        (self.masters[segment] <= master || segment == 0)
            && (master < self.masters[segment + 1] || segment == last)
    }
}
