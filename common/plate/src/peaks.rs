//! Places of the greatest demands of a plate on its slave.

use super::plate::Plate;
use coaxle_curve::law::Segment;

/// Greatest number of segments that are searched. Of plates with more, only the ends of the segments
/// count: tables have lines and cubics, with the extremes of the curvature at their ends. A peak inside
/// a segment of a motion function of more points is not among them.
// Extremes are roots of each law, and the look-ahead of a coupling asks for the peaks within a cycle.
const SEGMENTS_SEARCHED: usize = 256;

/// Distance of the evaluated places inside a segment from its ends, relative to its length: at a joint, a
/// derivative may have two values.
// A law's curvature differs there from that at its end by about 1e-8 of its peak (quintic: 60e-9/5.77).
const INSIDE: f64 = 1e-9;

impl Plate {
    /// Returns the masters of the base cycle, x, at which slope or curvature can be extreme: for each
    /// segment both ends, just inside it, and the places at which the law's slope and curvature are
    /// extreme or the slave reverses.
    pub fn peaks(&self) -> impl Iterator<Item = f64> + '_ {
        let segments = self.curve().segments();
        let is_searched = segments.len() <= SEGMENTS_SEARCHED;
        segments.iter().flat_map(move |segment| {
            let within = is_searched.then(|| extreme_masters(segment));
            ends(segment)
                .into_iter()
                .chain(within.into_iter().flatten())
        })
    }
}

fn ends(segment: &Segment) -> [f64; 2] {
    let (start, end) = (segment.start(), segment.end());
    let inside = INSIDE * (end - start);
    [start + inside, end - inside]
}

fn extreme_masters(segment: &Segment) -> [f64; 6] {
    let extremes = segment.extremes();
    let [position, velocity, acceleration] =
        [extremes.position, extremes.velocity, extremes.acceleration];
    [
        position.minimum,
        position.maximum,
        velocity.minimum,
        velocity.maximum,
        acceleration.minimum,
        acceleration.maximum,
    ]
    // No jerk among them: couplings compare slope and curvature of a plate with the slave's limits.
    .map(|extreme| extreme.master)
}
