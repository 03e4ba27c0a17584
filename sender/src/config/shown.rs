//! Selection of the axes that a sender shows.

use std::num::NonZeroU32;

use coaxle_node::config::Wrong;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Number of axes in a snapshot, a status and a trace by default.
pub const SHOWN_BY_DEFAULT: usize = 4;

/// Axis ids without duplicates; an empty list leaves the choice to the sender.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Vec<NonZeroU32>")]
#[schemars(inline)]
pub struct ShownAxes(Vec<NonZeroU32>);

impl ShownAxes {
    /// # Errors
    /// [`Wrong`] for a duplicate id.
    pub fn new(ids: Vec<NonZeroU32>) -> Result<Self, Wrong> {
        let twice = |(k, id): (usize, &NonZeroU32)| ids[..k].contains(id).then_some(*id);
        // The order is the user's choice and stays, so that sorting is no way to find duplicates.
        match ids.iter().enumerate().find_map(twice) {
            Some(id) => Err(Wrong::value(format_args!("id {id} twice"), "each id once")),
            None => Ok(Self(ids)),
        }
    }

    /// The ids, in display order.
    #[must_use]
    pub fn ids(&self) -> &[NonZeroU32] {
        &self.0
    }

    /// True if the choice is left to the sender.
    #[must_use]
    pub const fn is_default(&self) -> bool {
        self.0.is_empty()
    }
}

impl TryFrom<Vec<NonZeroU32>> for ShownAxes {
    type Error = Wrong;
    fn try_from(ids: Vec<NonZeroU32>) -> Result<Self, Wrong> {
        Self::new(ids)
    }
}
