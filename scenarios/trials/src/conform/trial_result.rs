//! Results of listening to a node.

use super::rule::RuleFinding;

/// Result of listening.
pub(super) enum TrialResult {
    /// Findings about the rules.
    Findings(Vec<RuleFinding>),
    /// No message came: the reason, as far as known.
    Nothing(String),
    /// Ended by the user before it was done.
    Interrupted,
}
