//! Numbers that know their range.

use coaxle_clock::{CycleTime, Span};
use serde::{Deserialize, Serialize};

/// A number that lies outside the range of its field.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("received {}, expected {expected}", readable(*.received))]
pub struct OutOfRange {
    received: f64,
    expected: &'static str,
}

/// A number without hundreds of zeros.
fn readable(number: f64) -> String {
    if number == 0.0 || (1e-9..1e15).contains(&number.abs()) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

macro_rules! checked_number {
    ($(#[$meta:meta])* $name:ident, $expected:literal, $test:expr) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[serde(try_from = "f64", into = "f64")]
        pub struct $name(f64);

        impl $name {
            /// # Errors
            /// [`OutOfRange`] when the number is.
            pub fn new(number: f64) -> Result<Self, OutOfRange> {
                let test: fn(f64) -> bool = $test;
                if number.is_finite() && test(number) {
                    Ok(Self(number))
                } else {
                    Err(OutOfRange { received: number, expected: $expected })
                }
            }

            /// The number.
            #[must_use]
            pub const fn get(self) -> f64 {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = OutOfRange;
            fn try_from(number: f64) -> Result<Self, OutOfRange> {
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
    Finite, "a finite number", |_| true
}

checked_number! {
    /// A finite number above zero.
    Positive, "a finite number above 0", |n| n > 0.0
}

checked_number! {
    /// A finite number, zero or above.
    AtLeastZero, "a finite number of at least 0", |n| n >= 0.0
}

checked_number! {
    /// A position of an axis, or how far it goes, u: a thousandth of what a receiver believes at most.
    Coordinate, "a number from -1000000000000 to 1000000000000", |n| (-1e12..=1e12).contains(&n)
}

checked_number! {
    /// What an axis may do at most, u/s and so on: as much as a receiver believes.
    AxisLimit, "a number above 0, at most 1000000000000000", |n| n > 0.0 && n <= 1e15
}

checked_number! {
    /// The length of an increment of an encoder, u.
    Increment, "a number from 0.000000000001 to 1000000000000", |n| (1e-12..=1e12).contains(&n)
}

checked_number! {
    /// A share: 0 to 1.
    Fraction, "a number from 0 to 1", |n| (0.0..=1.0).contains(&n)
}

checked_number! {
    /// A delay, µs: up to a second, either way.
    DelayMicros, "a number from -1000000 to 1000000", |n| (-1e6..=1e6).contains(&n)
}

checked_number! {
    /// How long something takes that a fault makes take longer, µs: up to a minute and a half or so.
    FaultMicros, "a number from 0 to 100000000", |n| (0.0..=1e8).contains(&n)
}

checked_number! {
    /// When or for how long, s: up to thirty years.
    FaultSeconds, "a number from 0 to 1000000000", |n| (0.0..=1e9).contains(&n)
}

checked_number! {
    /// How long something runs, s: up to eleven days.
    DurationSeconds, "a number above 0, at most 1000000", |n| n > 0.0 && n <= 1e6
}

checked_number! {
    /// A period, s: from a microsecond on.
    PeriodSeconds, "a number from 0.000001 to 1000000000", |n| (1e-6..=1e9).contains(&n)
}

checked_number! {
    /// A change of a delay, or a jump of a clock, µs.
    ChangeMicros, "a number from -100000000 to 100000000", |n| (-1e8..=1e8).contains(&n)
}

checked_number! {
    /// A drift, ppm: no clock is off by more than a tenth.
    Ppm, "a number from -100000 to 100000", |n| n.abs() <= Ppm::MOST
}

checked_number! {
    /// A random walk of a drift, ppm per √s.
    WalkPpm, "a number from 0 to 1000", |n| (0.0..=1e3).contains(&n)
}

impl Ppm {
    /// The largest drift, ppm.
    pub const MOST: f64 = 1e5;
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
                Self(0.0)
            }
        }
    )*};
}

zero_by_default!(
    Coordinate,
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
    /// As a span.
    #[must_use]
    pub fn span(self) -> Span {
        Span::from_micros_f64(self.0)
    }
}

impl ChangeMicros {
    /// As a span.
    #[must_use]
    pub fn span(self) -> Span {
        Span::from_micros_f64(self.0)
    }
}

impl FaultSeconds {
    /// As a span.
    #[must_use]
    pub fn span(self) -> Span {
        Span::from_secs_f64(self.0)
    }
}

/// The count of a first cycle: as many of the longest cycles take more than a hundred years, which far time holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "u64", into = "u64")]
pub struct FirstCount(u64);

impl FirstCount {
    const MOST: u64 = 40_000_000_000;

    /// The count.
    #[must_use]
    pub const fn get(self) -> u64 {
        self.0
    }

    /// Whether counts begin where they do without faults.
    #[must_use]
    pub const fn is_zero(&self) -> bool {
        self.0 == 0
    }
}

impl TryFrom<u64> for FirstCount {
    type Error = OutOfRange;
    fn try_from(count: u64) -> Result<Self, OutOfRange> {
        if count <= Self::MOST {
            return Ok(Self(count));
        }
        Err(OutOfRange {
            received: count as f64,
            expected: "a count of at most 40000000000",
        })
    }
}

impl From<FirstCount> for u64 {
    fn from(count: FirstCount) -> Self {
        count.0
    }
}

/// A cycle time in microseconds, 100 to 100 000.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct CycleMicros(pub CycleTime);

impl TryFrom<f64> for CycleMicros {
    type Error = OutOfRange;
    fn try_from(micros: f64) -> Result<Self, OutOfRange> {
        CycleTime::new(Span::from_micros_f64(micros))
            .map(Self)
            .map_err(|_| OutOfRange {
                received: micros,
                expected: "100 to 100000 µs",
            })
    }
}

impl From<CycleMicros> for f64 {
    fn from(cycle: CycleMicros) -> Self {
        // Dividing gives the closest number: 1000.3, not 1000.3000000000001.
        cycle.0.span().as_nanos() as Self / 1e3
    }
}
