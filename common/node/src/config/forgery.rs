//! Forged contents of messages.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checked::{CycleMicros, FaultSeconds, Finite};
use super::wrong::Wrong;

/// Forged messages of an attacker, sent after each genuine message within a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Forgery {
    /// From when, s after the start.
    pub at_s: FaultSeconds,
    /// For how long, s. By default one message is forged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub for_s: Option<FaultSeconds>,
    /// Kind of forgery.
    pub what: Forged,
    /// Number of forged messages after each genuine one.
    #[serde(default)]
    pub times: Times,
    /// The genuine message does not arrive.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub instead: bool,
}

/// The difference in a forged message. All but the noise are of the right form, with a right check
/// sum; of messages that are not axes, only noise and repetitions are forged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Forged {
    /// Random bytes.
    Noise,
    /// The first message of the link, once more.
    FirstAgain,
    /// Another run of the node, as a second node of its name would be.
    OtherRun,
    /// Another node's name.
    OtherNode,
    /// Sealed for another key.
    OtherKey,
    /// Another format version.
    OtherVersion,
    /// Axes with other ids.
    OtherAxes,
    /// Another cycle time, µs.
    CycleTimeUs(CycleMicros),
    /// A count ahead by this number.
    CountAhead(Finite),
    /// Set values that are not numbers.
    NotFinite,
    /// The next message, before its time, with positions ahead by this distance, u.
    PositionAhead(Finite),
    /// Axes with this error code.
    AxisError(u32),
}

/// Number of messages, 1 to 1000.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "u32", into = "u32")]
#[schemars(inline, extend("minimum" = 1, "maximum" = 1_000))]
pub struct Times(u32);

impl Times {
    /// The number.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }
}

impl Default for Times {
    fn default() -> Self {
        Self(1)
    }
}

impl TryFrom<u32> for Times {
    type Error = Wrong;

    fn try_from(times: u32) -> Result<Self, Wrong> {
        // A thousand for each genuine one at 1 kHz is a flood of a million a second.
        if (1..=1_000).contains(&times) {
            Ok(Self(times))
        } else {
            Err(Wrong::value(times, "1 to 1000"))
        }
    }
}

impl From<Times> for u32 {
    fn from(times: Times) -> Self {
        times.0
    }
}
