//! Modulo axes: positions within the modulo period.

use crate::travel_direction::TravelDirection;

/// The length of a modulo period, u. Positions count continuously across periods; within a period
/// they are from 0 up to less than its length.
#[doc(alias = "ModuloFactor")]
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(inline, extend("exclusiveMinimum" = 0))
)]
#[cfg_attr(feature = "serde", serde(try_from = "f64", into = "f64"))]
pub struct Modulo(f64);

/// An invalid length of a modulo period.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("received {received}, expected a finite number above 0")]
pub struct WrongModulo {
    /// The length, u.
    pub received: f64,
}

/// A position of a modulo axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModuloPosition {
    /// Position within its period, from 0 up to less than the length, u.
    #[doc(alias = "ModuloSetPos")]
    pub within: f64,
    /// Number of whole periods before it, saturated.
    #[doc(alias = "ModuloSetTurns")]
    pub turns: i32,
}

impl Modulo {
    /// Creates a modulo period of this length, u.
    ///
    /// # Errors
    /// [`WrongModulo`] unless it is finite and above 0.
    pub fn new(length: f64) -> Result<Self, WrongModulo> {
        if length > 0.0 && length.is_finite() {
            Ok(Self(length))
        } else {
            Err(WrongModulo { received: length })
        }
    }

    /// The length of the period, u.
    #[must_use]
    pub const fn length(self) -> f64 {
        self.0
    }

    /// Splits a position by the period.
    #[must_use]
    pub fn of(self, position: f64) -> ModuloPosition {
        // Exact for any number of turns, unlike position - turns·length.
        let rest = libm::fmod(position, self.0);
        let within = if rest < 0.0 { rest + self.0 } else { rest };
        // Just below the beginning of a period, the remainder is rounded up to a whole period.
        let within = if within < self.0 { within } else { 0.0 };
        let turns = libm::round((position - within) / self.0);
        ModuloPosition {
            within,
            // The cast saturates: 2³¹ turns are farther than a counter of the PLC can say.
            turns: turns as i32,
        }
    }

    /// True if this position exists within a period.
    #[must_use]
    pub fn has(self, within: f64) -> bool {
        (0.0..self.0).contains(&within)
    }

    /// The next position at which an axis passes `within` its period, in this direction from
    /// `here`: never here itself, and at most a period ahead.
    #[must_use]
    pub fn next(self, within: f64, here: f64, ahead: TravelDirection) -> f64 {
        // Rounded once: the present position, a whole number of turns on, is recognised and not returned.
        let at = |turns: f64| libm::fma(turns, self.0, within);
        let turns = libm::floor((here - within) / self.0);
        // The rounded quotient may be off by one period, in both directions.
        let around = [-1.0, 0.0, 1.0, 2.0].map(|k| at(turns + k));
        match ahead {
            TravelDirection::Forward => {
                let next = around.into_iter().find(|position| *position > here);
                next.unwrap_or(around[3])
            }
            TravelDirection::Backward => {
                let next = around.into_iter().rev().find(|position| *position < here);
                next.unwrap_or(around[0])
            }
        }
    }
}

impl TryFrom<f64> for Modulo {
    type Error = WrongModulo;
    fn try_from(length: f64) -> Result<Self, WrongModulo> {
        Self::new(length)
    }
}

impl From<Modulo> for f64 {
    fn from(modulo: Modulo) -> Self {
        modulo.0
    }
}

impl ModuloPosition {
    /// Splits the position of an axis by the period; without a period, the position itself.
    #[must_use]
    pub fn of(position: f64, modulo: Option<Modulo>) -> Self {
        let whole = Self {
            within: position,
            turns: 0,
        };
        modulo.map_or(whole, |modulo| modulo.of(position))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn degrees() -> Modulo {
        Modulo::new(360.0).expect("a length")
    }

    #[test]
    fn positions_are_counted_by_the_turn() {
        for (position, within, turns) in [
            (0.0, 0.0, 0),
            (359.5, 359.5, 0),
            (360.0, 0.0, 1),
            (-90.0, 270.0, -1),
            (-360.0, 0.0, -1),
            (3_600_090.0, 90.0, 10_000),
        ] {
            assert_eq!(degrees().of(position), ModuloPosition { within, turns });
        }
        assert_eq!(
            degrees().of(-1e-20),
            ModuloPosition {
                within: 0.0,
                turns: 0
            }
        );
        assert_eq!(ModuloPosition::of(400.0, None).within, 400.0);
    }

    #[test]
    fn no_turn_has_no_length() {
        for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Modulo::new(length).is_err(), "{length}");
        }
    }

    #[test]
    fn at_the_position_itself_the_next_time_is_a_turn_ahead() {
        for turns in [-5_000.0, -1.0, 0.0, 3.0, 7_777.0] {
            let here = 90.0 + turns * 360.0;
            assert_eq!(
                degrees().next(90.0, here, TravelDirection::Forward),
                here + 360.0
            );
            assert_eq!(
                degrees().next(90.0, here, TravelDirection::Backward),
                here - 360.0
            );
        }
    }

    proptest! {
        #[test]
        fn the_next_time_is_ahead_within_a_turn_and_congruent(
            length in 1e-3..1e5f64,
            part in 0.0..1.0f64,
            turns in -50_000.0..50_000.0f64,
            forward: bool,
        ) {
            let modulo = Modulo::new(length).expect("a length");
            let (within, here) = (part * length, turns * length);
            prop_assume!(modulo.has(within));
            let way = if forward { TravelDirection::Forward } else { TravelDirection::Backward };
            let next = modulo.next(within, here, way);
            let ahead = if forward { next - here } else { here - next };
            let rounding = 1e-15 * next.abs().max(here.abs());
            prop_assert!(ahead > 0.0 && ahead <= length + 4.0 * rounding, "{ahead}");
            let off = (next - within) / length;
            prop_assert!((off - off.round()).abs() * length <= 8.0 * rounding, "{off}");
        }
    }
}
