//! Synchronisation positions: absolute ones, and ones relative to now.

use coaxle_axis::{Modulo, TravelDirection};

/// A synchronisation position of a command, before it is planned.
///
/// In a config and on the wire a plain number, or `{ "ahead": 500 }`, or `{ "in-turn": 90 }`. A
/// relative one is converted once into a position of its axis, when the command is planned, from
/// the positions of master and slave in that cycle. *Ahead* is the direction of the master; a
/// master at rest counts as moving to larger positions. For a slave it is the direction into which
/// the ratio then leads it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SyncPosition {
    /// Absolute position, u.
    At(f64),
    /// Distance ahead of the axis's current position, u.
    Ahead(f64),
    /// Next passage of a modulo axis at this position within its period, u, that passes the checks
    /// of the command. The next 8 of a master are tried; of a slave the next two, and the one
    /// behind it.
    InTurn(f64),
}

/// Periods of a master that are tried, in this order, counted from the next.
// With three periods of a slave 24 plans at most: the cycle that takes the command has to bear them all.
pub(super) const MASTER_TURNS: [i32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];
/// Periods of a slave that are tried, each with all of those of the master.
// The period behind the slave comes last: it begins with a way back.
pub(super) const SLAVE_TURNS: [i32; 3] = [0, 1, -1];

/// A relative position that does not exist for an axis.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WrongSyncPosition {
    /// Axis without a modulo period.
    #[error(
        "{:#06x}: {field}: received in-turn {received} of an axis without a modulo turn, expected a position, \
         or one ahead; or give the axis a modulo",
        self.code()
    )]
    NoModulo {
        /// Name of the position.
        field: &'static str,
        /// Value received.
        received: f64,
    },
    /// Position outside the modulo period.
    #[error(
        "{:#06x}: {field}: received in-turn {received}, expected 0 up to less than the modulo turn of {length}",
        self.code()
    )]
    NotInTurn {
        /// Name of the position.
        field: &'static str,
        /// Value received.
        received: f64,
        /// Length of the period, u.
        length: f64,
    },
}

impl WrongSyncPosition {
    /// NC error code.
    #[must_use]
    pub const fn code(&self) -> u32 {
        0x4b06
    }

    /// Name of the position in a command.
    #[must_use]
    pub const fn field(&self) -> &'static str {
        match self {
            Self::NoModulo { field, .. } | Self::NotInTurn { field, .. } => field,
        }
    }

    /// Value received, u.
    #[must_use]
    pub const fn received(&self) -> f64 {
        match self {
            Self::NoModulo { received, .. } | Self::NotInTurn { received, .. } => *received,
        }
    }
}

impl From<f64> for SyncPosition {
    fn from(position: f64) -> Self {
        Self::At(position)
    }
}

impl SyncPosition {
    /// The absolute position, if it is one.
    #[must_use]
    pub const fn as_position(&self) -> Option<f64> {
        match self {
            Self::At(position) => Some(*position),
            Self::Ahead(_) | Self::InTurn(_) => None,
        }
    }

    /// Checks that the position exists for an axis with this modulo period.
    ///
    /// # Errors
    /// [`WrongSyncPosition`] names the field.
    pub(super) fn check(
        &self,
        field: &'static str,
        modulo: Option<Modulo>,
    ) -> Result<(), WrongSyncPosition> {
        let Self::InTurn(received) = *self else {
            return Ok(());
        };
        match modulo {
            None => Err(WrongSyncPosition::NoModulo { field, received }),
            Some(modulo) if modulo.has(received) => Ok(()),
            Some(modulo) => Err(WrongSyncPosition::NotInTurn {
                field,
                received,
                length: modulo.length(),
            }),
        }
    }

    /// The absolute position for an axis in this state: the next passage, or this number of periods
    /// further.
    pub(super) fn of(&self, axis: &Travel, turns: i32) -> f64 {
        match (*self, axis.modulo) {
            (Self::At(position), _) => position,
            (Self::Ahead(distance), _) => axis.position + axis.ahead.sign() * distance,
            // Refused by `check` before it comes here.
            (Self::InTurn(within), None) => within,
            (Self::InTurn(within), Some(modulo)) => {
                let next = modulo.next(within, axis.position, axis.ahead);
                next + axis.ahead.sign() * f64::from(turns) * modulo.length()
            }
        }
    }

    /// The periods to be tried of these: only the first, for a position that is not within a period.
    pub(super) fn turns(&self, all: &'static [i32]) -> &'static [i32] {
        match self {
            Self::InTurn(_) => all,
            // A position without a period has no other passages.
            Self::At(_) | Self::Ahead(_) => &all[..1],
        }
    }
}

/// Position of an axis, and its forward direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Travel {
    pub(super) position: f64,
    pub(super) ahead: TravelDirection,
    pub(super) modulo: Option<Modulo>,
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for SyncPosition {
    fn schema_name() -> alloc::borrow::Cow<'static, str> {
        "SyncPosition".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let one = |name: &str, meaning: &str| {
            schemars::json_schema!({
                "type": "object",
                "properties": { name: { "type": "number", "description": meaning } },
                "required": [name],
                "additionalProperties": false,
            })
        };
        schemars::json_schema!({
            "description": "Where both are synchronous: a position, u; { ahead = 500 }, so far ahead; or { in-turn = 90 }, \
                within a turn.",
            "anyOf": [
                { "type": "number" },
                one("ahead", "So far ahead of where the axis is, u."),
                one("in-turn", "At this position of a turn, u."),
            ],
        })
    }
}

#[cfg(feature = "serde")]
mod written {
    use core::fmt;

    use serde::de::value::MapAccessDeserializer;
    use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
    use serde::ser::{Serialize, Serializer};

    use super::SyncPosition;

    /// Forms other than a plain number.
    #[derive(serde::Serialize, serde::Deserialize)]
    #[serde(rename_all = "kebab-case")]
    enum Relative {
        Ahead(f64),
        InTurn(f64),
    }

    impl Serialize for SyncPosition {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            match *self {
                Self::At(position) => serializer.serialize_f64(position),
                Self::Ahead(distance) => Relative::Ahead(distance).serialize(serializer),
                Self::InTurn(within) => Relative::InTurn(within).serialize(serializer),
            }
        }
    }

    impl<'de> Deserialize<'de> for SyncPosition {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            deserializer.deserialize_any(Written)
        }
    }

    struct Written;

    impl<'de> Visitor<'de> for Written {
        type Value = SyncPosition;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a position, { ahead = 500 } or { in-turn = 90 }")
        }

        fn visit_f64<E>(self, position: f64) -> Result<SyncPosition, E> {
            Ok(SyncPosition::At(position))
        }

        // Files may have 500 for 500.0. A double holds integers exactly up to 2⁵³.
        fn visit_i64<E>(self, position: i64) -> Result<SyncPosition, E> {
            Ok(SyncPosition::At(position as f64))
        }

        fn visit_u64<E>(self, position: u64) -> Result<SyncPosition, E> {
            Ok(SyncPosition::At(position as f64))
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<SyncPosition, A::Error> {
            Relative::deserialize(MapAccessDeserializer::new(map)).map(|relative| match relative {
                Relative::Ahead(distance) => SyncPosition::Ahead(distance),
                Relative::InTurn(within) => SyncPosition::InTurn(within),
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn knife(position: f64, forward: bool) -> Travel {
        Travel {
            position,
            ahead: if forward {
                TravelDirection::Forward
            } else {
                TravelDirection::Backward
            },
            modulo: Modulo::new(360.0).ok(),
        }
    }

    #[test]
    fn ahead_is_where_the_axis_goes() {
        assert_eq!(SyncPosition::Ahead(500.0).of(&knife(100.0, true), 0), 600.0);
        assert_eq!(
            SyncPosition::Ahead(500.0).of(&knife(100.0, false), 0),
            -400.0
        );
        assert_eq!(SyncPosition::At(7.0).of(&knife(100.0, false), 0), 7.0);
    }

    #[test]
    fn a_position_in_the_turn_is_the_next_one() {
        let at = SyncPosition::InTurn(90.0);
        assert_eq!(at.of(&knife(3_600_100.0, true), 0), 3_600_450.0);
        assert_eq!(at.of(&knife(3_600_100.0, false), 0), 3_600_090.0);
        assert_eq!(at.of(&knife(3_600_100.0, true), -1), 3_600_090.0);
        assert_eq!(at.of(&knife(90.0, true), 1), 810.0);
    }

    #[test]
    fn an_axis_that_does_not_turn_has_none() {
        let at = SyncPosition::InTurn(90.0);
        let refused = at.check("master-sync-position", None).unwrap_err();
        assert_eq!(
            (refused.field(), refused.received()),
            ("master-sync-position", 90.0)
        );
        assert!(
            at.check("master-sync-position", Modulo::new(360.0).ok())
                .is_ok()
        );
        for wrong in [360.0, -1.0, f64::NAN] {
            let at = SyncPosition::InTurn(wrong);
            assert!(
                at.check("master-sync-position", Modulo::new(360.0).ok())
                    .is_err()
            );
        }
        assert!(
            SyncPosition::Ahead(1.0)
                .check("slave-sync-position", None)
                .is_ok()
        );
    }

    proptest! {
        #[test]
        fn it_is_ahead_within_the_turns_tried_and_congruent(
            within in 0.0..360.0f64,
            here in -5e6..5e6f64,
            forward: bool,
            turns in 0..8i32,
        ) {
            let resolved = SyncPosition::InTurn(within).of(&knife(here, forward), turns);
            let ahead = if forward { resolved - here } else { here - resolved };
            let whole = f64::from(turns) * 360.0;
            prop_assert!(ahead > whole - 1e-8 && ahead <= whole + 360.0 + 1e-8, "{ahead}");
            let off = (resolved - within) / 360.0;
            prop_assert!((off - libm::round(off)).abs() * 360.0 < 1e-8, "{off}");
        }
    }
}
