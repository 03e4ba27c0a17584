//! Places of the greatest demands of a plate on its slave.

use super::curve_peaks::{CurvePeaks, PeakDemands};
use super::plate::Plate;

impl Plate {
    /// Number of places in a segment: both ends, both sides of two reversals, and four extremes.
    pub const PEAKS_OF_A_SEGMENT: usize = CurvePeaks::PLACES;

    /// Returns the masters of the base cycle, x, at which slope or curvature can be extreme, in the
    /// segments whose demands `is_searched` accepts: both ends, just inside, the places at which the
    /// law's slope and curvature are extreme, and both sides of those at which the slave reverses.
    pub fn peaks<'a>(
        &'a self,
        is_searched: impl Fn(&PeakDemands) -> bool + 'a,
    ) -> impl Iterator<Item = f64> + 'a {
        self.curve_peaks().places(self.curve(), is_searched)
    }

    /// Returns the greatest demands of all segments.
    #[must_use]
    pub const fn greatest_demands(&self) -> &PeakDemands {
        self.curve_peaks().greatest()
    }
}
