//! `position` of a far axis: how its set position counts.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the set position of a far axis counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Positions {
    /// It goes on beyond the turn.
    #[default]
    Continuous,
    /// It begins again with every turn, whose length is `modulo`: it is made continuous, by the nearest turn.
    WithinTurn,
}

impl Positions {
    /// Whether it is the default.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
