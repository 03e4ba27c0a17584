//! Faults of a link.

use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use coaxle_clock::Span;

use super::checked::{ChangeMicros, FaultMicros, FaultSeconds, Fraction, PeriodSeconds};
use super::clock::JitterConfig;
use super::forgery::Forgery;
use super::list::at_most;
use super::term::{MOST_TERMS, Term};

/// A link's behaviour: the simulated network, or faults applied to a real one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct LinkConfig {
    /// Least time from sending to arrival, µs.
    pub latency_us: FaultMicros,
    /// Random addition to the latency; never negative in sum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jitter: Option<JitterConfig>,
    /// Correlated part of the delay.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub correlated: Option<CorrelatedConfig>,
    /// Resolution of the arrivals, µs: each is seen at the next multiple of it.
    pub resolution_us: FaultMicros,
    /// Rare long delays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spikes: Option<SpikeConfig>,
    /// Share of messages that never arrive.
    pub loss: Fraction,
    /// Losses in bursts, in addition to those.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub burst_loss: Option<BurstLossConfig>,
    /// Share of messages that arrive twice.
    pub duplication: Fraction,
    /// Share of messages that a later one may overtake: they are held back for up to `reorder-us`.
    pub reorder: Fraction,
    /// Longest time an overtaken message is held back, µs.
    pub reorder_us: FaultMicros,
    /// Share of messages in which a bit is flipped, or whose end is missing.
    pub corruption: Fraction,
    /// End of loss, duplication, reordering, spikes and corruption, s after the start. Never by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub faults_until_s: Option<FaultSeconds>,
    /// Changes of the latency at set times.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub delay_steps: Vec<DelayStep>,
    /// Added delay, µs: a sum of terms, at the moment when a message is sent. Noise is drawn for
    /// each message.
    #[serde(
        deserialize_with = "at_most::<MOST_TERMS, _, _>",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub delay_terms_us: Vec<Term<ChangeMicros>>,
    /// Times without any delivery.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub partitions: Vec<Partition>,
    /// Times when messages wait; then all of them arrive at once.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stalls: Vec<Partition>,
    /// Forged messages of an attacker.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub forgeries: Vec<Forgery>,
}

impl LinkConfig {
    /// Resolves the relative paths of its terms' files from `folder`, for example the config's own.
    pub fn relative_to(&mut self, folder: &Path) {
        for term in &mut self.delay_terms_us {
            term.relative_to(folder);
        }
    }

    /// True if messages sent `since_start` are still subject to loss, duplication, reordering,
    /// corruption and spikes.
    #[must_use]
    pub fn is_faulty(&self, since_start: Span) -> bool {
        let until = self.faults_until_s;
        // Excluded: at the end itself the link is well.
        until.is_none_or(|until| since_start < until.span())
    }
}

/// Losses in bursts (Gilbert and Elliott): in a burst every message is lost.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct BurstLossConfig {
    /// Share of the messages outside a burst that start one.
    pub begins: Fraction,
    /// Share of the messages in a burst that end it: the mean length is 1/`ends` messages.
    pub ends: Fraction,
}

/// A correlated delay: normally distributed, with an exponential autocorrelation (Ornstein and
/// Uhlenbeck; AR(1) for messages at equal intervals).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct CorrelatedConfig {
    /// Standard deviation, µs.
    pub sigma_us: FaultMicros,
    /// Time after which its correlation is 1/e, s.
    pub time_s: PeriodSeconds,
}

/// Rare long delays, uniform between two bounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct SpikeConfig {
    /// Share of messages that are hit.
    pub share: Fraction,
    /// Shortest added delay, µs.
    pub from_us: FaultMicros,
    /// Longest added delay, µs.
    pub to_us: FaultMicros,
}

/// A lasting change of the latency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct DelayStep {
    /// Time of the step, s after the start.
    pub at_s: FaultSeconds,
    /// Added latency from then on, µs; the sum never falls below zero.
    pub by_us: ChangeMicros,
}

/// A time without any delivery; in a stall, deliveries are delayed until its end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Partition {
    /// Start, s after the start of the run.
    pub at_s: FaultSeconds,
    /// Duration, s.
    pub for_s: FaultSeconds,
}
