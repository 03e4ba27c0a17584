//! Greatest demands of the segments of a curve, and their places.

use alloc::vec::Vec;

use coaxle_curve::curve::Curve;
use coaxle_curve::law::{Motion, Segment};

/// Distance of the evaluated places inside a segment from its ends, relative to its length: at a joint, a
/// derivative may have two values.
// A law's curvature differs there from that at its end by about 1e-8 of its peak (quintic: 60e-9/5.77).
const INSIDE: f64 = 1e-9;

/// Least distance of such a place from its joint, relative to the largest master of the curve: a place nearer than the rounding of
/// the masters, in one of the next cycles, is on the other side of its joint.
// 64 units in the last place: enough for some thirty cycles. In a segment of a ten-millionth of that master a cubic's curvature differs by
// 3e-7 of its peak then, less than the 1e-6 that a coupling allows beyond a limit. Found by fuzzing: 1.7 x of a plate of 12 857 000 x.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Distance of the places beside a reversal from it, relative to that of the places inside a segment.
// A reversal is a root, which is found to some units in the last place, and the slave brakes on one side of it alone.
const BESIDE: f64 = 10.0;

/// Greatest distance, relative to the length of the segment: both places stay in it.
const MOST_INSIDE: f64 = 0.25;

/// Slope at which the slave reverses, relative to the greatest one of the segment: rounding determines
/// its sign.
// A place is computed to some 1e-16 of the master, which may be 1e9 times as large as the segment is long.
const REVERSING: f64 = 1e-6;

/// Greatest demands of a part of a plate on its slave, as magnitudes, for a master that runs forwards.
/// Backwards, the slave brakes where it speeds up forwards.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PeakDemands {
    /// Slope, u/x.
    pub slope: f64,
    /// Curvature where the slave speeds up, u/x².
    pub speeding_up: f64,
    /// Curvature where it brakes, u/x².
    pub braking: f64,
}

/// Demands of the segments of a curve, in their order, and places of their extremes.
///
/// Extremes are roots of each law and take microseconds, so they are searched when a curve is compiled,
/// and not for each look ahead of a coupling.
#[derive(Clone, Debug)]
pub(super) struct CurvePeaks {
    segments: Vec<SegmentPeaks>,
    greatest: PeakDemands,
}

#[derive(Clone, Copy, Debug)]
struct SegmentPeaks {
    /// Masters at which the position is extreme: the slave reverses there, unless it is an end.
    reversals: [f64; 2],
    /// Masters at which slope and curvature are extreme.
    extremes: [f64; 4],
    demands: PeakDemands,
}

impl PeakDemands {
    /// Returns the greatest curvature, u/x².
    #[must_use]
    pub const fn curvature(&self) -> f64 {
        self.speeding_up.max(self.braking)
    }

    fn of(motion: &Motion, steepest: f64) -> Self {
        let Motion {
            velocity,
            acceleration,
            ..
        } = *motion;
        let reverses = velocity.abs() <= REVERSING * steepest;
        let counts = |is_so: bool| if is_so { acceleration.abs() } else { 0.0 };
        Self {
            slope: velocity.abs(),
            speeding_up: counts(reverses || velocity * acceleration >= 0.0),
            braking: counts(reverses || velocity * acceleration < 0.0),
        }
    }

    const fn joined(self, other: Self) -> Self {
        Self {
            slope: self.slope.max(other.slope),
            speeding_up: self.speeding_up.max(other.speeding_up),
            braking: self.braking.max(other.braking),
        }
    }
}

impl CurvePeaks {
    /// Number of places in a segment: both ends, both sides of two reversals, and four extremes.
    pub(super) const PLACES: usize = 10;

    /// Makes an empty list with capacity for this number of segments.
    pub(super) fn with_capacity(segments: usize) -> Self {
        Self {
            segments: Vec::with_capacity(segments),
            greatest: PeakDemands::default(),
        }
    }

    /// Searches the peaks of a curve.
    pub(super) fn of(curve: &Curve) -> Self {
        let mut peaks = Self::with_capacity(curve.segments().len());
        peaks.search(curve);
        peaks
    }

    /// Takes the peaks of a curve.
    pub(super) fn search(&mut self, curve: &Curve) {
        self.search_changed(curve, &Curve::default(), &Self::with_capacity(0));
    }

    /// Takes the peaks of a curve that has replaced another one: those of unchanged segments are copied.
    pub(super) fn search_changed(&mut self, curve: &Curve, old: &Curve, old_peaks: &Self) {
        self.segments.clear();
        let mut known = old.segments().iter().zip(&old_peaks.segments).peekable();
        for segment in curve.segments() {
            // The segments of both ascend.
            while known
                .next_if(|(old, _)| old.start() < segment.start())
                .is_some()
            {}
            let peaks = match known.peek() {
                Some((old, peaks)) if *old == segment => **peaks,
                _ => SegmentPeaks::of(segment),
            };
            self.segments.push(peaks);
        }
        let demands = self.segments.iter().map(|peaks| peaks.demands);
        self.greatest = demands.fold(PeakDemands::default(), PeakDemands::joined);
    }

    /// Returns the places in the segments of the curve whose demands `is_searched` accepts.
    pub(super) fn places<'a>(
        &'a self,
        curve: &'a Curve,
        is_searched: impl Fn(&PeakDemands) -> bool + 'a,
    ) -> impl Iterator<Item = f64> + 'a {
        let segments = curve.segments().iter().zip(&self.segments);
        let largest = curve.start().abs().max(curve.end().abs());
        segments
            .filter(move |(_, peaks)| is_searched(&peaks.demands))
            .flat_map(move |(segment, peaks)| peaks.places(segment, largest))
    }

    /// Returns the greatest demands of all segments.
    pub(super) const fn greatest(&self) -> &PeakDemands {
        &self.greatest
    }

    /// Copies the peaks of another curve into the present capacity.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.segments.clear();
        self.segments.extend_from_slice(&other.segments);
        self.greatest = other.greatest;
    }
}

impl SegmentPeaks {
    fn of(segment: &Segment) -> Self {
        let (reversals, extremes) = extreme_masters(segment);
        let [a, b] = reversals;
        let [c, d, e, f] = extremes;
        let motions = [segment.start(), a, b, c, d, e, f, segment.end()].map(|m| segment.at(m));
        let steepest = motions.iter().map(|motion| motion.velocity.abs());
        let steepest = steepest.fold(0.0, f64::max);
        let demands = motions.map(|motion| PeakDemands::of(&motion, steepest));
        Self {
            reversals,
            extremes,
            demands: demands.into_iter().fold(demands[0], PeakDemands::joined),
        }
    }

    /// Returns the places: just inside the ends, beside each reversal, and at the other extremes.
    fn places(&self, segment: &Segment, largest_master: f64) -> impl Iterator<Item = f64> + use<> {
        let (start, end) = (segment.start(), segment.end());
        let length = end - start;
        let inside = (INSIDE * length).max(ROUNDING * largest_master);
        let inside = inside.min(MOST_INSIDE * length);
        let ends = [start + inside, end - inside];
        // At the reversal itself, the sign of a slope of nearly 0 would tell whether the slave brakes.
        let sides = self.reversals.into_iter().flat_map(move |reversal| {
            [reversal - BESIDE * inside, reversal + BESIDE * inside]
                .map(|side| side.max(ends[0]).min(ends[1]))
        });
        ends.into_iter().chain(sides).chain(self.extremes)
    }
}

/// Masters at which the position is extreme, and those of slope and curvature.
fn extreme_masters(segment: &Segment) -> ([f64; 2], [f64; 4]) {
    let extremes = segment.extremes();
    let [position, velocity, acceleration] =
        [extremes.position, extremes.velocity, extremes.acceleration];
    let reversals = [position.minimum, position.maximum].map(|extreme| extreme.master);
    // No jerk among them: couplings compare slope and curvature of a plate with the slave's limits.
    let others = [
        velocity.minimum,
        velocity.maximum,
        acceleration.minimum,
        acceleration.maximum,
    ];
    (reversals, others.map(|extreme| extreme.master))
}
