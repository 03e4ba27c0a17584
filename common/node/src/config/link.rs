//! What a link does to messages.

use serde::{Deserialize, Serialize};

use super::checked::{ChangeMicros, FaultMicros, FaultSeconds, Fraction};
use super::clock::JitterConfig;

/// A link's behaviour: the simulated network, or faults laid over a real one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct LinkConfig {
    /// Least time from sending to arrival, µs.
    pub latency_us: FaultMicros,
    /// What is added to it at random; never negative in sum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jitter: Option<JitterConfig>,
    /// Rare long delays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spikes: Option<SpikeConfig>,
    /// Share of messages that never arrive.
    pub loss: Fraction,
    /// Share of messages that arrive twice.
    pub duplication: Fraction,
    /// Share of messages that a later one may overtake: they are held back for up to `reorder-us`.
    pub reorder: Fraction,
    /// How long an overtaken message is held back at most, µs.
    pub reorder_us: FaultMicros,
    /// When loss, duplication, reordering and spikes end, s after the start. Never by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub faults_until_s: Option<FaultSeconds>,
    /// Changes of the latency at set times.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub delay_steps: Vec<DelayStep>,
    /// Times when nothing gets through.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub partitions: Vec<Partition>,
}

/// Rare long delays, uniform between two bounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct DelayStep {
    /// When, s after the start.
    pub at_s: FaultSeconds,
    /// What is added to the latency from then on, µs; the sum never falls below zero.
    pub by_us: ChangeMicros,
}

/// A time when nothing gets through.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Partition {
    /// From when, s after the start.
    pub at_s: FaultSeconds,
    /// For how long, s.
    pub for_s: FaultSeconds,
}
