//! Results of calls, as the outputs of a method.

use coaxle_node::CommandAnswer;
use coaxle_node::command::CommandVerdict;

/// Outputs of a method.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MethodOutcome {
    /// True if the command was accepted; after a dry run, if it would be.
    pub accepted: bool,
    /// `accepted`, `refused`, `not-taken`, or `no-response`.
    pub outcome: &'static str,
    /// Reason in words; empty if accepted.
    pub text: String,
    /// Error code of a refusal, `0x42dd`; empty without one.
    pub code: String,
    /// Number of the slave's job; 0 without one.
    pub job: u32,
    /// Response of the node as JSON, as `docs/WIRE.md` has it; empty without one.
    pub response: String,
}

impl MethodOutcome {
    /// Outcome by the response of a node.
    #[must_use]
    pub fn of(answer: &CommandAnswer) -> Self {
        let response = answer.to_json();
        match &answer.verdict {
            CommandVerdict::Accepted { job, .. } => Self {
                accepted: true,
                outcome: "accepted",
                job: job.unwrap_or_default(),
                response,
                ..Self::default()
            },
            CommandVerdict::Refused { text, code, .. } => Self {
                outcome: "refused",
                text: text.clone(),
                code: code.clone(),
                response,
                ..Self::default()
            },
            CommandVerdict::NotTaken { text, .. } => Self {
                outcome: "not-taken",
                text: text.clone(),
                response,
                ..Self::default()
            },
        }
    }

    /// Outcome of a call that makes no order.
    #[must_use]
    pub fn not_taken(reason: String) -> Self {
        Self {
            outcome: "not-taken",
            text: reason,
            ..Self::default()
        }
    }

    /// Outcome of an order without a response.
    #[must_use]
    pub fn no_response(reason: String) -> Self {
        Self {
            outcome: "no-response",
            text: reason,
            ..Self::default()
        }
    }
}
