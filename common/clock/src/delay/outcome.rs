//! Reports of a delay exchange, and its refusals of responses.

use crate::instant::{Seconds, Span};

/// Source of a delay, and progress of its measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum DelayState {
    /// Not compensated.
    #[default]
    Off,
    /// Configured.
    Fixed,
    /// Sending requests; too few responses came as yet, or none.
    Asking,
    /// Measured.
    Measured,
    /// Measured, but for some seconds no response came, or none since the line was lost and found again.
    Stale,
}

/// Stated asymmetry of the ways of a link, which no exchange can show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Asymmetry {
    /// Excess of the ways of messages and responses over those of requests; negative: shorter.
    pub longer: Span,
    /// Greatest error of that, either way.
    pub within: Span,
}

/// Delay and its uncertainty.
#[must_use]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DelayOutput {
    /// Source of the delay, and progress of the measurement.
    pub state: DelayState,
    /// Sender's lead over the time that arrives.
    pub delay: Option<Seconds>,
    /// Greatest error of the delay, however unequal the ways there and back are: half of the least round trip, and three standard
    /// deviations of the line; and no less than the last exchanges leave open. Where the asymmetry is [stated](Asymmetry): half of its
    /// greatest error, and three standard deviations, if that is less.
    pub uncertainty: Option<Seconds>,
    /// True if the [stated](Asymmetry) asymmetry is impossible, and of no use: the ways would differ by more than their sum.
    pub is_statement_denied: bool,
    /// The part of the error that jitter causes, as a standard deviation. Were the ways equal, there
    /// would be no other.
    pub jitter: Option<Seconds>,
    /// Standard deviation of the delay where the ways are equally long or their difference is known: jitter together with the
    /// error of the line.
    pub sigma: Option<Seconds>,
    /// Time since the newest exchange.
    pub age: Option<Span>,
    /// Exchanges used.
    pub exchanges: u64,
    /// Responses refused.
    pub refused: u64,
}

/// Reason why a response was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// The request was of an earlier run of the requester.
    #[error("the response is for another run of the requester")]
    OtherRun,
    /// Another run of the sender responded than the one that is followed.
    #[error("another run of the sender responded")]
    OtherEpoch,
    /// The request was never made, has its response already, or is too old.
    #[error("no request with this number waits for a response")]
    NotAsked,
    /// A stamp lies more than a second off, or before the one it must follow.
    #[error("a stamp is more than a second off, or out of order")]
    Implausible,
    /// The request and its response would have been under way for less than no time.
    #[error("the round trip would take less than no time")]
    NegativeRoundTrip,
}
