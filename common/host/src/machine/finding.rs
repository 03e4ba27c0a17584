//! Findings about this PC.

/// A finding about this PC.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Severity of the finding.
    pub severity: Severity,
    /// Description of the finding.
    pub text: String,
    /// Recommended change, and how to make it.
    pub remedy: Option<&'static str>,
}

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// In order.
    Good,
    /// Cycles would profit from a change.
    Note,
    /// Not fit for cycles.
    Unfit,
}
