//! The clock of a node, and its injected faults.

use std::path::Path;

use coaxle_clock::Span;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checked::{
    ChangeMicros, FaultMicros, FaultSeconds, FirstCount, PeriodSeconds, Ppm, WalkPpm,
};
use super::common_time::CommonTimeFaults;
use super::list::at_most;
use super::term::{Term, drift_terms};

/// Most steps of a clock.
// Each piece of the clock looks at all steps.
const MOST_STEPS: usize = 128;

/// A deviation injected into a node's clock: linear, periodic, step, random walk, and jitter of
/// its cycles. All zero by default: the machine's own quartz is bad enough in production.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct ClockConfig {
    /// Constant drift, ppm. Positive: the node's clock runs fast, its cycles are short.
    pub drift_ppm: Ppm,
    /// Random walk of the drift, ppm per √s.
    pub random_walk_ppm: WalkPpm,
    /// A periodic drift, as day and night make it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sine: Option<SineConfig>,
    /// Changes of drift or phase at set times.
    #[serde(
        deserialize_with = "at_most::<MOST_STEPS, _, _>",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub steps: Vec<DriftStep>,
    /// Added drift, ppm: a sum of terms, in pieces of 10 ms with the mean of each. Noise is drawn
    /// for each piece.
    #[serde(
        deserialize_with = "drift_terms",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub drift_terms_ppm: Vec<Term<Ppm>>,
    /// Jitter of each wake-up around its ideal instant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jitter: Option<JitterConfig>,
    /// Faults of the time that it has in common with other nodes.
    #[serde(skip_serializing_if = "CommonTimeFaults::is_none")]
    pub common_time: CommonTimeFaults,
    /// Delay of the first cycle after the node's start, µs.
    pub start_phase_us: FaultMicros,
    /// The count of its first cycle: for tests near the wrap of a counter, or beyond the
    /// nanoseconds that f64 represents exactly.
    #[serde(skip_serializing_if = "FirstCount::is_zero")]
    pub first_count: FirstCount,
}

impl ClockConfig {
    /// Resolves the relative paths of its terms' files from `folder`, for example the config's own.
    pub fn relative_to(&mut self, folder: &Path) {
        for term in &mut self.drift_terms_ppm {
            // An absolute path stays as it is.
            term.relative_to(folder);
        }
    }

    /// Delay of the first cycle after the node's start.
    #[must_use]
    pub fn start_phase(&self) -> Span {
        self.start_phase_us.span()
    }
}

/// A periodic drift: `amplitude · sin(2π·t/period)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct SineConfig {
    /// Largest deviation from the mean drift, ppm.
    pub amplitude_ppm: Ppm,
    /// Length of one swing, s.
    pub period_s: PeriodSeconds,
}

/// A sudden change.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct DriftStep {
    /// Time of the step, s after the start.
    pub at_s: FaultSeconds,
    /// Added drift from then on, ppm.
    #[serde(default)]
    pub drift_ppm: Ppm,
    /// Jump of the clock, forward or back, µs. After a jump forward a node skips the cycles it has
    /// missed; after a jump back it waits until its clock reaches the start of its next cycle
    /// again.
    #[serde(default)]
    pub phase_us: ChangeMicros,
}

/// Jitter of the wake-ups, µs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum JitterConfig {
    /// Gaussian around the ideal instant: standard deviation.
    NormalUs(FaultMicros),
    /// Late by an exponential time: mean.
    ExponentialUs(FaultMicros),
    /// Late by anything up to this.
    UniformUs(FaultMicros),
}
