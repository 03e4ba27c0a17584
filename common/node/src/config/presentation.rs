//! `present-after-ms` of an axis: a figure, or what its followers need.

use std::borrow::Cow;

use coaxle_clock::Span;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use toml::Value;

use super::{PresentAfterMs, Wrong};

/// Time after its generation at which everybody shows an axis: milliseconds, or `"auto"`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Value", into = "Value")]
pub enum PresentAfterChoice {
    /// As given.
    Fixed(PresentAfterMs),
    /// As long as the followers need that report it.
    Auto,
}

/// Limits of a delay that followers decide.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct PresentAfterLimits {
    /// The shortest one, ms: for followers behind followers, which report nothing here. The cycle time by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_least_ms: Option<PresentAfterMs>,
    /// The longest one, ms: whatever the master does is seen so much later. 4000 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_most_ms: Option<PresentAfterMs>,
}

/// Delays by which an axis may be shown later: one, or what its followers decide between two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PresentAfterRange {
    /// The shortest one.
    pub least: Span,
    /// The longest one.
    pub most: Span,
}

impl PresentAfterChoice {
    const EXPECTED: &str = "\"auto\", or a number from 0.1 to 4000";

    /// Checks the limits of the choice, and returns the delays that it permits.
    ///
    /// # Errors
    /// [`Wrong`] for limits of a figure, or without a delay between them.
    pub fn within(self, limits: Option<PresentAfterLimits>) -> Result<PresentAfterRange, Wrong> {
        let limits = match (self, limits) {
            (Self::Fixed(delay), None) => return Ok(PresentAfterRange::only(delay.span())),
            (Self::Fixed(delay), Some(_)) => {
                let received = format!("limits beside {} ms", delay.get());
                return Err(Wrong::value(
                    received,
                    "present-after-ms = \"auto\" with limits",
                ));
            }
            (Self::Auto, limits) => limits.unwrap_or_default(),
        };
        let range = PresentAfterRange {
            least: limits.at_least_ms.map_or(Span::ZERO, PresentAfterMs::span),
            most: (limits.at_most_ms).map_or(PresentAfterRange::LONGEST, PresentAfterMs::span),
        };
        if range.least > range.most {
            let [least, most] = [range.least, range.most].map(|delay| delay.as_micros_f64() / 1e3);
            let received = format!("at least {least} and at most {most} ms");
            return Err(Wrong::value(received, "the least below the most"));
        }
        Ok(range)
    }
}

impl PresentAfterRange {
    /// The longest delay of all.
    pub const LONGEST: Span = Span::from_secs(4);

    /// Permits one delay alone.
    #[must_use]
    pub const fn only(delay: Span) -> Self {
        Self {
            least: delay,
            most: delay,
        }
    }

    /// True if the followers decide.
    #[must_use]
    pub fn is_led(&self) -> bool {
        self.least < self.most
    }

    /// The permitted delay next to this one.
    #[must_use]
    pub fn nearest(&self, delay: Span) -> Span {
        delay.clamp(self.least, self.most)
    }
}

impl TryFrom<Value> for PresentAfterChoice {
    type Error = Wrong;

    fn try_from(value: Value) -> Result<Self, Wrong> {
        let number = match &value {
            Value::String(word) if word == "auto" => return Ok(Self::Auto),
            Value::Integer(number) => *number as f64,
            Value::Float(number) => *number,
            _ => return Err(Wrong::value(value.to_string(), Self::EXPECTED)),
        };
        PresentAfterMs::new(number).map(Self::Fixed)
    }
}

impl From<PresentAfterChoice> for Value {
    fn from(choice: PresentAfterChoice) -> Self {
        match choice {
            PresentAfterChoice::Auto => Self::String("auto".to_owned()),
            PresentAfterChoice::Fixed(delay) => Self::Float(delay.get()),
        }
    }
}

impl JsonSchema for PresentAfterChoice {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "PresentAfterChoice".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "anyOf": [
                { "enum": ["auto"] },
                { "type": "number", "minimum": 0.1, "maximum": 4000 },
            ],
        })
    }
}
