//! What a delay exchange says of itself, and of responses it does not use.

use crate::instant::{Seconds, Span};

/// Where a delay comes from, and how far its measurement is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum DelayState {
    /// Nothing is done about it.
    #[default]
    Off,
    /// It was told.
    Fixed,
    /// Requests go out; too few responses came as yet, or none.
    Asking,
    /// It is measured.
    Measured,
    /// It was measured; for some seconds no response came, or none since the line was lost and found again.
    Stale,
}

/// How unequal the ways of a link are, which no exchange can show, as somebody knows it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Asymmetry {
    /// So much longer messages and responses are under way than requests; negative: shorter.
    pub longer: Span,
    /// That is wrong by at most so much, either way.
    pub within: Span,
}

/// What is known of the delay.
#[must_use]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DelayOutput {
    /// Where it comes from, and how far the measurement is.
    pub state: DelayState,
    /// How far the sender's time is ahead of the one that arrives.
    pub delay: Option<Seconds>,
    /// The delay is wrong by at most this, however unequal the ways there and back are: half of the
    /// least round trip, and three standard deviations of the line; and no less than the last exchanges leave open. Where
    /// somebody [stated](Asymmetry) how unequal they are: half of what that is wrong by at most, and three standard deviations, if that
    /// is less.
    pub uncertainty: Option<Seconds>,
    /// What somebody [stated](Asymmetry) cannot be: the ways would differ by more than both take together. It is of no use then.
    pub is_statement_denied: bool,
    /// The part of the error that jitter causes, as a standard deviation. Were the ways equal, there
    /// would be no other.
    pub jitter: Option<Seconds>,
    /// The same with what the line is wrong by: the standard deviation of the delay for who takes the ways for equally long, or
    /// knows their difference.
    pub sigma: Option<Seconds>,
    /// Since the newest exchange.
    pub age: Option<Span>,
    /// Exchanges used.
    pub exchanges: u64,
    /// Responses refused.
    pub refused: u64,
}

/// Why a response was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// An earlier run of the requester asked.
    #[error("the response is for another run of the requester")]
    OtherRun,
    /// Another run of the sender responded than the one that is followed.
    #[error("another run of the sender responded")]
    OtherEpoch,
    /// The request was never made, is answered already, or is too old.
    #[error("no request with this number waits for a response")]
    NotAsked,
    /// A stamp lies more than a second off, or before the one it must follow.
    #[error("a stamp is more than a second off, or out of order")]
    Implausible,
    /// The request and its response would have been under way for less than no time.
    #[error("the round trip would take less than no time")]
    NegativeRoundTrip,
}
