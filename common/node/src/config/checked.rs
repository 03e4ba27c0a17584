//! Numbers with a checked range.

use std::ops::Bound::{self, Excluded, Included, Unbounded};
use std::ops::RangeBounds;

use coaxle_clock::{CycleTime, Span};
use coaxle_wire::PresentAfter;
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};

use super::schema::readable;
use super::wrong::Wrong;

/// Adds the range to a schema.
// Given by the types, so that an editor refuses what the parser refuses.
fn add_range(schema: &mut Schema, (least, most): (Bound<f64>, Bound<f64>)) {
    let bounds = [
        (least, "minimum", "exclusiveMinimum"),
        (most, "maximum", "exclusiveMaximum"),
    ];
    for (bound, inclusive, exclusive) in bounds {
        match bound {
            Included(number) => schema.insert(inclusive.to_owned(), number.into()),
            Excluded(number) => schema.insert(exclusive.to_owned(), number.into()),
            Unbounded => None,
        };
    }
}

macro_rules! checked_number {
    ($(#[$meta:meta])* $name:ident, $expected:literal, $range:expr) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize, JsonSchema)]
        #[serde(try_from = "f64", into = "f64")]
        #[schemars(inline, transform = Self::bounded)]
        pub struct $name(f64);

        impl $name {
            const RANGE: (Bound<f64>, Bound<f64>) = $range;

            fn bounded(schema: &mut Schema) {
                add_range(schema, Self::RANGE);
            }

            /// # Errors
            /// [`Wrong`] if the number is out of range.
            pub fn new(number: f64) -> Result<Self, Wrong> {
                // Finite first: a range without an end contains infinity.
                if number.is_finite() && Self::RANGE.contains(&number) {
                    Ok(Self(number))
                } else {
                    Err(Wrong::value(readable(number), $expected))
                }
            }

            /// The number.
            #[must_use]
            pub const fn get(self) -> f64 {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = Wrong;
            fn try_from(number: f64) -> Result<Self, Wrong> {
                Self::new(number)
            }
        }

        impl From<$name> for f64 {
            fn from(number: $name) -> Self {
                number.0
            }
        }
    };
}

checked_number! {
    /// Any finite number.
    Finite, "a finite number", (Unbounded, Unbounded)
}

checked_number! {
    /// A finite number above zero.
    Positive, "a finite number above 0", (Excluded(0.0), Unbounded)
}

checked_number! {
    /// A finite number, zero or above.
    AtLeastZero, "a finite number of at least 0", (Included(0.0), Unbounded)
}

checked_number! {
    /// Position or distance of an axis, u: at most a thousandth of the limit that a receiver accepts.
    Coordinate, "a number from -1000000000000 to 1000000000000", (Included(-1e12), Included(1e12))
}

checked_number! {
    /// Limit of an axis, u/s and so on: at most the limit that a receiver accepts.
    AxisLimit, "a number above 0, at most 1000000000000000", (Excluded(0.0), Included(1e15))
}

checked_number! {
    /// The length of an increment of an encoder, u.
    Increment, "a number from 0.000000000001 to 1000000000000", (Included(1e-12), Included(1e12))
}

checked_number! {
    /// A share: 0 to 1.
    Fraction, "a number from 0 to 1", (Included(0.0), Included(1.0))
}

checked_number! {
    /// Greatest error of a common time, µs.
    CommonBoundMicros, "a number above 0, at most 100000", (Excluded(0.0), Included(1e5))
}

impl CommonBoundMicros {
    /// Error of clocks that PTP disciplines with stamps of network cards.
    pub const USUAL: Self = Self(1.0);
}

checked_number! {
    /// Beacons of the timing channel a second.
    BeaconsPerSecond, "a number from 1 to 200", (Included(1.0), Included(200.0))
}

impl BeaconsPerSecond {
    /// Rate that suits most clocks.
    pub const USUAL: Self = Self(50.0);
}

checked_number! {
    /// A delay, µs: up to a second, either way.
    DelayMicros, "a number from -1000000 to 1000000", (Included(-1e6), Included(1e6))
}

checked_number! {
    /// Time after its generation at which an axis is shown, ms: from the shortest cycle on.
    PresentAfterMs, "a number from 0.1 to 4000", (Included(0.1), Included(4e3))
}

checked_number! {
    /// Dead time of a drive, µs.
    DeadTimeMicros, "a number from 0 to 100000", (Included(0.0), Included(1e5))
}

checked_number! {
    /// Time by which the decisions on the motion of an axis are taken ahead, ms.
    LeadMs, "a number from 0 to 4000", (Included(0.0), Included(4e3))
}

checked_number! {
    /// Time without a report after which a follower has failed, ms: reports come every 50 ms.
    AgeLimitMs, "a number from 100 to 60000", (Included(1e2), Included(6e4))
}

checked_number! {
    /// Duration added by a fault, µs: up to about a minute and a half.
    FaultMicros, "a number from 0 to 100000000", (Included(0.0), Included(1e8))
}

checked_number! {
    /// Instant or duration, s: up to thirty years.
    FaultSeconds, "a number from 0 to 1000000000", (Included(0.0), Included(1e9))
}

checked_number! {
    /// Duration of a run, s: up to eleven days.
    DurationSeconds, "a number above 0, at most 1000000", (Excluded(0.0), Included(1e6))
}

checked_number! {
    /// A period, s: from a microsecond on.
    PeriodSeconds, "a number from 0.000001 to 1000000000", (Included(1e-6), Included(1e9))
}

checked_number! {
    /// A change of a delay, or a jump of a clock, µs.
    ChangeMicros, "a number from -100000000 to 100000000", (Included(-1e8), Included(1e8))
}

checked_number! {
    /// A drift, ppm: no clock is off by more than a tenth.
    Ppm, "a number from -100000 to 100000", (Included(-Ppm::MOST), Included(Ppm::MOST))
}

checked_number! {
    /// A random walk of a drift, ppm per √s.
    WalkPpm, "a number from 0 to 1000", (Included(0.0), Included(1e3))
}

impl Ppm {
    /// The largest drift, ppm.
    pub const MOST: f64 = 1e5;
}

impl PresentAfterMs {
    /// The field of a frame.
    #[must_use]
    pub fn delay(self) -> Option<PresentAfter> {
        PresentAfter::new(self.span())
    }

    /// The time.
    #[must_use]
    pub fn span(self) -> Span {
        Span::from_micros_f64(self.0 * 1e3)
    }
}

impl LeadMs {
    /// The time.
    #[must_use]
    pub fn span(self) -> Span {
        Span::from_micros_f64(self.0 * 1e3)
    }
}

impl AgeLimitMs {
    /// The time.
    #[must_use]
    pub fn span(self) -> Span {
        Span::from_micros_f64(self.0 * 1e3)
    }
}

impl Default for AgeLimitMs {
    fn default() -> Self {
        // Five reports may be lost, one after the other.
        Self(300.0)
    }
}

impl DeadTimeMicros {
    /// The time.
    #[must_use]
    pub fn span(self) -> Span {
        Span::from_micros_f64(self.0)
    }

    /// True without a dead time.
    #[must_use]
    // By reference: the attribute of serde that calls it passes one.
    pub fn is_zero(&self) -> bool {
        self.0 == 0.0
    }
}

impl DelayMicros {
    /// The delay.
    #[must_use]
    pub fn span(self) -> Span {
        Span::from_micros_f64(self.0)
    }
}

macro_rules! zero_by_default {
    ($($name:ident),*) => {$(
        impl Default for $name {
            fn default() -> Self {
                // `0.0` is within each of these ranges.
                Self(0.0)
            }
        }
    )*};
}

zero_by_default!(
    Coordinate,
    DeadTimeMicros,
    Finite,
    AtLeastZero,
    Fraction,
    FaultMicros,
    FaultSeconds,
    ChangeMicros,
    Ppm,
    WalkPpm
);

impl FaultMicros {
    /// Returns the value as a span.
    #[must_use]
    pub fn span(self) -> Span {
        Span::from_micros_f64(self.0)
    }
}

impl ChangeMicros {
    /// Returns the value as a span.
    #[must_use]
    pub fn span(self) -> Span {
        Span::from_micros_f64(self.0)
    }
}

impl FaultSeconds {
    /// Returns the value as a span.
    #[must_use]
    pub fn span(self) -> Span {
        Span::from_secs_f64(self.0)
    }
}

/// The count of a first cycle: this many of the longest cycles take more than a hundred years,
/// which far time holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "u64", into = "u64")]
#[schemars(inline, extend("maximum" = FirstCount::MOST))]
pub struct FirstCount(u64);

impl FirstCount {
    // 4·10¹⁰ cycles of 100 ms are 4·10⁹ s, 127 years; nanoseconds of an i64 last for 292.
    const MOST: u64 = 40_000_000_000;

    /// The count.
    #[must_use]
    pub const fn get(self) -> u64 {
        self.0
    }

    /// True if counts begin as without faults.
    #[must_use]
    // By reference: the attribute of serde that calls it passes one.
    pub const fn is_zero(&self) -> bool {
        self.0 == 0
    }
}

impl TryFrom<u64> for FirstCount {
    type Error = Wrong;
    fn try_from(count: u64) -> Result<Self, Wrong> {
        if count <= Self::MOST {
            return Ok(Self(count));
        }
        // Shown as a float: a count beyond 2⁵³ is refused anyway, and its last digits do not matter.
        let received = readable(count as f64);
        Err(Wrong::value(received, "a count of at most 40000000000"))
    }
}

impl From<FirstCount> for u64 {
    fn from(count: FirstCount) -> Self {
        count.0
    }
}

/// A cycle time in microseconds, 100 to 100 000.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "f64", into = "f64")]
#[schemars(inline, extend("minimum" = 100, "maximum" = 100_000))]
pub struct CycleMicros(pub CycleTime);

impl TryFrom<f64> for CycleMicros {
    type Error = Wrong;
    fn try_from(micros: f64) -> Result<Self, Wrong> {
        CycleTime::new(Span::from_micros_f64(micros))
            .map(Self)
            .map_err(|_| Wrong::value(readable(micros), "100 to 100000 µs"))
    }
}

impl From<CycleMicros> for f64 {
    fn from(cycle: CycleMicros) -> Self {
        // Dividing gives the closest number: 1000.3, not 1000.3000000000001.
        cycle.0.span().as_nanos() as Self / 1e3
    }
}
