//! `position` of a far axis: the count of its set position.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Count of the set position of a far axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Positions {
    /// Continuous beyond the modulo period.
    #[default]
    Continuous,
    /// Restarting with each modulo period, whose length is `modulo`: made continuous by the nearest
    /// period.
    WithinTurn,
}

impl Positions {
    /// True for the default.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
