//! Segments one after the other, found quickly.

use alloc::vec::Vec;

use crate::law::{Motion, Segment};

/// A course over the master, such as a plate's over one cycle: at least one segment, each begins where the one before
/// ends.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Where each segment begins, and where the last one ends: apart from the segments, so that a
    /// search stays within few cache lines.
    masters: Vec<f64>,
    segments: Vec<Segment>,
    /// Segments per master unit if they are all of one length, else 0.
    density: f64,
}

impl Curve {
    /// Room for so many segments.
    #[must_use]
    pub fn with_capacity(segments: usize) -> Self {
        Self {
            masters: Vec::with_capacity(segments + 1),
            segments: Vec::with_capacity(segments),
            density: 0.0,
        }
    }

    /// Leaves no segment; the room stays.
    pub fn clear(&mut self) {
        self.masters.clear();
        self.segments.clear();
        self.density = 0.0;
    }

    /// Appends a segment, which begins where the one before ends.
    pub fn push(&mut self, segment: Segment) {
        if self.segments.is_empty() {
            self.masters.push(segment.start());
        }
        self.masters.push(segment.end());
        self.segments.push(segment);
    }

    /// Says that all segments are about of one length.
    pub fn settle_equidistant(&mut self) {
        self.density = self.segments.len() as f64 / (self.end() - self.start());
    }

    /// The same segments, in the room there is.
    pub fn copy_from(&mut self, other: &Self) {
        self.clear();
        self.masters.extend_from_slice(&other.masters);
        self.segments.extend_from_slice(&other.segments);
        self.density = other.density;
    }

    /// Where the first segment begins.
    #[must_use]
    #[inline]
    pub fn start(&self) -> f64 {
        self.masters[0]
    }

    /// Where the last segment ends.
    #[must_use]
    #[inline]
    pub fn end(&self) -> f64 {
        self.masters[self.segments.len()]
    }

    /// All segments in their order.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The motion at a master position from start to end.
    #[must_use]
    #[inline]
    pub fn at(&self, master: f64) -> Motion {
        self.segments[self.find(master)].at(master)
    }

    /// The same, looking first where the last look ended.
    #[inline]
    pub fn along(&self, segment: &mut usize, master: f64) -> Motion {
        *segment = self
            .near(*segment, master)
            .unwrap_or_else(|| self.find(master));
        self.segments[*segment].at(master)
    }

    /// Which segment a master position belongs to: the one that begins there, or before.
    #[inline]
    fn find(&self, master: f64) -> usize {
        if self.density > 0.0 {
            // The segments are only about of one length, so it may be the next one.
            let guess = ((master - self.start()) * self.density) as usize;
            if let Some(segment) = self.near(guess, master) {
                return segment;
            }
        }
        let inner_bounds = &self.masters[1..self.segments.len()];
        inner_bounds.partition_point(|&bound| bound <= master)
    }

    /// The same if it is this segment or one beside it.
    #[inline]
    fn near(&self, hint: usize, master: f64) -> Option<usize> {
        let last = self.segments.len() - 1;
        let hint = hint.min(last);
        [hint, (hint + 1).min(last), hint.saturating_sub(1)]
            .into_iter()
            .find(|&segment| self.belongs_to(segment, master))
    }

    #[inline]
    fn belongs_to(&self, segment: usize, master: f64) -> bool {
        let last = self.segments.len() - 1;
        (self.masters[segment] <= master || segment == 0)
            && (master < self.masters[segment + 1] || segment == last)
    }
}
