//! Two clocks of a machine, read at one instant.

/// Number of readings of both clocks; the narrowest counts.
const READINGS: usize = 9;

/// Readings of two clocks at one instant, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClockPair {
    /// The clock that was read before and after the other one: the middle of both.
    pub clock: i64,
    /// The other clock.
    pub other: i64,
    /// Greatest time between the two.
    pub apart: i64,
}

impl ClockPair {
    /// Reads both: `clock`, `other`, `clock`, several times.
    pub fn read(clock: impl Fn() -> i64, other: impl Fn() -> i64) -> Self {
        let read = |_| {
            let (before, between, after) = (clock(), other(), clock());
            // An interruption between the readings widens them; the narrowest is off by half its width at most.
            let apart = (after - before) / 2;
            Self {
                clock: before + apart,
                other: between,
                apart: apart + 1,
            }
        };
        let mut narrowest = read(0);
        for reading in (1..READINGS).map(read) {
            if reading.apart < narrowest.apart {
                narrowest = reading;
            }
        }
        narrowest
    }
}
