//! Instants, spans and seconds.
//!
//! An [`Instant`] carries the clock that read it in its type. Two instants of different clocks have nothing in common
//! until one is mapped onto the other, so this does not compile:
//!
//! ```compile_fail
//! use coaxle_clock::{Instant, Local, Remote};
//! let here: Instant<Local> = Instant::from_nanos(10);
//! let there: Instant<Remote> = Instant::from_nanos(4);
//! let nonsense = here - there;
//! ```

use core::cmp::Ordering;
use core::fmt;
use core::hash::{Hash, Hasher};
use core::marker::PhantomData;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use crate::numbers::rounded;

/// A clock that instants can belong to.
pub trait Domain: 'static {
    /// The clock's name, for people.
    const NAME: &'static str;
}

/// The clock of the node that runs this code.
pub enum Local {}

/// The clock of the sender whose axis is followed.
pub enum Remote {}

impl Domain for Local {
    const NAME: &'static str = "local";
}

impl Domain for Remote {
    const NAME: &'static str = "remote";
}

/// A point in time as the clock `D` reads it, in whole nanoseconds since an epoch of that clock's
/// own. Good for 292 years.
pub struct Instant<D: Domain> {
    nanos: i64,
    domain: PhantomData<fn() -> D>,
}

impl<D: Domain> Instant<D> {
    /// The clock's own epoch.
    pub const EPOCH: Self = Self::from_nanos(0);

    /// The instant `nanos` nanoseconds after the clock's epoch.
    #[must_use]
    pub const fn from_nanos(nanos: i64) -> Self {
        Self {
            nanos,
            domain: PhantomData,
        }
    }

    /// Nanoseconds since the clock's epoch.
    #[must_use]
    pub const fn as_nanos(self) -> i64 {
        self.nanos
    }

    /// Time since the clock's epoch.
    #[must_use]
    pub const fn since_epoch(self) -> Span {
        Span::from_nanos(self.nanos)
    }
}

impl<D: Domain> Clone for Instant<D> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<D: Domain> Copy for Instant<D> {}

impl<D: Domain> Default for Instant<D> {
    fn default() -> Self {
        Self::EPOCH
    }
}

impl<D: Domain> PartialEq for Instant<D> {
    fn eq(&self, other: &Self) -> bool {
        self.nanos == other.nanos
    }
}

impl<D: Domain> Eq for Instant<D> {}

impl<D: Domain> PartialOrd for Instant<D> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<D: Domain> Ord for Instant<D> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.nanos.cmp(&other.nanos)
    }
}

impl<D: Domain> Hash for Instant<D> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.nanos.hash(state);
    }
}

impl<D: Domain> fmt::Debug for Instant<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}+{} ns", D::NAME, self.nanos)
    }
}

impl<D: Domain> Add<Span> for Instant<D> {
    type Output = Self;
    fn add(self, span: Span) -> Self {
        Self::from_nanos(self.nanos.saturating_add(span.0))
    }
}

impl<D: Domain> AddAssign<Span> for Instant<D> {
    fn add_assign(&mut self, span: Span) {
        *self = *self + span;
    }
}

impl<D: Domain> Sub<Span> for Instant<D> {
    type Output = Self;
    fn sub(self, span: Span) -> Self {
        Self::from_nanos(self.nanos.saturating_sub(span.0))
    }
}

impl<D: Domain> Sub for Instant<D> {
    type Output = Span;
    fn sub(self, earlier: Self) -> Span {
        Span(self.nanos.saturating_sub(earlier.nanos))
    }
}

/// A signed length of time in whole nanoseconds. Arithmetic saturates.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct Span(i64);

impl Span {
    /// No time at all.
    pub const ZERO: Self = Self(0);
    /// The longest span there is; saturated arithmetic ends here.
    pub const MAX: Self = Self(i64::MAX);

    /// A span of whole nanoseconds.
    #[must_use]
    pub const fn from_nanos(nanos: i64) -> Self {
        Self(nanos)
    }

    /// A span of whole microseconds.
    #[must_use]
    pub const fn from_micros(micros: i64) -> Self {
        Self(micros.saturating_mul(1_000))
    }

    /// A span of whole milliseconds.
    #[must_use]
    pub const fn from_millis(millis: i64) -> Self {
        Self(millis.saturating_mul(1_000_000))
    }

    /// A span of whole seconds.
    #[must_use]
    pub const fn from_secs(secs: i64) -> Self {
        Self(secs.saturating_mul(1_000_000_000))
    }

    /// The span nearest to `secs` seconds; saturates, and NaN becomes zero.
    #[must_use]
    pub fn from_secs_f64(secs: f64) -> Self {
        Self(rounded(secs * 1e9))
    }

    /// The span nearest to `micros` microseconds; saturates, and NaN becomes zero.
    #[must_use]
    pub fn from_micros_f64(micros: f64) -> Self {
        Self(rounded(micros * 1e3))
    }

    /// Nanoseconds.
    #[must_use]
    pub const fn as_nanos(self) -> i64 {
        self.0
    }

    /// Microseconds.
    #[must_use]
    pub fn as_micros_f64(self) -> f64 {
        self.0 as f64 * 1e-3
    }

    /// Seconds.
    #[must_use]
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// Number of whole `unit`s that fit, rounded towards minus infinity. `unit` must be positive.
    #[must_use]
    pub const fn div_floor(self, unit: Self) -> i64 {
        self.0.div_euclid(unit.0)
    }

    /// The span without its sign.
    #[must_use]
    pub const fn abs(self) -> Self {
        Self(self.0.saturating_abs())
    }

    /// True if the span is shorter than nothing.
    #[must_use]
    pub const fn is_negative(self) -> bool {
        self.0 < 0
    }
}

impl fmt::Debug for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ns", self.0)
    }
}

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Dividing gives the closest number: 2.3 s, not 2.3000000000000003 s.
        match self.0.unsigned_abs() {
            0..1_000 => write!(f, "{} ns", self.0),
            1_000..1_000_000 => write!(f, "{} µs", self.0 as f64 / 1e3),
            1_000_000..1_000_000_000 => write!(f, "{} ms", self.0 as f64 / 1e6),
            _ => write!(f, "{} s", self.0 as f64 / 1e9),
        }
    }
}

impl Add for Span {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl AddAssign for Span {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Span {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl SubAssign for Span {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Neg for Span {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.saturating_neg())
    }
}

impl Mul<i64> for Span {
    type Output = Self;
    fn mul(self, factor: i64) -> Self {
        Self(self.0.saturating_mul(factor))
    }
}

impl Div<i64> for Span {
    type Output = Self;
    fn div(self, divisor: i64) -> Self {
        Self(self.0 / divisor)
    }
}

/// A length of time in seconds as a real number: the type of a correction time, since a nanosecond is too coarse a
/// step for a velocity derived from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(inline))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct Seconds(pub f64);

impl Seconds {
    /// No time at all.
    pub const ZERO: Self = Self(0.0);

    /// Microseconds.
    #[must_use]
    pub fn as_micros(self) -> f64 {
        self.0 * 1e6
    }

    /// The span nearest to it.
    #[must_use]
    pub fn to_span(self) -> Span {
        Span::from_secs_f64(self.0)
    }
}

impl From<Span> for Seconds {
    fn from(span: Span) -> Self {
        Self(span.as_secs_f64())
    }
}

impl Add for Seconds {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Seconds {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

/// Spans as numbers of microseconds in files and messages.
#[cfg(feature = "serde")]
pub(crate) mod micros {
    use serde::{Deserialize, Deserializer, Serializer};

    use super::Span;

    pub(crate) fn serialize<S: Serializer>(span: &Span, out: S) -> Result<S::Ok, S::Error> {
        out.serialize_f64(span.as_micros_f64())
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(input: D) -> Result<Span, D::Error> {
        f64::deserialize(input).map(Span::from_micros_f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    #[test]
    fn instants_of_one_clock_differ_by_a_span() {
        let start: Instant<Local> = Instant::from_nanos(1_000);
        let later = start + Span::from_micros(3);
        assert_eq!(later - start, Span::from_nanos(3_000));
        assert_eq!(start - later, Span::from_nanos(-3_000));
        assert!(later > start);
    }

    #[test]
    fn arithmetic_saturates_instead_of_wrapping() {
        assert_eq!(Span::MAX + Span::from_secs(1), Span::MAX);
        assert_eq!(Span::from_secs(i64::MAX), Span::MAX);
        assert_eq!(Span::from_secs_f64(f64::INFINITY), Span::MAX);
        assert_eq!(Span::from_secs_f64(f64::NAN), Span::ZERO);
    }

    #[test]
    fn spans_are_written_in_the_unit_a_person_would_use() {
        assert_eq!(format!("{}", Span::from_nanos(12)), "12 ns");
        assert_eq!(format!("{}", Span::from_nanos(-1_500)), "-1.5 µs");
        assert_eq!(format!("{}", Span::from_micros(250)), "250 µs");
        assert_eq!(format!("{}", Span::from_millis(2)), "2 ms");
        assert_eq!(format!("{}", Span::from_secs(3)), "3 s");
        assert_eq!(format!("{}", Span::from_millis(2_300)), "2.3 s");
        assert_eq!(format!("{}", Span::from_nanos(1_000_300)), "1.0003 ms");
    }

    #[test]
    fn whole_units_round_towards_minus_infinity() {
        let unit = Span::from_millis(1);
        assert_eq!(Span::from_nanos(-1).div_floor(unit), -1);
        assert_eq!(Span::from_nanos(999_999).div_floor(unit), 0);
        assert_eq!(Span::from_nanos(1_000_000).div_floor(unit), 1);
    }
}
