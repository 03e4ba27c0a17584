//! What one measurement of the timing channel is worth.

/// A mean over so many measurements at most …
const MEMORY: f64 = 60.0;
/// … of which a single one counts at most so many times the mean.
const OUTLIER: f64 = 9.0;
/// No measurement scatters less, s²: stamps have whole nanoseconds, and clocks are read one after the other.
const LEAST: f64 = 25e-18;
/// The scatter of the measurements, by how far each is off the line through those beside it: no offset and no drift
/// is in that.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    variance: f64,
    count: f64,
    /// The last two, each with its time, s.
    last: [(f64, f64); 2],
    seen: u8,
}

impl Noise {
    pub(super) const fn new() -> Self {
        Self {
            variance: 0.0,
            count: 0.0,
            last: [(0.0, 0.0); 2],
            seen: 0,
        }
    }

    /// Taken for the first measurement: a quarter of the round trip is all that can be known.
    pub(super) fn first(&mut self, round_trip: f64) -> f64 {
        self.variance = (0.0625 * round_trip * round_trip).max(100.0 * LEAST);
        self.variance
    }

    /// The variance of a measurement, s².
    pub(super) const fn variance(&self) -> f64 {
        self.variance
    }

    /// Takes the next measurement, of a later time than the one before, s.
    pub(super) fn take(&mut self, time: f64, measured: f64) {
        let [(from, before), (at, between)] = self.last;
        if self.seen >= 2 {
            let part = (at - from) / (time - from);
            let off = between - before - part * (measured - before);
            let weight = 1.0 + part * part + (1.0 - part) * (1.0 - part);
            let sample = (off * off / weight).min(OUTLIER * self.variance);
            self.count = (self.count + 1.0).min(MEMORY);
            self.variance += (sample - self.variance) / (self.count + 2.0);
            self.variance = self.variance.max(LEAST);
        }
        self.last = [(at, between), (time, measured)];
        self.seen = (self.seen + 1).min(2);
    }
}

/// How long both ways usually take together.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoundTrip {
    usual: f64,
    scatter: f64,
    count: f64,
}

/// What is longer by so many times its usual scatter was held up.
const HELD_UP: f64 = 3.0;

impl RoundTrip {
    pub(super) const fn new() -> Self {
        Self {
            usual: 0.0,
            scatter: 0.0,
            count: 0.0,
        }
    }

    /// As a rule, s.
    pub(super) const fn usual(&self) -> f64 {
        self.usual
    }

    /// Takes the next one. By how much it is longer than usual, s.
    pub(super) fn take(&mut self, round_trip: f64) -> f64 {
        if self.count == 0.0 {
            (self.usual, self.scatter, self.count) = (round_trip, 0.5 * round_trip.max(0.0), 1.0);
            return 0.0;
        }
        self.count = (self.count + 1.0).min(MEMORY);
        let off = round_trip - self.usual;
        let bound = HELD_UP * self.scatter + 1e-9;
        let clipped = off.clamp(-bound, bound);
        self.usual += clipped / self.count;
        self.scatter += (libm::fabs(clipped) - self.scatter) / self.count;
        (off - bound).max(0.0)
    }
}
