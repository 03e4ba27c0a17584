//! Worth of one measurement of the timing channel.

use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the worth of a measurement.
    TimingNoiseTuning {
        /// Greatest number of measurements that the mean is over …
        // Ten seconds' worth at fifty exchanges a second.
        memory: f64 = 60.0,
        /// … and the multiple of the mean that a single one counts as at most.
        // Three standard deviations, squared.
        outlier: f64 = 9.0,
    }
}

/// Least scatter of a measurement, s²: 5 ns.
// Not tuned: a floor, so that measurements that agree by chance do not make the line infinitely sure. Stamps have whole nanoseconds,
// and clocks are read one after the other.
const LEAST_VARIANCE: f64 = 25e-18;

/// Scatter of the measurements, by how far each is off the line through those beside it: no offset and no drift is in
/// that.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    variance: f64,
    count: f64,
    /// The last two, each with its time, s.
    last: [(f64, f64); 2],
    more: [f64; 2],
    seen: u8,
}

impl Noise {
    pub(super) const fn new() -> Self {
        Self {
            variance: 0.0,
            count: 0.0,
            last: [(0.0, 0.0); 2],
            more: [0.0; 2],
            seen: 0,
        }
    }

    /// Begins with the first measurement: a quarter of the round trip is all that can be known.
    pub(super) fn first(&mut self, round_trip: f64) -> f64 {
        self.variance = (0.0625 * round_trip * round_trip).max(100.0 * LEAST_VARIANCE);
        self.variance
    }

    /// The variance of a measurement, s².
    pub(super) const fn variance(&self) -> f64 {
        self.variance
    }

    /// Takes the next measurement, of a later time than the one before, s. Its known further scatter is `more`, s².
    pub(super) fn take(&mut self, time: f64, measured: f64, more: f64) {
        let [(from, before), (at, between)] = self.last;
        if self.seen >= 2 {
            let part = (at - from) / (time - from);
            let off = between - before - part * (measured - before);
            // Variance of the miss of three equal values, in variances of one.
            let weight = 1.0 + part * part + (1.0 - part) * (1.0 - part);
            let known =
                self.more[1] + part * part * more + (1.0 - part) * (1.0 - part) * self.more[0];
            let sample =
                ((off * off - known).max(0.0) / weight).min(TUNING.outlier * self.variance);
            self.count = (self.count + 1.0).min(TUNING.memory);
            // The first guess counts as two measurements, or one lucky miss would make the line too sure.
            self.variance += (sample - self.variance) / (self.count + 2.0);
            self.variance = self.variance.max(LEAST_VARIANCE);
        }
        self.last = [(at, between), (time, measured)];
        self.more = [self.more[1], more];
        self.seen = (self.seen + 1).min(2);
    }
}

/// Shortest round trip of late: a longer one was held up on one of its ways, and it is unknown on which.
#[derive(Clone, Debug)]
pub(super) struct RoundTrip {
    kept: [f64; KEPT],
    /// The number of them that count.
    of: usize,
    next: usize,
    shortest: f64,
}

/// Measurements kept: ten seconds' worth at fifty exchanges a second.
pub(crate) const KEPT: usize = 64;

impl RoundTrip {
    /// Makes the minimum over `of` measurements, at most [`KEPT`].
    pub(super) fn new(of: usize) -> Self {
        Self {
            kept: [f64::INFINITY; KEPT],
            of: of.clamp(1, KEPT),
            next: 0,
            shortest: 0.0,
        }
    }

    /// The shortest, s.
    pub(super) const fn shortest(&self) -> f64 {
        self.shortest
    }

    /// Takes the next one. Returns its excess over the shortest, s.
    pub(super) fn take(&mut self, round_trip: f64) -> f64 {
        self.kept[self.next] = round_trip.max(0.0);
        self.next = (self.next + 1) % self.of;
        self.shortest = self.kept.iter().copied().fold(f64::INFINITY, f64::min);
        round_trip.max(0.0) - self.shortest
    }

    /// Replaces the newest one.
    pub(super) fn correct(&mut self, round_trip: f64) {
        self.next = (self.next + self.of - 1) % self.of;
        let _ = self.take(round_trip);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_measurement_that_was_held_up_changes_the_scatter_little() {
        let mut noise = Noise::new();
        let _ = noise.first(1e-6);
        let mut measure = |n: u32, off: f64| {
            let scatter = if n.is_multiple_of(2) { 50e-9 } else { -50e-9 };
            noise.take(0.16 * f64::from(n), scatter + off, 0.0);
            noise.variance()
        };
        let before = (0..400).map(|n| measure(n, 0.0)).last().unwrap();
        let _ = measure(400, 1e-3);
        let after = (401..403).map(|n| measure(n, 0.0)).last().unwrap();
        // Three second differences have a part of it.
        assert!((1.37..1.52).contains(&(after / before)), "{before} {after}");
    }
}
