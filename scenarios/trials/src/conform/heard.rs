//! Results of listening to a node.

use super::rule::Finding;

/// Result of listening.
pub(super) enum Heard {
    /// Findings about the rules.
    Findings(Vec<Finding>),
    /// No message came: the reason, as far as known.
    Nothing(String),
    /// Ended by the user before it was done.
    Interrupted,
}
