//! What came of listening to a node.

use super::rule::Finding;

/// What there is to tell.
pub(super) enum Heard {
    /// What was found.
    Findings(Vec<Finding>),
    /// Nothing came: why, as far as can be told.
    Nothing(String),
    /// Somebody ended it before it was done.
    Interrupted,
}
