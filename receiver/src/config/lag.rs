//! `lag-ms`: how far behind their generation the axes of a far node are evaluated, of the time by which they are shown
//! later.

use coaxle_clock::Span;
use coaxle_node::config::{PresentAfterMs, Wrong};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Value;

/// Lag of axes that are shown later: `"full"` (default), `"auto"`, or milliseconds.
///
/// The rest of the time by which they are shown later is the hold-back of the slaves: followers of this node have it
/// for their own way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Value", into = "Value")]
pub enum Lag {
    /// All of it. Nothing is held back, so a command to a slave is seen at once, and a frame may take as long as can be:
    /// right for a node without followers, which has no use for a hold-back.
    #[default]
    Full,
    /// Time that the frames of the last minute needed, and a margin.
    Auto,
    /// As given.
    Fixed(PresentAfterMs),
}

impl Lag {
    /// Expected values.
    const EXPECTED: &str = "\"full\", \"auto\", or a number from 0.1 to 4000";

    /// The lag, given the measured one, and the time that drives take of a full one; none if the measured one is needed and not known yet.
    #[must_use]
    pub fn of(self, delay: Span, measured: Option<Span>, dead_time: Span) -> Option<Span> {
        match self {
            // Otherwise the drives would be given predictions of what is known.
            Self::Full => Some((delay - dead_time).max(Span::ZERO)),
            Self::Auto => Some(measured?.min(delay)),
            Self::Fixed(lag) => Some(lag.span().min(delay)),
        }
    }
}

impl TryFrom<Value> for Lag {
    type Error = Wrong;

    fn try_from(value: Value) -> Result<Self, Wrong> {
        let wrong = || Wrong::value(value.to_string(), Self::EXPECTED);
        let number = match &value {
            Value::String(word) if word == "full" => return Ok(Self::Full),
            Value::String(word) if word == "auto" => return Ok(Self::Auto),
            Value::Integer(number) => *number as f64,
            Value::Float(number) => *number,
            _ => return Err(wrong()),
        };
        PresentAfterMs::new(number)
            .map(Self::Fixed)
            .map_err(|_| wrong())
    }
}

impl From<Lag> for Value {
    fn from(lag: Lag) -> Self {
        match lag {
            Lag::Full => Self::String("full".to_owned()),
            Lag::Auto => Self::String("auto".to_owned()),
            Lag::Fixed(lag) => Self::Float(lag.get()),
        }
    }
}

impl JsonSchema for Lag {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Lag".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "anyOf": [
                { "enum": ["full", "auto"] },
                { "type": "number", "minimum": 0.1, "maximum": 4000 },
            ],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::ReceiverConfig;
    use crate::config::test_config::config;

    #[test]
    fn it_is_all_by_default_a_figure_or_what_is_needed() {
        for (text, expected) in [
            ("", "Full"),
            ("lag-ms = 'full'", "Full"),
            ("lag-ms = 'auto'", "Auto"),
            ("lag-ms = 12", "Fixed(PresentAfterMs(12.0))"),
            ("lag-ms = 0.5", "Fixed(PresentAfterMs(0.5))"),
        ] {
            for form in [
                format!("master.node = 'a'\n{text}"),
                format!("[[far]]\nnode = 'a'\n{text}"),
            ] {
                let form = match form.starts_with("master") {
                    true => form.lines().rev().collect::<Vec<_>>().join("\n"),
                    false => form,
                };
                let config = config(&form).expect(&form);
                assert_eq!(format!("{:?}", config.far[0].lag_ms), expected);
                let written = toml::to_string(&config).expect("a text");
                let read = coaxle_node::config::parse::<ReceiverConfig>("r.toml", &written);
                assert_eq!(read.expect("a config"), config);
            }
        }
    }

    #[test]
    fn what_is_no_lag_is_refused_with_the_field() {
        for received in ["0", "4001", "-3", "nan", "'soon'", "true", "[1]"] {
            let error = config(&format!("[[far]]\nnode = 'a'\nlag-ms = {received}")).unwrap_err();
            assert!(error.contains("lag-ms: received "), "{error}");
            assert!(error.contains(Lag::EXPECTED), "{error}");
        }
        let error = config("lag-ms = 3\n[[far]]\nnode = 'a'").unwrap_err();
        assert!(
            error.contains("lag-ms: received one beside [[far]]"),
            "{error}"
        );
    }

    #[test]
    fn it_is_never_longer_than_the_delay() {
        let (delay, long) = (Span::from_millis(20), Span::from_millis(50));
        let fixed = |ms| Lag::Fixed(PresentAfterMs::new(ms).unwrap());
        for (lag, measured, expected) in [
            (Lag::Full, None, Some(delay)),
            (Lag::Auto, None, None),
            (Lag::Auto, Some(long), Some(delay)),
            (
                Lag::Auto,
                Some(Span::from_millis(7)),
                Some(Span::from_millis(7)),
            ),
            (fixed(3.0), None, Some(Span::from_millis(3))),
            (fixed(30.0), Some(long), Some(delay)),
        ] {
            assert_eq!(lag.of(delay, measured, Span::ZERO), expected, "{lag:?}");
        }
        let full = |dead_time| Lag::Full.of(delay, None, Span::from_millis(dead_time));
        assert_eq!(full(4), Some(Span::from_millis(16)));
        assert_eq!(full(30), Some(Span::ZERO));
    }
}
